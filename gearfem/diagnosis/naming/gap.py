"""How much of a gap a fit leaves, and how much of it effects close."""

from __future__ import annotations

import contextlib
import dataclasses
import math

import numpy as np
from scipy.stats import chi2

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.index_errors import odd_of, uneven, waves_of
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.straying import STRAYED
from gearfem.foundation import UNCOMPUTABLE, Array

# What fits may leave, over what can be expected of them, before it counts as a gap.
GAP_SLOW, GAP_MOVING = 1.25, 2.0
# Chance of noise off the rig below which it is a gap.
BY_CHANCE = 0.01
# What nuisances alone may leave, in gaps, before something is said to be missing that has no name: of 172 healthy pairs of another
# simulator they leave up to 1.8, of three 2.2 to 21, and of causes outside the catalogue 2.6 and more.
OPEN = 2.0


def closure(alone: Fit, best: Fit, problem: Problem) -> float:
    """Return the share of the gap that is closed: of the mean square above noise of each record, which counts by that one's logarithm.

    Parameters
    ----------
    alone, best : Fit
        Nuisances alone, and with effects; nuisances far off, which do the work of effects, are brought back within reason.
    problem : Problem
        What was fitted.
    """
    before, after = (np.maximum(_within_reason(fit, problem) / problem.floor - 1.0, 0.0) for fit in (alone, best))
    weight = problem.counts * np.log1p(before)
    return float(weight @ (1.0 - after / np.maximum(before, 1e-9)) / weight.sum()) if weight.sum() > 0.0 else 1.0


def gap_left(fit: Fit, problem: Problem) -> float:
    """Return what a fit leaves; above 1 is a gap: the geometric mean over the rows of the mean squares over what can be expected, or 1.

    Slow records, motions and gears off the rig by themselves, in parts of what counts as a gap of each; the largest one, so that many
    records without a gap do not hide the others. Off the rig a tooth or a flank is a few dozen rows, of which chance leaves more too.
    """
    above = np.log(np.maximum(fit.squares / problem.floor, 1.0))
    moving, off_rig = (np.array([getattr(record.quantity, kind) for record in problem.records]) for kind in ("moving", "of_gear"))
    few = max(float(problem.counts[off_rig].sum()), 1.0)
    kinds = ((~moving & ~off_rig, GAP_SLOW), (moving, GAP_MOVING), (off_rig, GAP_SLOW * float(chi2.ppf(1.0 - BY_CHANCE, few)) / few))
    return max(math.exp(float(problem.counts[kind] @ above[kind] / problem.counts[kind].sum())) / gap for kind, gap in kinds if kind.any())


def gaps(left: float) -> str:
    """Return in words what a fit leaves, in parts of what counts as a gap."""
    if left < 1.0:
        return "no gap"
    return f"{left:.2f} times what counts as a gap{', as some healthy pairs do' if left < OPEN else ''}"


def wide(problem: Problem, fit: Fit) -> list[tuple[str, float]]:
    """Return the records of gears off the rig of which a fit leaves more than noise would that is alike over all rows, in its deviations.

    Where noise is smoother than white, of which a few dozen rows tell little, a smooth shape hides in it row by row.
    """
    most, found = math.sqrt(float(chi2.ppf(1.0 - BY_CHANCE, 1))), []
    for record, noise, left in zip(problem.records, problem.noises, fit.left, strict=True):
        size = record.rms(left) / noise.std
        if record.quantity.of_gear and size > most:
            found.append((record.file, size))
    return found


def _within_reason(fit: Fit, problem: Problem) -> Array:
    """Return the mean squares, shape (r,), that a fit leaves with nuisances brought back to where they do the work of no effect.

    Scales, errors of our own model, forms common to all teeth together, and of the index errors waves and what stands out of a single
    tooth. Where nuisances stand still, beside single teeth, forms do so too: what all teeth have is not asked there.
    """
    unknowns, point, white = problem.unknowns, fit.point, fit.white
    within = point.unknown.copy()
    within[unknowns.scales] = np.clip(within[unknowns.scales], -STRAYED, STRAYED)
    if not np.array_equal(within, point.unknown):
        # What cannot be computed so far off stays as it is.
        with contextlib.suppress(*UNCOMPUTABLE):
            point = problem.at(fit.effects, within)
            white = problem.whiten(problem.left(point))
    unknown, back = point.unknown, np.zeros(len(point.unknown))
    for own in (unknowns.wrong, slice(unknowns.ways.start, None)):
        back[own] = unknown[own] - np.clip(unknown[own], -STRAYED, STRAYED)
    if problem.outer:
        forms = unknown[unknowns.forms]
        back[unknowns.forms] = forms * (1.0 - STRAYED / max(float(np.linalg.norm(forms)), STRAYED))
    if not unknowns.scatter.common:
        gears = np.split(unknown[unknowns.late], [problem.campaign.setup.pair.pinion.teeth])
        stray = uneven(problem, dataclasses.replace(fit, point=point))[1] > STRAYED
        back[unknowns.late] = np.concatenate([waves_of(late) * stray[number] + odd_of(late) for number, late in enumerate(gears)])
    return np.asarray(problem.squares(white + problem.linear.moved(back[problem.outer :])) / problem.counts)
