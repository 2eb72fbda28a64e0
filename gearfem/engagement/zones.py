"""Zones of the unloaded pair: which pair of teeth touches first, and how far behind its neighbour is."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from gearfem.engagement.record import Contacts
from gearfem.foundation import Array, InputError, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Zones(Record):
    """Order in which pairs touch over the pinion angle, without load.

    Parameters
    ----------
    pinion_angle : ndarray, shape (n,)
        Angles [rad].
    first, neighbour : ndarray of int, shape (n,)
        Numbers of the pair that touches first and of the next one.
    backlash : ndarray, shape (n,)
        Backlash L_S of that neighbour along the line of action [m]; where no other pair is in reach, a bound that no load closes.
    in_reach : ndarray of bool, shape (n,)
        Whether the neighbour is in reach at all.
    changes : ndarray, shape (m,)
        Angles at which another pair becomes the first [rad].
    """

    pinion_angle: Array
    first: NDArray[np.intp]
    neighbour: NDArray[np.intp]
    backlash: Array
    in_reach: NDArray[np.bool_]
    changes: Array


def unloaded_zones(contacts: Contacts, tolerance: float = 1e-12) -> Zones:
    """Return the zones of the unloaded pair.

    Parameters
    ----------
    contacts : Contacts
        Of all pairs in reach at increasing angles; two pairs or more.
    tolerance : float
        Gaps that differ by less [m] are alike; the pair that came first then counts as first.

    Returns
    -------
    Zones

    Raises
    ------
    InputError
        If there are fewer than two pairs.

    Notes
    -----
    Wojnarowski & Onishchenko (2003), end of section 2: where L_S is small both pairs carry (a zone of two pairs), where
    load does not close it one does. Between two angles the change lies where the two gaps, taken as straight, cross.
    """
    contacts = contacts.first
    if len(contacts.pairs) < 2:
        raise InputError("pairs", len(contacts.pairs), "two pairs or more: the backlash of a neighbour is asked for")
    order = np.argsort(
        np.where(contacts.gap - contacts.gap.min(axis=1, keepdims=True) < tolerance, -1.0, contacts.gap), axis=1, kind="stable"
    )
    rows, pairs = np.arange(len(order)), np.asarray(contacts.pairs)
    first, second = order[:, 0], order[:, 1]
    turn = np.flatnonzero(np.diff(first))
    before, after = first[turn], first[turn + 1]
    lead = contacts.gap[turn, after] - contacts.gap[turn, before]
    trail = contacts.gap[turn + 1, before] - contacts.gap[turn + 1, after]
    part = np.where(lead + trail > 0.0, lead / np.where(lead + trail > 0.0, lead + trail, 1.0), 0.5)
    angle = contacts.pinion_angle
    return Zones(
        pinion_angle=angle,
        first=pairs[first],
        neighbour=pairs[second],
        backlash=contacts.gap[rows, second] - contacts.gap[rows, first],
        in_reach=contacts.reach[rows, second],
        changes=angle[turn] + part * (angle[turn + 1] - angle[turn]),
    )
