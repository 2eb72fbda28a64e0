"""Models as users ask for them: a definition whose flanks have been tried, so that reading refuses what cannot mesh."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from gearfem.definition.model_file import define, origin, read_model
from gearfem.definition.setup import Setup
from gearfem.effects.catalogue import read_effects
from gearfem.effects.effect import Effect
from gearfem.flank import make_flanks
from gearfem.foundation import InputError


def load_model(path: str | Path, overrides: Iterable[str] = (), effects: Iterable[type[Effect]] = ()) -> Setup:
    """Read a gear pair from a model file.

    Parameters
    ----------
    path : str or Path
        Model file in TOML.
    overrides : iterable of str
        "dotted.key=value" with the value spelt as in TOML; each replaces a key of the file.
    effects : iterable of type
        Effects from outside the catalogue that the file may name.

    Returns
    -------
    Setup
        In SI, every default resolved; what was assumed is in `assumptions`.

    Raises
    ------
    InputError
        One line with file, key, what was found and what is allowed; also for pointed tips and flanks that interfere.

    Examples
    --------
    >>> setup = load_model("studies/coal_combine/model.toml", ["pair.face_width_mm=60"])
    >>> setup.pair.face_width, round(setup.pair.contact_ratio, 4)
    (0.06, 1.1455)
    """
    changes = tuple(overrides)
    setup = read_model(path, partial(read_effects, extra=tuple(effects)), changes)
    try:
        make_flanks(setup)
    except InputError as error:
        raise error.in_file(origin(path, changes, error)) from None
    return setup


def make_setup(mapping: Mapping[str, Any], effects: Iterable[type[Effect]] = ()) -> Setup:
    """Make a gear pair from the tables and keys of a model file.

    Parameters
    ----------
    mapping : mapping
        Nested as the file's tables, values in the units that end the keys.
    effects : iterable of type
        Effects from outside the catalogue that it may name.

    Returns
    -------
    Setup
        As from `load_model`.

    Raises
    ------
    InputError
        One line with key, what was found and what is allowed.

    Examples
    --------
    >>> setup = make_setup({
    ...     "pair": {"module_mm": 3.0, "face_width_mm": 30.0},
    ...     "pinion": {"teeth": 35},
    ...     "wheel": {"teeth": 36},
    ...     "operation": {"pinion_torque_Nm": 75.4, "pinion_speed_rpm": 1500.0},
    ... })
    >>> round(setup.pair.centre_distance * 1e3, 6), round(setup.operation.wheel_torque, 3)
    (106.5, 77.554)
    """
    setup = define(mapping, partial(read_effects, extra=tuple(effects)))
    make_flanks(setup)
    return setup
