"""Far below the contact the exact approach becomes the logarithm of the textbooks."""

from __future__ import annotations

import numpy as np

from gearfem.contact import HertzLine
from gearfem.definition.setup import Material


def test_deep_points_follow_johnson_and_weber_banaschek():
    nu, modulus, load, radius = 0.3, 206e9, 2e5, 15e-3
    law = HertzLine(pinion=Material(), wheel=Material())
    a = float(law.half_width(load, radius))
    ratio = np.array([5.0, 10.0, 20.0, 40.0, 80.0])
    factor = load * (1.0 - nu**2) / (np.pi * modulus)
    textbook = 2.0 * factor * (2.0 * np.log(2.0 * ratio) - nu / (1.0 - nu))
    missing = (law.approach(load, radius, ratio * a, ratio * a) - textbook) / (4.0 * factor)
    order = np.diff(np.log(missing)) / np.diff(np.log(1.0 / ratio))
    # First term left out: (1/4 + nu/(8 (1 - nu))) (a/d)^2; the next is of fourth order, (a/d)^2 smaller.
    np.testing.assert_allclose(missing[-1] * ratio[-1] ** 2, 0.25 + nu / (8.0 * (1.0 - nu)), rtol=1.0 / ratio[-1] ** 2)
    np.testing.assert_allclose(order, 2.0, atol=2.0 / ratio[0] ** 2)
