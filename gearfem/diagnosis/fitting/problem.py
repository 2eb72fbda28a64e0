"""What is fitted: records of one campaign, their noise, and the nuisances that all fits share."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gearfem.diagnosis.fitting.fit import ROUNDS, Fit, fit
from gearfem.diagnosis.fitting.marginal import Marginal, marginal, memory_of, profile
from gearfem.diagnosis.fitting.parameters import unlikely
from gearfem.diagnosis.fitting.point import Point
from gearfem.diagnosis.fitting.straying import beyond
from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.modelling.columns import make_columns
from gearfem.diagnosis.modelling.stand_ins import stand_ins
from gearfem.diagnosis.modelling.system_bench import SystemBench, bench_of
from gearfem.diagnosis.modelling.teeth import Scatter
from gearfem.diagnosis.modelling.unknowns import Unknowns, unknowns_of
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.noise import Noise
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, Array

# By how much scores of the same explanation may differ, by where its fit began, and so what a name must gain over the nuisances alone at
# least: the waviness of single teeth is linear about the point where its columns were taken.
WANDER = 40.0
# Share of the rows that a name must gain too: of eleven healthy pairs one gained 0.4 % by effects that imitate errors of our model.
IMITATED = 0.005

# Rows over which errors of the model stay alike at most: records of a longer memory would be given up for a trifle that others gain.
MEMORY = 4.0

# What measures whitened signatures, shape (m, p): their products with each other, (p, p), and with what is left, (p,).
Freed: TypeAlias = Callable[[Array], tuple[Array, Array]]
# What makes the model with effects.
BenchOf: TypeAlias = Callable[[tuple[Effect, ...]], SystemBench]


class Problem:
    """Records of one campaign with their noise, and the nuisances that all fits share; the columns of these are made once.

    Parameters
    ----------
    campaign : Campaign
        What was measured.
    records : tuple of Measurement
        The records to fit.
    noises : tuple of Noise
        Noise of each.
    scatter : Scatter, optional
        What single teeth are expected to do.
    bench : callable, optional
        Makes the model with effects; by default the campaign's.
    unknowns : Unknowns, optional
        What is fitted; by default all that the records can feel, with that scatter.
    known : tuple of Effect
        Effects that stand still.

    Attributes
    ----------
    make : callable
        Makes the model with effects, those known not among them.
    untold : tuple of str
        Files of records whose means over the pitches tell nothing.
    wander, least : float
        By how much scores of the same explanation may differ, and what a name must gain whatever the number of rows.
    share : float
        Share of the rows that it must gain too.
    effects : tuple of Effect
        Under which it was prepared last.
    columns : tuple of ndarray, shapes (n, i)
        Of each record over the inner unknowns in prior deviations [SI], once prepared.
    stand_ins : tuple of StandIn
        Unknowns that do just what an effect does: beside it they are 0, or the two would be one too many.
    scales, held_columns : ndarray, shapes (m, outer), (m, h)
        Of all whitened rows over the outer unknowns, and over those inner ones that predictions hold.
    rise : tuple of ndarray, shapes (n,)
        What waviness is expected to add to the largest Kw of a turn, in parts of Kw - 1; 0 in all other records.
    linear, whole : Marginal
        The inner unknowns, and all of them; those held at 0 that do just what the effects do under which it was prepared, see `beside`.
    floor, counts, memory : ndarray, shape (r,)
        Least mean square that can be expected of the whitened rows of each record, their number, and over how many of them errors of
        the model stay alike.
    """

    effects: tuple[Effect, ...]
    columns: tuple[Array, ...]
    scales: Array
    held_columns: Array
    rise: tuple[Array, ...]
    linear: Marginal
    whole: Marginal
    _free: Marginal
    _views: dict[tuple[int, ...], tuple[Marginal, Marginal, Array]]
    wander: float = WANDER
    least: float = WANDER
    share: float = IMITATED
    untold: tuple[str, ...] = ()

    def __init__(
        self,
        campaign: Campaign,
        records: tuple[Measurement, ...],
        noises: tuple[Noise, ...],
        scatter: Scatter | None = None,
        bench: BenchOf | None = None,
        unknowns: Unknowns | None = None,
        known: tuple[Effect, ...] = (),
    ) -> None:
        self.campaign, self.records, self.noises, self.known = campaign, records, noises, known
        self.make: BenchOf = bench or partial(bench_of, campaign)
        self.unknowns = unknowns or unknowns_of(campaign, records, scatter or Scatter(), self.bench(()).errors)
        self.nuisances = self.unknowns.nuisances
        self.stand_ins = stand_ins(self.unknowns, campaign.setup)
        self.floor = np.array([_floor(record, noise) for record, noise in zip(records, noises, strict=True)])
        self.memory = np.ones(len(records))
        self.rise = tuple(np.zeros(len(record.axis)) for record in records)
        self.counts = np.array([float(record.keep.sum()) for record in records])

    def bench(self, effects: tuple[Effect, ...]) -> SystemBench:
        """Return the model with effects beside those that are known."""
        return self.make((*self.known, *effects))

    @property
    def detected(self) -> float:
        """Least gain that counts."""
        return max(self.least, self.imitated)

    @property
    def imitated(self) -> float:
        """What effects gain at most that imitate errors of the model."""
        return self.share * float(self.counts.sum())

    @property
    def outer(self) -> int:
        """Number of the nuisances that are not linear: scales and the angle zero."""
        return self.unknowns.outer

    def part(self, places: NDArray[Any]) -> Problem:
        """Return the same problem, as it is prepared, with the records at some places alone."""
        part = copy.copy(self)
        part.records, part.noises = tuple(self.records[i] for i in places), tuple(self.noises[i] for i in places)
        part.columns = tuple(self.columns[i] for i in places)
        part.rise = tuple(self.rise[i] for i in places)
        part.held_columns = np.concatenate([self.held_columns[self.linear.rows[i]] for i in places])
        part._free, part._views = self._free.part(places), {}
        part.whole, part.linear, part.scales = part._holding(self.effects)
        part.floor, part.counts, part.memory = self.floor[places], self.counts[places], self.memory[places]
        return part

    def settings(self, unknown: Array) -> Settings:
        """Return the settings of unknowns, shape (k,)."""
        return self.unknowns.settings(unknown)

    def predict(self, effects: tuple[Effect, ...], unknown: Array, rise: tuple[Array, ...] | None = None) -> tuple[Array, ...]:
        """Return the records under effects and the unknowns that the model takes: scales, angle zero, index errors, its own errors.

        The largest Kw of a turn is that which waviness is expected to leave, once prepared, or which a rise leaves.
        """
        bench, settings = self.bench(effects), self.settings(unknown)
        predicted = (bench.predict(record, settings) for record in self.records)
        return tuple(part + own * (part - 1.0) for part, own in zip(predicted, rise or self.rise, strict=True))

    def change(self, point: Point, effects: tuple[Effect, ...], unknown: Array) -> Array:
        """Return by how much other effects and unknowns change what a point predicts: whitened, shape (m,)."""
        moved = self.predict(effects, unknown, point.rise)
        return self.whiten(tuple(a - b for a, b in zip(moved, point.predicted, strict=True)))

    def prepare(self, effects: tuple[Effect, ...], unknown: Array) -> Array:
        """Make the columns of all nuisances at a point; every fit afterwards uses them until they are made again.

        Returns
        -------
        ndarray, shape (k,)
            The unknowns, completed by zeros where there were fewer.
        """
        unknown = self._beside(effects, unknown)
        columns, white, rise = make_columns(self.records, self.noises, self.unknowns, self.bench(effects), unknown)
        inner = columns[0].shape[1]
        self.effects, self.rise, self.columns, self._views = effects, rise, columns, {}
        self.held_columns = np.concatenate([part[:, self.unknowns.held - self.outer] for part in white])
        self._free = marginal(white)
        self.whole, self.linear, self.scales = self._holding(effects)
        return np.concatenate([unknown, np.zeros(self.outer + inner - len(unknown))])

    def beside(self, effects: tuple[Effect, ...]) -> Problem:
        """Return the problem as it is prepared, those unknowns held at 0 that do just what effects do, and no others."""
        here = copy.copy(self)
        here.whole, here.linear, here.scales = self._holding(effects)
        return here

    def _holding(self, effects: tuple[Effect, ...]) -> tuple[Marginal, Marginal, Array]:
        """Return all unknowns, the inner ones and the columns of the outer ones, of which none moves that does just what effects do."""
        served = tuple(self._served(effects))
        if served not in self._views:
            inner, outer = self.columns[0].shape[1], [place for place in served if place < self.outer]
            still = [place - self.outer for place in served if place >= self.outer] + [inner + place for place in outer]
            whole = self._free.holding(np.array(still, int))
            scales = np.concatenate([part[:, inner:] for part in whole.columns])
            scales[:, outer] = 0.0
            self._views[served] = whole, whole.first(inner), scales
        return self._views[served]

    def _served(self, effects: tuple[Effect, ...]) -> list[int]:
        """Return the places of the unknowns that do just what effects do, or known ones."""
        return [one.place for one in self.stand_ins if any(one.serves(effect) for effect in (*self.known, *effects))]

    def _beside(self, effects: tuple[Effect, ...], unknown: Array) -> Array:
        """Return unknowns, those at 0 that do just what effects do."""
        served = self._served(effects)
        if not served:
            return unknown
        found = unknown.copy()
        found[[place for place in served if place < len(found)]] = 0.0
        return found

    def remember(self, fit: Fit) -> None:
        """Take over how many rows the errors of the model stay alike from what a fit leaves; a gear off the rig has none but its shape."""
        if self.unknowns.scatter.common:
            # Rows of a mean stand in no order.
            return
        rows = zip(self.records, self.linear.rows, strict=True)
        found = np.array([1.0 if record.quantity.of_gear else memory_of(fit.white[part]) for record, part in rows])
        self.memory = np.minimum(found, MEMORY)

    # ---- points ---------------------------------------------------------------------------------

    def at(self, effects: tuple[Effect, ...], unknown: Array, weights: Array | None = None, rounds: int = 1) -> Point:
        """Return a point: all that is linear about it, index errors too, moved to where it leaves least.

        Parameters
        ----------
        effects, unknown : tuple of Effect, ndarray of shape (k,)
            Where.
        weights : ndarray, shape (r,), optional
            What each record counts at first: those of a point nearby; by default what it deserves here, found in three rounds from 1.
        rounds : int
            Rounds in which given weights are brought up to what each record deserves here.
        """
        unknown = self._beside(effects, unknown)
        predicted = self.predict(effects, unknown)
        outer = unknown[: self.outer]
        within = self.unknowns.within(unknown)
        held = np.zeros(len(unknown) - self.outer)
        held[self.unknowns.held - self.outer] = within
        residual = self._residual(predicted, within)
        given, rounds = (np.ones(len(self.records)), 3) if weights is None else (weights, rounds)
        _, linear, _ = self._holding(effects)
        solved, cost, deserved = self._weigh(linear, linear.pulls(residual), self.squares(residual), given, rounds)
        return Point(
            effects=effects,
            unknown=np.concatenate([outer, solved]),
            predicted=predicted,
            rise=self.rise,
            residual=residual,
            held=held,
            given=given if rounds == 1 else deserved,
            weights=deserved,
            objective=cost + float(solved @ solved + outer @ outer) + self._price(effects, outer),
        )

    def attained(self, point: Point) -> float:
        """Return the objective at a point with what its prediction holds as it is, where `at` moves it as if all were linear.

        Errors of the model beyond what it can follow are linear indeed. What is linear leaves least under the weights that the point was
        given, which trials of one step share: they are factorised once, and little is lost.
        """
        kept = ~self.unknowns.at_limits(point.stood)
        held, outer = point.stood[self.unknowns.held[kept]], point.stood[: self.outer]
        solved, cost, _ = self._held(point, kept)
        return cost + float(solved @ solved + held @ held + outer @ outer) + self._price(point.effects, outer)

    def still(self, point: Point) -> Point:
        """Return a point with all that its prediction holds as it is, where `at` moves it as if all were linear."""
        solved, _, places = self._held(point, np.ones(len(self.unknowns.held), bool))
        unknown = point.stood
        unknown[places] = solved
        return dataclasses.replace(point, unknown=unknown)

    def _held(self, point: Point, kept: NDArray[Any]) -> tuple[Array, float, NDArray[Any]]:
        """Return the other linear unknowns that leave least, some of those held kept as they are; what records cost; their places."""
        places = self.unknowns.held[kept]
        moving = np.setdiff1d(np.arange(len(point.held)), places - self.outer)
        misfit = point.residual - self.held_columns[:, kept] @ point.stood[places]
        _, linear, _ = self._holding(point.effects)
        solved, cost, _ = self._weigh(linear.some(moving), linear.pulls(misfit)[:, moving], self.squares(misfit), point.given, 1)
        return solved, cost, moving + self.outer

    def foretold(self, point: Point, change: Array) -> Array:
        """Return the unknowns of a point, those that are linear moved to where they leave least once predictions change, (m,) whitened."""
        _, linear, _ = self._holding(point.effects)
        solved = linear.weighed(point.weights).solve(point.residual - change)
        return np.concatenate([point.unknown[: self.outer], solved])

    def _weigh(self, linear: Marginal, pulls: Array, squares: Array, weights: Array, rounds: int) -> tuple[Array, float, Array]:
        """Return the linear unknowns that leave least, what records cost then, and what each deserves to count (r,), from weights on."""
        for _ in range(rounds):
            solved, left = linear.weighed(weights).settle(pulls, squares)
            cost, weights = profile(left, self.counts, self.floor, self.memory)
        return solved, float(cost.sum()), weights

    def _price(self, effects: tuple[Effect, ...], unknown: Array) -> float:
        """Return what scales cost that stray, and effects that are not what their causes make of them."""
        return float(self.detected * (self.strayed(unknown) ** 2).sum() + (unlikely(effects) ** 2).sum())

    def left_at(self, effects: tuple[Effect, ...], unknown: Array) -> float:
        """Return the objective at a point, see `at`; infinity where there is none."""
        try:
            return self.at(effects, unknown).objective
        except UNCOMPUTABLE:
            return math.inf

    def strayed(self, unknown: Array) -> Array:
        """Return how far the outer of unknowns have strayed, shape (outer,); 0 for the zero of the angle and how the gears are built."""
        found = np.zeros(self.outer)
        found[self.unknowns.scales] = beyond(unknown[self.unknowns.scales])
        return found

    def left(self, point: Point) -> tuple[Array, ...]:
        """Return what a point leaves of each record [SI]: measured less predicted, offsets, teeth and model form."""
        kept = point.unknown[self.outer :] - point.held
        parts = zip(self.records, point.predicted, self.columns, strict=True)
        return tuple(record.value - predicted - columns @ kept for record, predicted, columns in parts)

    def response(self, point: Point, others: tuple[Effect, ...]) -> Array:
        """Return what the effects of a point do beyond others of them, everything else as the point has it: whitened, shape (m,)."""
        return -self.change(point, others, point.stood)

    def effective(self, point: Point) -> Array:
        """Return the whitened residual with the scales put back to their priors too, so that `freed` frees it from all nuisances."""
        return point.residual + self.scales @ point.unknown[: self.outer]

    def freed(self, point: Point) -> Freed:
        """Return what measures signatures against all that a point leaves, freed from all nuisances."""
        whole = self._holding(point.effects)[0].weighed(point.weights)
        residual = self.effective(point)
        return lambda vectors: whole.measure(vectors, residual)

    def whiten(self, series: tuple[Array, ...]) -> Array:
        """Return series in the rows of the records whitened and one below the other."""
        return np.concatenate([noise.whitener.apply(part) for noise, part in zip(self.noises, series, strict=True)])

    def squares(self, white: Array) -> Array:
        """Return the sum of the squared whitened rows of each record, shape (r,)."""
        return np.array([white[rows] @ white[rows] for rows in self.linear.rows])

    def _residual(self, predicted: tuple[Array, ...], held: Array) -> Array:
        """Return measured less predicted, whitened; what the prediction holds of inner unknowns, (h,), is put back by columns."""
        misfit = self.whiten(tuple(record.value - part for record, part in zip(self.records, predicted, strict=True)))
        return misfit + self.held_columns @ held

    # ---- fitting --------------------------------------------------------------------------------

    def fit(self, effects: tuple[Effect, ...], unknown: Array, rounds: int = ROUNDS, hopeless: float = np.inf) -> Fit:
        """Fit the parameters of effects and all nuisances, see `gearfem.diagnosis.fitting.fit.fit`."""
        return fit(self.beside(effects), effects, unknown, rounds, hopeless)


def _floor(record: Measurement, noise: Noise) -> float:
    """Return the least mean square of whitened rows that a model of finite accuracy can be expected to leave of a record."""
    error = record.quantity.accuracy * float(np.std(record.value[record.keep]))
    return 1.0 + (error / noise.std) ** 2
