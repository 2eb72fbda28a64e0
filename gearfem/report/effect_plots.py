"""Before and after: what the effects of a model do to the slowly turning gears."""

from __future__ import annotations

import dataclasses

import numpy as np
from matplotlib.figure import Figure

from gearfem.assembly import assemble
from gearfem.effects import Effect
from gearfem.foundation.units import UM
from gearfem.pipeline import Results
from gearfem.report import style
from gearfem.sensing.motion import slowly

ANGLES_PER_PITCH = 60


def has_effects(results: Results) -> bool:
    """Return whether the model names effects and was assembled."""
    return results.system is not None and any(isinstance(effect, Effect) for effect in results.setup.effects)


@style.styled
def plot_effects(results: Results) -> Figure:
    """Draw the transmission error over whole turns of the pinion, without and with the effects of the model, and the change.

    Parameters
    ----------
    results : Results
        With its compliance.

    Returns
    -------
    Figure
        Over as many turns as bring every tooth into contact.
    """
    setup = results.setup
    pair, torque = setup.pair, setup.operation.pinion_torque
    turns = max(1, int(np.ceil(pair.ratio)))
    angle = np.linspace(0.0, 2.0 * np.pi * turns, turns * pair.pinion.teeth * ANGLES_PER_PITCH + 1)
    figure, (upper, lower) = style.make_figure((7.5, 5.0), rows=2)
    before, after = (
        slowly(assemble(dataclasses.replace(setup, effects=effects)), angle, torque).transmission_error / UM
        for effects in ((), setup.effects)
    )
    x = angle / (2.0 * np.pi)
    upper.plot(x, before, color=style.GREY, linewidth=0.8, label="without effects")
    upper.plot(x, after, color=style.BLUE, linewidth=0.9, label="with effects")
    lower.plot(x, after - before, color=style.BLUE, linewidth=0.9)
    upper.set_ylabel("transmission error, µm")
    lower.set_ylabel("change, µm")
    lower.set_xlabel("turns of the pinion")
    figure.align_ylabels()
    style.legend_below(figure, upper)
    return figure
