"""Fit effects to a campaign, together with everything that is never exactly known."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from scipy.optimize import lsq_linear

from gearfem.assembly import assemble
from gearfem.diagnosis.bench import Settings
from gearfem.diagnosis.campaign import Campaign, Measurement
from gearfem.diagnosis.marginal import Marginal, marginal, profile
from gearfem.diagnosis.model_form import model_form
from gearfem.diagnosis.noise import Noise
from gearfem.diagnosis.nuisances import Nuisance, moved_settings, nuisances_of, slopes
from gearfem.diagnosis.system_bench import SystemBench
from gearfem.diagnosis.teeth import Scatter, tooth_columns
from gearfem.effects.effect import Effect
from gearfem.foundation import Array, InputError, Record, SolveError

# What measures whitened signatures, shape (m, p): their products with each other, (p, p), and with what is left, (p,).
Freed: TypeAlias = Callable[[Array], tuple[Array, Array]]

FREE = 1.0
ROUNDS, HALVINGS, SETTLED = 7, 3, 1.0
DIFFERENCE = 0.03
# Share of its own deviation to which a record is predicted when all that is named is known: waviness finer than the terms fitted, teeth
# that act on each other by it, and at speed its linearised response; healthy pairs leave this much.
ACCURACY_SLOW, ACCURACY_MOVING = 0.04, 0.08


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Point(Record):
    """Effects and nuisances at one point, and what they leave.

    Parameters
    ----------
    effects : tuple of Effect
        With the parameters of this point.
    unknown : ndarray, shape (k,)
        Nuisances in prior deviations: settings, offsets, teeth, model form.
    predicted : tuple of ndarray
        Of each record [SI], offsets, waviness and model form left out.
    residual : ndarray, shape (m,)
        Measured less predicted, whitened, the index errors put back to 0.
    index : ndarray
        The index errors that the prediction holds, among the linear unknowns.
    weights : ndarray, shape (r,)
        What a squared whitened row of each record counts here, see `profile`.
    objective : float
        Cost of all records and squares of all nuisances in prior deviations, summed.
    """

    effects: tuple[Effect, ...]
    unknown: Array
    predicted: tuple[Array, ...]
    residual: Array
    index: Array
    weights: Array
    objective: float


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Fit(Record):
    """Effects fitted to records.

    Parameters
    ----------
    effects : tuple of Effect
        As fitted; none for the nuisances alone.
    deviations : tuple of dict
        Standard deviation of each parameter by field [SI], one dict for each effect; noise, nuisances and model form included.
    bound : tuple of (int, str)
        Parameters that ended at a bound: number of the effect and field.
    objective : float
        Squares of the whitened residual and of all nuisances in prior deviations, summed.
    point : Point
        Where the fit ended.
    settings : Settings
        Nuisances in the model's own terms.
    squares : ndarray, shape (r,)
        Mean square of the whitened rows of each record; 1 in noise alone.
    left : tuple of ndarray
        What is left of each record [SI], everything taken off.
    white : ndarray, shape (m,)
        The same whitened, one record below the other.
    """

    effects: tuple[Effect, ...]
    deviations: tuple[dict[str, float], ...]
    bound: tuple[tuple[int, str], ...]
    objective: float
    point: Point
    settings: Settings
    squares: Array
    left: tuple[Array, ...]
    white: Array


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
    """

    def __init__(
        self, campaign: Campaign, records: tuple[Measurement, ...], noises: tuple[Noise, ...], scatter: Scatter | None = None
    ) -> None:
        self.campaign, self.records, self.noises = campaign, records, noises
        self.scatter = scatter or Scatter()
        self.nuisances: tuple[Nuisance, ...] = nuisances_of(campaign, records)
        self.offsets = [i for i, record in enumerate(records) if record.quantity.free_constant]
        self.teeth = self.scatter.deviations(campaign.setup.pair)
        self.columns: tuple[Array, ...]
        self.scales: Array
        self.linear: Marginal
        self.whole: Marginal
        self.weights = np.ones(len(records))
        self.floor = np.array([_floor(record, noise) for record, noise in zip(records, noises, strict=True)])
        self.counts = np.array([float(record.keep.sum()) for record in records])

    # ---- unknowns -------------------------------------------------------------------------------

    @property
    def outer(self) -> int:
        """Number of the nuisances that are not linear: scales and the angle zero."""
        return len(self.nuisances)

    @property
    def first_tooth(self) -> int:
        """Place of the first tooth's index error among the unknowns."""
        return len(self.nuisances) + len(self.offsets)

    @property
    def first_form(self) -> int:
        """Place of the first variant of the model among the unknowns."""
        return self.first_tooth + len(self.teeth)

    def settings(self, unknown: Array) -> Settings:
        """Return the settings of unknowns, shape (k,)."""
        index = (unknown[self.first_tooth : self.first_form] * self.teeth)[:: self.scatter.terms + 1]
        z1 = self.campaign.setup.pair.pinion.teeth
        late = Settings(pinion_late=index[:z1], wheel_late=index[z1:])
        return moved_settings(late, self.nuisances, unknown[: len(self.nuisances)])

    def bench(self, effects: tuple[Effect, ...]) -> SystemBench:
        """Return the model with effects."""
        return SystemBench(system=assemble(self.campaign.setup, effects))

    # ---- prediction -----------------------------------------------------------------------------

    def predict(self, effects: tuple[Effect, ...], unknown: Array) -> tuple[Array, ...]:
        """Return the records under effects and the unknowns that the model takes: scales, angle zero, index errors."""
        bench, settings = self.bench(effects), self.settings(unknown)
        return tuple(bench.predict(record, settings) for record in self.records)

    def at(self, effects: tuple[Effect, ...], unknown: Array, weights: Array | None = None) -> Point:
        """Return a point: all that is linear about it, index errors too, moved to where it leaves least.

        Parameters
        ----------
        effects, unknown : tuple of Effect, ndarray of shape (k,)
            Where.
        weights : ndarray, shape (r,), optional
            What each record counts; by default what it deserves at this point.
        """
        predicted = self.predict(effects, unknown)
        outer, inner = unknown[: self.outer], unknown[self.outer :]
        index = np.zeros_like(inner)
        late = slice(len(self.offsets), len(self.offsets) + len(self.teeth), self.scatter.terms + 1)
        index[late] = inner[late]
        # The index errors are in the prediction: their columns put them back, so that all inner unknowns start from 0.
        misfit = self.whiten(tuple(r.value - p for r, p in zip(self.records, predicted, strict=True)))
        residual = misfit + self.linear.moved(index)
        # Without weights from a point nearby, those that this point deserves are found first.
        deserved = self.weights if weights is None else weights
        for _ in range(3 if weights is None else 1):
            linear = self.linear.weighed(deserved)
            solved = linear.solve(residual)
            white = residual - linear.moved(solved)
            cost, deserved = profile(np.array([white[rows] @ white[rows] for rows in linear.rows]), self.counts, self.floor)
        return Point(
            effects=effects,
            unknown=np.concatenate([outer, solved]),
            predicted=predicted,
            residual=residual,
            index=index,
            weights=deserved,
            objective=float(cost.sum() + solved @ solved + outer @ outer),
        )

    def prepare(self, effects: tuple[Effect, ...], unknown: Array) -> Array:
        """Make the columns of all nuisances at a point; every fit afterwards uses them until they are made again.

        Returns
        -------
        ndarray, shape (k,)
            The unknowns, completed by zeros where there were fewer.
        """
        unknown = np.concatenate([unknown, np.zeros(max(self.outer + len(self.offsets) + len(self.teeth) - len(unknown), 0))])
        bench, settings = self.bench(effects), self.settings(unknown)
        predicted = tuple(bench.predict(record, settings) for record in self.records)
        forms = model_form(self.records, bench, settings, predicted, self.scatter)
        inner, outer = [], []
        for i, (record, form) in enumerate(zip(self.records, forms, strict=True)):
            offset = np.zeros((len(record.axis), len(self.offsets)))
            if i in self.offsets:
                offset[:, self.offsets.index(i)] = FREE
            outer.append(slopes(record, bench, settings, self.nuisances, unknown[: self.outer]))
            teeth = tooth_columns(record, bench, settings, self.scatter) * self.teeth
            inner.append(np.concatenate([offset, teeth, form], axis=1))
        self.columns = tuple(inner)
        self.scales = self.whiten(tuple(outer))
        white = tuple(noise.whitener.apply(part) for noise, part in zip(self.noises, self.columns, strict=True))
        self.linear = marginal(white)
        self.whole = marginal(tuple(np.hstack([part, self.scales[rows]]) for part, rows in zip(white, self.linear.rows, strict=True)))
        return np.concatenate([unknown, np.zeros(self.outer + self.columns[0].shape[1] - len(unknown))])

    def whiten(self, series: tuple[Array, ...]) -> Array:
        """Return series in the rows of the records whitened and one below the other."""
        return np.concatenate([noise.whitener.apply(part) for noise, part in zip(self.noises, series, strict=True)])

    def left(self, point: Point) -> tuple[Array, ...]:
        """Return what a point leaves of each record: measured less predicted, offsets, teeth and model form."""
        kept = point.unknown[self.outer :] - point.index
        parts = zip(self.records, point.predicted, self.columns, strict=True)
        return tuple(record.value - predicted - columns @ kept for record, predicted, columns in parts)

    # ---- fitting --------------------------------------------------------------------------------

    def fit(self, effects: tuple[Effect, ...], unknown: Array, rounds: int = ROUNDS, hopeless: float = np.inf) -> Fit:
        """Fit the parameters of effects and all nuisances.

        Parameters
        ----------
        effects : tuple of Effect
            Where to start; gears and teeth stay.
        unknown : ndarray, shape (k,)
            Nuisances to start from, as `prepare` returns them.
        rounds : int
            Rounds at most.
        hopeless : float
            Objective that a fit must promise to reach; one that will not is given up where it stands.

        Returns
        -------
        Fit

        Raises
        ------
        SolveError, InputError
            If the start cannot be computed.

        Notes
        -----
        Gauss and Newton's method on the objective that is left when everything linear (offsets, teeth, model form) has been
        eliminated. Bounded least squares give the step of the parameters and of the scales, and steps that do not help are
        shortened. Columns of what is linear are those of the last `prepare`.
        """
        point = self.at(effects, unknown)
        jacobian = self.jacobian(point)
        for number in range(rounds):
            if number:
                jacobian = self.jacobian(point)
            ahead = self._ahead(point, jacobian)
            gained, point = point.objective - ahead.objective, ahead
            if gained < SETTLED + 1e-4 * point.objective or (number > 0 and point.objective - 3.0 * gained > hopeless):
                break
        left = self.left(point)
        white = self.whiten(left)
        squares = np.array([white[rows] @ white[rows] for rows in self.linear.rows]) / self.counts
        return Fit(
            effects=point.effects,
            deviations=self._deviations(point, jacobian),
            bound=tuple(
                (number, field)
                for number, effect in enumerate(point.effects)
                for field in effect.parameters()
                if at_bound(effect, field, self.campaign)
            ),
            objective=point.objective,
            point=point,
            settings=self.settings(point.unknown),
            squares=squares,
            left=left,
            white=white,
        )

    def _ahead(self, point: Point, jacobian: Array) -> Point:
        """Return the next point, or the same one where no step helps."""
        values = self.values(point.effects)
        low, high = self.bounds(point.effects)
        reach = np.array([nuisance.reach for nuisance in self.nuisances])
        outer = point.unknown[: self.outer]
        low, high = np.concatenate([low - values, -reach - outer]), np.concatenate([high - values, reach - outer])
        prior = np.concatenate([np.zeros(len(values)), np.ones(self.outer)])
        pulled = np.concatenate([np.zeros(len(values)), outer])
        gram, pull = self.linear.weighed(point.weights).measure(jacobian, point.residual)
        gram, pull = gram + np.diag(prior), pull - pulled
        scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
        factor = np.linalg.cholesky(scale[:, None] * gram * scale + 1e-9 * np.eye(len(scale)))
        target = np.linalg.solve(factor, scale * pull)
        room = (np.minimum(low / scale, -1e-12), np.maximum(high / scale, 1e-12))
        step = scale * np.asarray(lsq_linear(factor.T, target, bounds=room).x)
        share = 1.0
        for _ in range(HALVINGS):
            try:
                unknown = point.unknown.copy()
                unknown[: self.outer] += share * step[len(values) :]
                ahead = self.at(self.moved(point.effects, values + share * step[: len(values)]), unknown, point.weights)
                if ahead.objective < point.objective:
                    return ahead
            except (InputError, SolveError):
                pass
            share *= 0.35
        return point

    def effective(self, point: Point) -> Array:
        """Return the whitened residual with the scales put back to their priors too, so that `free` frees it from all nuisances."""
        return point.residual + self.scales @ point.unknown[: self.outer]

    def value(self, predicted: tuple[Array, ...], point: Point) -> float:
        """Return the objective of another prediction with the scales and index errors of a point."""
        misfit = self.whiten(tuple(r.value - p for r, p in zip(self.records, predicted, strict=True)))
        residual = misfit + self.linear.moved(point.index)
        linear, outer = self.linear.weighed(point.weights), point.unknown[: self.outer]
        solved = linear.solve(residual)
        white = residual - linear.moved(solved)
        cost, _ = profile(np.array([white[rows] @ white[rows] for rows in linear.rows]), self.counts, self.floor)
        return float(cost.sum() + solved @ solved + outer @ outer)

    def freed(self, point: Point) -> Freed:
        """Return what measures signatures against all that a point leaves, freed from all nuisances."""
        whole = self.whole.weighed(point.weights)
        residual = self.effective(point)
        return lambda vectors: whole.measure(vectors, residual)

    def jacobian(self, point: Point) -> Array:
        """Return the whitened derivatives of all records over parameters and scales, the former by one-sided differences."""
        values = self.values(point.effects)
        low, high = self.bounds(point.effects)
        columns = []
        for place, value in enumerate(values):
            step = DIFFERENCE * self.sizes(point.effects)[place]
            step = step if value + step <= high[place] else -step
            ahead = values.copy()
            ahead[place] = min(max(value + step, low[place]), high[place])
            moved = self.predict(self.moved(point.effects, ahead), point.unknown)
            change = self.whiten(tuple(a - b for a, b in zip(moved, point.predicted, strict=True)))
            columns.append(change / (ahead[place] - value))
        return np.column_stack([*columns, self.scales])

    def _deviations(self, point: Point, jacobian: Array) -> tuple[dict[str, float], ...]:
        prior = np.concatenate([np.zeros(jacobian.shape[1] - self.outer), np.ones(self.outer)])
        gram = self.linear.weighed(point.weights).measure(jacobian, point.residual)[0] + np.diag(prior)
        scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
        inverse = np.linalg.pinv(scale[:, None] * gram * scale, rcond=1e-12, hermitian=True)
        deviation = iter(scale * np.sqrt(np.maximum(np.diag(inverse), 0.0)))
        return tuple({field: float(next(deviation)) for field in effect.parameters()} for effect in point.effects)

    # ---- parameters -----------------------------------------------------------------------------

    def values(self, effects: tuple[Effect, ...]) -> Array:
        """Return the parameters of effects in the coordinates in which they are smooth."""
        pairs = ((effect, field, known) for effect in effects for field, known in effect.parameters().items())
        return np.array([known.coordinate(getattr(effect, field)) for effect, field, known in pairs])

    def bounds(self, effects: tuple[Effect, ...]) -> tuple[Array, Array]:
        """Return their bounds, in the same coordinates."""
        setup = self.campaign.setup
        both = [
            sorted(known.coordinate(edge) for edge in known.bounds(setup, effect.member))
            for effect in effects
            for known in effect.parameters().values()
        ]
        array = np.array(both).reshape(-1, 2)
        return array[:, 0], array[:, 1]

    def sizes(self, effects: tuple[Effect, ...]) -> Array:
        """Return the typical sizes of the parameters, by which differences are taken."""
        setup = self.campaign.setup
        out = []
        for effect in effects:
            for known in effect.parameters().values():
                typical = known.coordinate(known.typically(setup, effect.member))
                rest = known.coordinate(known.at_rest(setup, effect.member)) if known.neutral is not None else 0.0
                out.append(abs(typical - rest) or abs(typical) or 1.0)
        return np.array(out)

    def moved(self, effects: tuple[Effect, ...], values: Array) -> tuple[Effect, ...]:
        """Return the effects with other parameters."""
        left = iter(values)
        return tuple(
            dataclasses.replace(effect, **{field: known.value(float(next(left))) for field, known in effect.parameters().items()})
            for effect in effects
        )


def _floor(record: Measurement, noise: Noise) -> float:
    """Return the least mean square of whitened rows that a model of finite accuracy can be expected to leave of a record."""
    error = (ACCURACY_MOVING if record.quantity.moving else ACCURACY_SLOW) * float(np.std(record.value[record.keep]))
    return 1.0 + (error / noise.std) ** 2


def at_bound(effect: Effect, field: str, campaign: Campaign) -> bool:
    """Return whether a parameter stands at one of its bounds, other than its neutral value."""
    known = effect.parameters()[field]
    low, high = known.bounds(campaign.setup, effect.member)
    value = getattr(effect, field)
    return any(abs(value - edge) <= 1e-6 * (high - low) for edge in (low, high))
