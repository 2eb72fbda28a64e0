"""Where the gap is: maps of what nuisances leave over mesh phase, order, tooth and frequency, and one test of whether there is a gap."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from gearfem.diagnosis.comparing.comparison import Comparison
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.index_errors import deviating
from gearfem.diagnosis.fitting.marginal import Marginal
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.straying import LOST
from gearfem.diagnosis.localising.sheets import Domain, Sheet, sheets_of
from gearfem.diagnosis.localising.zones import WORDS
from gearfem.effects.effect import MEMBERS
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.progress import Progress, quiet
from gearfem.foundation.units import UM

DRAWS, FEWEST = 300, 100
# Draws that are held in memory at a time.
SLICE = 50
CHANCE = 0.01
NAMED = 3


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Map(Record):
    """Power of the whitened residual over one domain, in one record; 1 is noise alone.

    Parameters
    ----------
    record : str
        File of the record; "speeds" for the map of fixed frequencies over all of them.
    domain : {"mesh_phase", "order", "tooth", "frequency"}
        What it is over.
    part : str
        "zones" or "cells" of the mesh phase, "pinion" or "wheel" teeth; empty otherwise.
    label : tuple of str, length c
        Name of each cell.
    power : ndarray, shape (c,)
        Mean square of the whitened residual in the cell; of an order, the square of its line over its noise.
    expected : ndarray, shape (c,)
        The same in noise, nuisances and model form alone, from draws.
    significance : ndarray, shape (c,)
        Root power above the draws' mean, in their deviations.
    share : ndarray, shape (c,)
        Share in the record's power above the expected one.
    """

    record: str
    domain: Domain
    part: str
    label: tuple[str, ...]
    power: Array
    expected: Array
    significance: Array
    share: Array


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Place(Record):
    """One line of `where`.

    Parameters
    ----------
    record, domain, zone : str
        As the format of `diagnosis.json` has them.
    share_of_residual, significance : float
        Of its cell; of index errors the part of all their squares, and how many deviations of the others.
    sentence : str
        The same in words.
    """

    record: str
    domain: Domain
    zone: str
    share_of_residual: float
    significance: float
    sentence: str


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Localisation(Record):
    """Where the gap is.

    Parameters
    ----------
    maps : tuple of Map
        All of them.
    where : tuple of Place
        Teeth and turns that stand out in the index errors, which take up what single teeth do; then significant places, the strongest
        first.
    largest : float
        Largest significance of any cell.
    p_value : float
        Chance of a cell as large in noise, nuisances and model form alone: share of the draws, at least one over their number.
    gap : bool
        Whether that is below 1 %.
    draws : int
        Number of draws.
    sentence : str
        Answer in words.
    """

    maps: tuple[Map, ...]
    where: tuple[Place, ...]
    largest: float
    p_value: float
    gap: bool
    draws: int
    sentence: str


def localise(comparison: Comparison, fit: Fit | None = None, draws: int = DRAWS, seed: int = 1, progress: Progress = quiet) -> Localisation:
    """Say where a fit leaves more than noise.

    Parameters
    ----------
    comparison : Comparison
        Of nuisances alone.
    fit : Fit, optional
        With effects, to see what they leave; by default what the nuisances alone leave.
    draws : int
        Draws of noise and nuisances, errors of our own model among them, each fitted as the data were.
    seed : int
        Of the draws.
    progress : Progress
        Told how many draws are done.

    Returns
    -------
    Localisation

    Raises
    ------
    InputError
        If there are fewer than a hundred draws, which could show no chance of less than one in a hundred.

    Notes
    -----
    A draw is white noise, plus nuisances and model form from their priors, freed from the nuisances as the data are: cells are
    compared with what the fit leaves of noise. The global test takes the largest of all cells of all maps, so that their number
    needs no further correction.
    """
    if draws < FEWEST:
        raise InputError("draws", draws, f"{FEWEST} or more")
    fit = fit or comparison.alone
    sheets = sheets_of(comparison.problem, fit.settings)
    tables = _tables(comparison.problem.beside(fit.effects).whole.weighed(fit.point.weights), sheets, draws, seed, progress)
    maps, peaks = [], np.full(draws, -np.inf)
    for sheet, table in zip(sheets, tables, strict=True):
        mean, spread = table.mean(axis=0), np.maximum(table.std(axis=0, ddof=1), 1e-12)
        peaks = np.maximum(peaks, ((table - mean) / spread).max(axis=1))
        maps.append(_map(sheet, _root(sheet, fit.white[:, None])[:, 0], mean, spread, (table**2).mean(axis=0)))
    largest = max(float(one.significance.max()) for one in maps)
    p_value = (1.0 + float(np.count_nonzero(peaks >= largest))) / (draws + 1.0)
    gap = p_value < CHANCE
    where = _ranked(maps, float(np.quantile(peaks, 1.0 - CHANCE))) if gap else ()
    return Localisation(
        maps=tuple(maps),
        where=(*_taken_up(comparison.problem, fit), *where),
        largest=largest,
        p_value=p_value,
        gap=gap,
        draws=draws,
        sentence=_sentence(gap, p_value, where),
    )


def _tables(whole: Marginal, sheets: list[Sheet], draws: int, seed: int, progress: Progress) -> list[Array]:
    """Return the root power of the cells of each sheet in every draw, shapes (draws, c)."""
    rng = np.random.default_rng(seed)
    drawn: list[list[Array]] = [[] for _ in sheets]
    for done in range(0, draws, SLICE):
        progress("draws of noise", done, draws)
        left = _draws(whole, min(SLICE, draws - done), rng)
        for place, sheet in enumerate(sheets):
            drawn[place].append(_root(sheet, left))
    progress("draws of noise", draws, draws)
    return [np.concatenate(many, axis=1).T for many in drawn]


def _draws(whole: Marginal, count: int, rng: np.random.Generator) -> Array:
    """Return what fits of the nuisances leave of white noise and of nuisances from their priors, shape (m, count)."""
    # Nuisances drawn from their priors are fitted away but for what their priors hold back.
    nuisances = whole.moved(rng.standard_normal((whole.columns[0].shape[1], count)))
    return whole.left(rng.standard_normal(nuisances.shape) + nuisances)


def _root(sheet: Sheet, white: Array) -> Array:
    return np.asarray(np.sqrt(sheet.measure(white)))


def _map(sheet: Sheet, root: Array, mean: Array, spread: Array, expected: Array) -> Map:
    power = root**2
    above = np.maximum(power - expected, 0.0) * sheet.size
    # Zones overlap: their shares are of the last one, which is the whole cycle.
    whole = above[-1] if sheet.part == "zones" else above.sum()
    return Map(
        record=sheet.record,
        domain=sheet.domain,
        part=sheet.part,
        label=sheet.label,
        power=power,
        expected=expected,
        significance=(root - mean) / spread,
        share=np.minimum(above / whole, 1.0) if whole > 0.0 else np.zeros(len(above)),
    )


def _taken_up(problem: Problem, fit: Fit) -> Iterator[Place]:
    """Yield teeth, and waves of a turn, whose index errors stand out: a fit leaves nothing of what they do."""
    pair, late = problem.campaign.setup.pair, (fit.settings.pinion_late, fit.settings.wheel_late)
    file = next((record for record in problem.records if record.quantity.axis == "angle"), problem.records[0]).file
    squares = max(sum(float(own @ own) for own in late), 1e-300)
    for member, own, turn, (teeth, waves) in zip(MEMBERS, late, (1.0, 1.0 / pair.ratio), deviating(problem, fit), strict=False):
        for tooth in np.flatnonzero(teeth > LOST):
            apart = float(own[tooth] - np.median(own))
            size = f"{abs(apart) / UM:.3g} um {'late' if apart > 0.0 else 'early'}, {teeth[tooth]:.1f} times the scatter of the others"
            yield Place(
                record=file,
                domain="tooth",
                zone=f"{member}:{tooth}",
                share_of_residual=min(apart**2 / squares, 1.0),
                significance=float(teeth[tooth]),
                sentence=f"tooth {tooth} of the {member}, or one that meets it, is {size}: index errors have taken it up",
            )
        number = int(np.argmax(waves))
        if waves[number] > LOST:
            amplitude = float(abs(np.fft.rfft(own)[number + 1])) * 2.0 / own.size
            yield Place(
                record=file,
                domain="order",
                zone=f"{(number + 1) * turn:.6g}",
                share_of_residual=min(0.5 * amplitude**2 * own.size / squares, 1.0),
                significance=float(waves[number]),
                sentence=f"a wave of {amplitude / UM:.3g} um goes {number + 1} times round the {member}, "
                f"{waves[number]:.1f} times what its teeth have by chance: index errors have taken it up",
            )


# ---- in words -------------------------------------------------------------------------------------------


def _ranked(maps: list[Map], limit: float) -> tuple[Place, ...]:
    """Return significant places: of each map the cells that hold most, the most significant of all first."""
    places = []
    for one in maps:
        if one.part == "cells":
            continue
        found = np.flatnonzero(one.significance > limit)
        for cell in found[np.argsort(-_density(one)[found])][:NAMED]:
            places.append(
                Place(
                    record=one.record,
                    domain=one.domain,
                    zone=one.label[cell],
                    share_of_residual=float(one.share[cell]),
                    significance=float(one.significance[cell]),
                    sentence=_place_words(one, int(cell)),
                )
            )
    return tuple(sorted(places, key=lambda place: -place.significance))


def _density(one: Map) -> Array:
    """Return what ranks the cells of one map: a zone that is denser than the whole cycle comes before it."""
    return one.power / one.expected if one.part == "zones" else one.significance


def _place_words(one: Map, cell: int) -> str:
    zone, share = one.label[cell], f"{one.share[cell]:.0%} of what is left"
    if one.domain == "mesh_phase":
        return f"{one.record}: {share} lies {WORDS.get(zone, zone)}"
    if one.domain == "order":
        return f"{one.record}: {share} of the lines stands at order {zone} of the pinion's turns"
    if one.domain == "tooth":
        gear, number = zone.split(":")
        return f"{one.record}: {share} comes with tooth {number} of the {gear}"
    return f"at all speeds: {share} lies near {zone} Hz"


def _sentence(gap: bool, p_value: float, where: tuple[Place, ...]) -> str:
    if not gap:
        return f"No cell stands out: noise, nuisances and the errors of the model leave one as large in {p_value:.0%} of the draws."
    first = f" Most of all, in {where[0].sentence}." if where else ""
    return f"Cells stand out: noise, nuisances and the errors of the model leave one as large in less than 1 % of the draws.{first}"
