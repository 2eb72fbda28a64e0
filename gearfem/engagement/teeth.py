"""The compliance of all pairs at their contact points: tables of the gears, read where the teeth touch."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from gearfem.compliance.record import Compliance, ToothCompliance
from gearfem.compliance.same_tooth import likeness
from gearfem.definition.setup import Member
from gearfem.engagement.record import Contacts
from gearfem.flank.outline import ROUND
from gearfem.foundation import Array, Record, SolveError


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class PairCompliance(Record):
    """Linear compliance between all pairs, contact left out.

    Parameters
    ----------
    linear : ndarray, shape (n, p, p)
        linear[a, j, k]: approach of the centrelines of pair j along its load line, per line load on pair k
        [m per N/m], at angle a. The diagonal is the bending and body compliance of both teeth.
    depth1, depth2 : ndarray, shape (n, p)
        Depths of the half spaces that yield as the two teeth do between each contact and their centrelines [m].
    """

    linear: Array
    depth1: Array
    depth2: Array


def read_compliance(compliance: Compliance, contacts: Contacts) -> PairCompliance:
    """Read the compliance tables of both gears at the contact points.

    Parameters
    ----------
    compliance : Compliance
        Tables of both gears.
    contacts : Contacts
        Contact points of p pairs at n angles.

    Returns
    -------
    PairCompliance

    Raises
    ------
    SolveError
        If two pairs reach each other that the tables do not couple.

    Notes
    -----
    A pair that touches at two places stands in the contacts twice: the deflection of each place under a load on the other is the mean of
    both, times how alike loads there move the tooth (`likeness`).

    The next pinion tooth follows behind the loaded flank (offset -1 in the tables), the next wheel tooth on
    its side (offset +1): the pinion's working flank leads its tooth, the wheel's trails it.
    """
    linear1, depth1 = _read(compliance, "pinion", contacts.u1, contacts, sense=-1)
    linear2, depth2 = _read(compliance, "wheel", contacts.u2, contacts, sense=+1)
    return PairCompliance(linear=linear1 + linear2, depth1=depth1, depth2=depth2)


def _read(compliance: Compliance, member: Member, u: Array, contacts: Contacts, sense: int) -> tuple[Array, Array]:
    usual, odd = compliance.of(member), compliance.odd(member)
    tables = [odd.get(pair % usual.outline.gear.teeth, usual) for pair in contacts.pairs]
    if any(own.u.size != usual.u.size for own in tables):
        raise SolveError(f"the compliance tables of the {member}'s single teeth stand at other positions than those of the others")
    weights = _weights(usual.u, u)
    linear = np.zeros((*u.shape, len(tables)))
    for j, own in enumerate(tables):
        linear[:, j, j] = weights[:, j] @ own.deflection
        for k, loaded in enumerate(tables):
            both = contacts.reach[:, j] & contacts.reach[:, k]
            if j == k or not both.any():
                continue
            offset = sense * (contacts.pairs[j] - contacts.pairs[k])
            if offset == 0:
                alike = np.einsum("ai,ij,aj->a", weights[:, j], likeness(own), weights[:, k])
                linear[:, j, k] = alike * np.sqrt((weights[:, j] @ own.deflection) * (weights[:, k] @ own.deflection))
                continue
            if offset not in usual.offsets:
                raise SolveError(f"the compliance tables do not couple teeth {abs(offset)} pitches apart, which touch at one time")
            coupling = _coupling(usual, loaded, offset)
            if own is not usual:
                # Reciprocity: what an odd tooth sees of its neighbour is what the neighbour sees of it.
                coupling = coupling + (_coupling(usual, own, -offset) - _coupling(usual, usual, -offset)).T
            linear[:, j, k] = np.einsum("ai,ij,aj->a", weights[:, j], coupling, weights[:, k])
    return linear, np.stack([weights[:, j] @ own.local_depth for j, own in enumerate(tables)], axis=-1)


def _coupling(usual: ToothCompliance, loaded: ToothCompliance, offset: int) -> Array:
    """Return what a neighbour sees of a loaded tooth, shape (n, n)."""
    table: Array = loaded.coupling[usual.offsets.index(offset)]
    return table


def _weights(nodes: Array, u: Array) -> NDArray[np.float64]:
    """Return the matrix (..., n) that interpolates nodal values: cubic splines that meet where the round begins.

    Values have a kink there, since the load's direction starts to turn.
    """
    if u.min() < nodes[0] - 1e-12 or u.max() > nodes[-1] + 1e-12:
        raise SolveError(f"contact at u = {u.min():.4f} to {u.max():.4f}, outside the compliance table [{nodes[0]:.4f}, {nodes[-1]:.4f}]")
    weights = np.zeros((*u.shape, len(nodes)))
    split = int(np.searchsorted(nodes, ROUND - 1e-12))
    for part, inside in ((slice(0, split + 1), u <= nodes[split]), (slice(split, None), u > nodes[split])):
        piece = nodes[part]
        if inside.any():
            weights[inside, part] = CubicSpline(piece, np.eye(len(piece)))(u[inside])
    return weights
