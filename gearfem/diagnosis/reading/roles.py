"""Which records are fitted and which are held out, where the campaign does not say."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from gearfem.diagnosis.reading.quantities import Quantity

Role = Literal["fit", "holdout"]
ROLES: dict[Role, str] = {"fit": "fitted", "holdout": "held out"}
Condition = tuple[Quantity, float, float]
# Fewer than two torques, or two speeds, left to fit decide nothing about how an effect grows.
ENOUGH = 3


def share_roles(given: Sequence[Role | None], conditions: Sequence[Condition]) -> tuple[list[Role], list[str]]:
    """Return the role of every record, and a sentence for each decision that the campaign left open.

    Parameters
    ----------
    given : sequence of {"fit", "holdout", None}
        Roles as the campaign names them.
    conditions : sequence of (Quantity, float, float)
        Quantity, torque [N m] and speed [rad/s] of each record.

    Returns
    -------
    roles : list
        "fit" or "holdout".
    decisions : list of str
        Empty where the campaign decides.

    Notes
    -----
    Of the slow records the second highest torque is set aside, of those at speed the second highest speed: both lie inside the
    range that is left. Each needs three values, and is left alone where the campaign holds out one of its kind already.
    """
    roles: list[Role] = [role or "fit" for role in given]
    why = [""] * len(roles)
    for moving, word in ((False, "torque"), (True, "speed")):
        kind = [i for i, (quantity, _, _) in enumerate(conditions) if quantity.axis == "angle" and quantity.moving == moving]
        level = {i: conditions[i][2] if moving else conditions[i][1] for i in kind}
        values = sorted(set(level.values()))
        held = any(given[i] == "holdout" for i in kind)
        chosen = values[-2] if len(values) >= ENOUGH and not held else None
        for i in kind:
            if given[i] is None and level[i] == chosen:
                roles[i] = "holdout"
                why[i] = f"held out by the program: its {word} lies inside the range of the others"
    for i, role in enumerate(given):
        if role is None and not why[i]:
            why[i] = "used for the fit by the program: the campaign names no role"
    return roles, why
