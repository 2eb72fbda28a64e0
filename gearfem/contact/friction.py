"""Coulomb friction between the flanks."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from gearfem.contact.arguments import finite, not_negative
from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Coulomb(Record):
    """Friction in proportion to the normal force, against the sliding.

    Notes
    -----
    F_t = f P sign(v_sl), v_sl = v_t1 - v_t2 (Wojnarowski & Onishchenko 2003, eq. 24): positive where the pinion
    is held back. Without sliding, at the pitch point, the law leaves any force up to f P open; 0 is returned.
    """

    def force(self, normal_force: ArrayLike, sliding_velocity: ArrayLike, coefficient: ArrayLike) -> Array:
        """Return the friction force.

        Parameters
        ----------
        normal_force : array_like, shape (...)
            Normal force P [N] (or per face width, or per unit torque), not negative.
        sliding_velocity : array_like, shape (...)
            Sliding velocity v_sl of the pinion on the wheel; only its sign counts.
        coefficient : array_like, shape (...)
            Coefficient of friction f, not negative.

        Returns
        -------
        ndarray, shape (...)
            Friction force in the unit of the normal force, with the sign of the sliding velocity.

        Raises
        ------
        InputError
            If force or coefficient is negative, or one of the three is not finite.

        Examples
        --------
        >>> Coulomb().force(100.0, [-0.5, 0.0, 0.5], 0.1).tolist()
        [-10.0, 0.0, 10.0]
        """
        force, coefficient = not_negative("normal_force", normal_force), not_negative("coefficient", coefficient)
        return coefficient * force * np.sign(finite("sliding_velocity", sliding_velocity))
