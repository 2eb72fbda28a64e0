"""Tables of the distinct pairs of a record side by side, as the compiled loops read them; tables are kept by their content."""

from __future__ import annotations

import dataclasses
import math
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from gearfem.engagement.engage import Mesh
from gearfem.engagement.grid import LEVEL, levels
from gearfem.engagement.pair_table import CouplingTable, PairTable, beside, coupling_table, pair_table, way_of
from gearfem.foundation import Array

Table = TypeVar("Table")
Ints = NDArray[np.int64]

BINS = 1024
# A fine table takes 2 MB, a way or a coupling little: 0.8 GB at most. Derivatives and trials of a fit need some hundred by turns.
KEPT = 400
_memory: OrderedDict[Hashable, Any] = OrderedDict()


class Kind(NamedTuple):
    """Digests of a tooth: of its outline and of what yields."""

    outline: str
    compliance: str


class Common(NamedTuple):
    """Digests of what all pairs share: of where the teeth stand and how closely they are tabulated, and of how they touch."""

    placement: str
    contact: str


@dataclasses.dataclass(frozen=True, eq=False)
class Stack:
    """Tables side by side for the compiled loops, see `turn_kernels`: what the pairs of one record need.

    `tables` (h,) and `partners` (m, h) give the table of each pair of the hunting period, and the coupling table of it and the pair
    one to m pitches on.
    """

    tables: Ints
    knots: Array
    bins: Ints
    shape: Array
    law: Array
    partners: Ints
    cknots: Array
    cbins: Ints
    coupling: Array
    early: float
    count: int

    def arrays(self, module: float, late: tuple[Array, Array]) -> tuple[Any, ...]:
        """Return the arguments of the loops from `early` on."""
        own = (self.early, self.tables, *late, self.knots, self.bins, self.shape, self.law, float(levels(module)[0]), LEVEL)
        return (*own, self.partners, self.cknots, self.cbins, self.coupling)


def make_stack(mesh: Mesh, common: Common, kinds: list[tuple[Kind, Kind]], numbers: Ints) -> Stack:
    """Return the tables of some pairs, made where no earlier ones have the same content.

    Parameters
    ----------
    mesh : Mesh
        Without index errors, runout and supports.
    common : Common
        What all pairs share.
    kinds : list of (Kind, Kind), length h
        Both teeth of each pair of the period.
    numbers : ndarray of int, shape (k,)
        Pairs of the period that are needed.

    Returns
    -------
    Stack
    """
    needed = {kinds[number]: int(number) for number in numbers[::-1]}
    order = {kind: place for place, kind in enumerate(needed)}
    found = {kind: _kept((common, kind), _table, mesh, common, kind, number) for kind, number in needed.items()}
    tables = list(found.values())
    count = math.ceil(max(table.knots[-1] for table in tables) - min(table.knots[0] for table in tables))
    partners = np.zeros((max(count - 1, 1), len(kinds)), np.int64)
    joined: dict[tuple[int, tuple[Kind, Kind], tuple[Kind, Kind]], int] = {}
    couplings: list[CouplingTable] = [CouplingTable(knots=np.array([-2e9, -1e9]), coupling=np.zeros((1, 4)))]
    for apart in range(1, count):
        for number in numbers.tolist():
            one, two = kinds[number], kinds[(number + apart) % len(kinds)]
            if two not in found:
                continue
            if (apart, one, two) not in joined:
                table = _coupling(mesh, common, (one, two), (found[one], found[two]), number, apart)
                joined[apart, one, two] = len(couplings) if table is not None else 0
                couplings += [] if table is None else [table]
            partners[apart - 1, number] = joined[apart, one, two]
    knots, bins = _side_by_side([table.knots for table in tables])
    cknots, cbins = _side_by_side([table.knots for table in couplings])
    return Stack(
        tables=np.array([order.get(kind, 0) for kind in kinds], np.int64),
        knots=knots,
        bins=bins,
        shape=_padded([table.shape for table in tables]),
        law=_padded([table.law for table in tables]),
        partners=partners,
        cknots=cknots,
        cbins=cbins,
        coupling=_padded([table.coupling for table in couplings]),
        early=float(knots[:, 0].min()),
        count=count,
    )


def _table(mesh: Mesh, common: Common, kind: tuple[Kind, Kind], number: int) -> PairTable:
    """Return the table of a pair; its way is that of any with the same outlines at the same places."""
    way = _kept((common.placement, *(tooth.outline for tooth in kind)), way_of, mesh, number)
    return pair_table(mesh, number, way)


def _coupling(
    mesh: Mesh, common: Common, kinds: tuple[tuple[Kind, Kind], ...], tables: tuple[PairTable, PairTable], number: int, apart: int
) -> CouplingTable | None:
    """Return the coupling of two pairs, in which how they touch has no part; where they do is that of any with the same outlines."""
    outlines = (tooth.outline for kind in kinds for tooth in kind)
    place = _kept((common.placement, apart, *outlines), beside, mesh, number, apart, tables)
    return None if place is None else _kept((common.placement, apart, *kinds), coupling_table, mesh, number, apart, tables, place)


def _kept(key: Hashable, make: Callable[..., Table], *args: Any) -> Table:
    """Return the table of this content, made at need; the last `KEPT` stay."""
    table: Table | None = _memory.get(key)
    if table is None:
        table = make(*args)
    _memory[key] = table
    _memory.move_to_end(key)
    while len(_memory) > KEPT:
        _memory.popitem(last=False)
    return table


def _side_by_side(knots: list[Array]) -> tuple[Array, Ints]:
    """Return knots padded with their last, and for equal bins of each range the cell at its beginning."""
    size = max(part.size for part in knots)
    padded = np.stack([np.concatenate([part, np.full(size - part.size, part[-1])]) for part in knots])
    places = [np.searchsorted(part, np.linspace(part[0], part[-1], BINS, endpoint=False), side="right") - 1 for part in knots]
    # The bin of a point at its very edge may round up: one cell back is safe.
    return padded, np.maximum(np.stack(places) - 1, 0)


def _padded(parts: list[Array]) -> Array:
    size = max(len(part) for part in parts)
    out = np.zeros((len(parts), size, *parts[0].shape[1:]))
    for row, part in enumerate(parts):
        out[row, : len(part)] = part
    return out
