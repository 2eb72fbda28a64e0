"""Compare a campaign with its model: nuisances fitted, everything else left as the gap."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from gearfem.diagnosis.bench import Bench, Settings, neutral
from gearfem.diagnosis.campaign import Campaign, Measurement
from gearfem.diagnosis.comparison import Compared, Comparison, Shift
from gearfem.diagnosis.linear import eliminate
from gearfem.diagnosis.magnitudes import refuse_magnitudes
from gearfem.diagnosis.noise import Noise, measure_noise
from gearfem.diagnosis.nuisances import Nuisance, moved_settings, nuisances_of, slopes
from gearfem.diagnosis.teeth import Scatter, tooth_columns
from gearfem.diagnosis.zero import guess_zero
from gearfem.foundation import Array, Record
from gearfem.foundation.progress import Progress, quiet

# A centimetre: a constant that is not known at all.
FREE = 1e-2
ROUNDS = 10
# A ten-thousandth of the objective decides nothing.
SETTLED = 1e-4
HALVINGS = 5


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class _State(Record):
    """A point of the fit: settings, offsets and waviness in prior deviations, and what they leave."""

    settings: Settings
    unknown: Array
    predicted: tuple[Array, ...]
    objective: float


def compare(campaign: Campaign, bench: Bench, scatter: Scatter | None = None, progress: Progress = quiet) -> Comparison:
    """Fit the nuisances of a campaign, and nothing else.

    Parameters
    ----------
    campaign : Campaign
        Only its records of role "fit" are looked at.
    bench : Bench
        The model.
    scatter : Scatter, optional
        What single teeth are expected to do.
    progress : Progress
        Told how far the fit is.

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        If a record is in another unit than it says, or taken at another speed.

    Notes
    -----
    Gauss and Newton's method on |whitened residual|^2 + |nuisances in prior deviations|^2. Offsets, scales, angle zero and index
    errors are put into the model at every round, so that teeth that share a load by their errors are met exactly; waviness stays
    linear. After the first fit the noise is measured again on what the model leaves.
    """
    records = campaign.of("fit")
    refuse_magnitudes(campaign, bench)
    teeth = scatter or Scatter()
    noises = tuple(measure_noise(record, campaign.setup.pair) for record in records)
    fit = _Fit(campaign, records, bench, teeth, noises)
    state = fit.start(progress)
    state, rounds = fit.settle(state, progress)
    explained = fit.explained(state)
    noises = tuple(measure_noise(record, campaign.setup.pair, part) for record, part in zip(records, explained, strict=True))
    fit = _Fit(campaign, records, bench, teeth, noises)
    state, more = fit.settle(fit.renewed(state), progress)
    return fit.result(state, rounds + more)


class _Fit:
    """The nuisance fit of fixed records, noises and priors; holds no state of the iteration."""

    def __init__(
        self, campaign: Campaign, records: tuple[Measurement, ...], bench: Bench, scatter: Scatter, noises: tuple[Noise, ...]
    ) -> None:
        self.campaign, self.records, self.bench, self.scatter, self.noises = campaign, records, bench, scatter, noises
        self.nuisances = nuisances_of(campaign, records)
        self.offsets = [i for i, record in enumerate(records) if record.quantity.free_constant]
        self.teeth = scatter.deviations(campaign.setup.pair)
        self.prior = np.concatenate([np.ones(len(self.nuisances)), np.full(len(self.offsets), FREE), self.teeth])
        self.reach = np.concatenate([[n.reach for n in self.nuisances], np.full(len(self.prior) - len(self.nuisances), np.inf)])

    # The unknowns in prior deviations: nuisances, offsets, then of each tooth the index error and its waviness.
    @property
    def first_tooth(self) -> int:
        return len(self.nuisances) + len(self.offsets)

    def settings(self, unknown: Array) -> Settings:
        """Return the settings at a point."""
        value = unknown * self.prior
        index = value[self.first_tooth :: self.scatter.terms + 1]
        z1 = self.campaign.setup.pair.pinion.teeth
        teeth = Settings(pinion_late=index[:z1], wheel_late=index[z1:])
        return moved_settings(teeth, self.nuisances, value[: len(self.nuisances)])

    def state(self, unknown: Array) -> _State:
        """Return the point with everything that is predicted there; waviness is added by `explained`."""
        settings = self.settings(unknown)
        predicted = tuple(self.bench.predict(record, settings) for record in self.records)
        return _State(settings=settings, unknown=unknown, predicted=predicted, objective=0.0)

    def columns(self, state: _State) -> list[Array]:
        """Return the derivatives of every record over all unknowns, in prior deviations."""
        out = []
        for i, record in enumerate(self.records):
            offset = np.zeros((len(record.axis), len(self.offsets)))
            if i in self.offsets:
                offset[:, self.offsets.index(i)] = 1.0
            own = slopes(record, self.bench, state.settings, self.nuisances, state.unknown[: len(self.nuisances)])
            teeth = tooth_columns(record, self.bench, state.settings, self.scatter)
            out.append(np.concatenate([own, offset, teeth], axis=1) * self.prior)
        return out

    def linear(self, state: _State, columns: list[Array]) -> tuple[Array, ...]:
        """Return the part of each record that only the columns hold: offsets and waviness."""
        kept = state.unknown.copy()
        kept[: len(self.nuisances)] = 0.0
        kept[self.first_tooth :: self.scatter.terms + 1] = 0.0
        return tuple(column @ kept for column in columns)

    def explained(self, state: _State) -> tuple[Array, ...]:
        """Return all that the fit makes of each record."""
        waves = self.linear(state, self.columns(state))
        return tuple(part + wave for part, wave in zip(state.predicted, waves, strict=True))

    def white(self, series: tuple[Array, ...] | list[Array]) -> Array:
        """Return series of all records whitened and one below the other."""
        return np.concatenate([noise.whitener.apply(part) for noise, part in zip(self.noises, series, strict=True)])

    def misfit(self, state: _State, columns: list[Array]) -> tuple[Array, float]:
        """Return the whitened residual at a point and the whole objective."""
        waves = self.linear(state, columns)
        left = [r.value - p - w for r, p, w in zip(self.records, state.predicted, waves, strict=True)]
        residual = self.white(left)
        return residual, float(residual @ residual + state.unknown @ state.unknown)

    def start(self, progress: Progress) -> _State:
        """Return the best of the starting points: neutral but for the angle zero, which is guessed from the mesh lines."""
        names = [n.name for n in self.nuisances]
        unknown = np.zeros(len(self.prior))
        if "angle_offset" not in names:
            return self.state(unknown)
        place = names.index("angle_offset")
        over = [i for i, record in enumerate(self.records) if record.quantity.axis == "angle"]
        own = tuple(self.records[i] for i in over)
        found = guess_zero(own, self.bench, neutral(self.campaign.setup.pair), tuple(self.noises[i].std for i in over))
        best: tuple[float, _State] | None = None
        for number, shift in enumerate(found):
            progress("angle zero", number, len(found))
            unknown[place] = shift / self.nuisances[place].prior
            state = self.round(self.state(unknown.copy()))
            if best is None or state.objective < best[0]:
                best = (state.objective, state)
        progress("angle zero", len(found), len(found))
        assert best is not None
        return best[1]

    def round(self, state: _State) -> _State:
        """Return the point one step of Gauss and Newton on, halved while it does not help."""
        columns = self.columns(state)
        residual, objective = self.misfit(state, columns)
        step = self.step(self.white(columns), residual, state.unknown)
        for _ in range(HALVINGS):
            ahead = self.state(state.unknown + step)
            value = self.misfit(ahead, columns)[1]
            if value <= objective:
                return dataclasses.replace(ahead, objective=value)
            step = 0.5 * step
        return dataclasses.replace(state, objective=objective)

    def step(self, columns: Array, residual: Array, unknown: Array) -> Array:
        """Return the step to the least of the linear problem, nuisances held at their reach."""
        normal = columns.T @ columns + np.eye(len(unknown))
        right = columns.T @ residual - unknown
        size = np.sqrt(np.diag(normal))
        free = np.ones(len(unknown), bool)
        step = np.zeros(len(unknown))
        for _ in range(len(self.nuisances) + 1):
            rest = right - normal[:, ~free] @ step[~free]
            scaled = normal[np.ix_(free, free)] / np.outer(size[free], size[free])
            step[free] = cho_solve(cho_factor(scaled), rest[free] / size[free]) / size[free]
            beyond = free & (np.abs(unknown + step) > self.reach)
            if not beyond.any():
                break
            step[beyond] = (np.sign(unknown + step) * self.reach - unknown)[beyond]
            free &= ~beyond
        return step

    def settle(self, state: _State, progress: Progress) -> tuple[_State, int]:
        """Return the point from which no round leads farther down, and the rounds it took."""
        for number in range(1, ROUNDS + 1):
            progress("nuisances", number - 1, ROUNDS)
            before, state = state, self.round(state)
            if number > 1 and before.objective - state.objective < max(1.0, SETTLED * state.objective):
                break
        progress("nuisances", ROUNDS, ROUNDS)
        return state, number

    def renewed(self, state: _State) -> _State:
        """Return the same point with nothing carried over from other noises."""
        return self.state(state.unknown)

    def result(self, state: _State, rounds: int) -> Comparison:
        """Return the comparison at a point."""
        columns = self.columns(state)
        waves = self.linear(state, columns)
        white = self.white(columns)
        left = tuple(r.value - p - w for r, p, w in zip(self.records, state.predicted, waves, strict=True))
        elimination = eliminate(white)
        counts = np.cumsum([0] + [int(record.keep.sum()) for record in self.records])
        nominal = self.nominal(state)
        out = []
        for i, record in enumerate(self.records):
            place = len(self.nuisances) + self.offsets.index(i) if i in self.offsets else None
            offset = float(state.unknown[place] * self.prior[place]) if place is not None else 0.0
            out.append(
                Compared(
                    measurement=record,
                    noise=self.noises[i],
                    before=nominal[i],
                    after=left[i],
                    scatter=waves[i] - offset,
                    offset=offset,
                    rows=(int(counts[i]), int(counts[i + 1])),
                )
            )
        return Comparison(
            campaign=self.campaign,
            settings=state.settings,
            scatter=self.scatter,
            shifts=self.shifts(state, elimination.deviations()),
            records=tuple(out),
            residual=self.white(left) + white @ state.unknown,
            elimination=elimination,
            rounds=rounds,
        )

    def nominal(self, state: _State) -> list[Array]:
        """Return what the model as its owner believes it leaves, constants and angle zero taken off."""
        believed = dataclasses.replace(neutral(self.campaign.setup.pair), angle_offset=state.settings.angle_offset)
        out = []
        for i, record in enumerate(self.records):
            gap = record.value - self.bench.predict(record, believed)
            out.append(gap - (gap[record.keep].mean() if i in self.offsets else 0.0))
        return out

    def shifts(self, state: _State, deviations: Array) -> tuple[Shift, ...]:
        """Return where the nuisances went."""
        return tuple(self._shift(n, state.unknown[i], deviations[i]) for i, n in enumerate(self.nuisances))

    def _shift(self, nuisance: Nuisance, moved: float, deviation: float) -> Shift:
        return Shift(
            name=nuisance.name,
            words=nuisance.words,
            value=nuisance.value(float(moved)),
            stderr=float(deviation) * nuisance.prior * (nuisance.value(float(moved)) if nuisance.is_scale else 1.0),
            prior=nuisance.prior,
            deviations=float(moved),
        )
