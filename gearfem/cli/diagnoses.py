"""The command of the diagnosis: campaign read, diagnosed, written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gearfem.cli.steps import Done
from gearfem.diagnosis.diagnose import choose, diagnose
from gearfem.diagnosis.reading.campaign import read_campaign
from gearfem.diagnosis.write import RESULT, refuse_to_replace, write_diagnosis
from gearfem.effects.catalogue import catalogue, effects_from
from gearfem.foundation.files import together
from gearfem.foundation.progress import Progress
from gearfem.report import write_diagnosis_report


def run_diagnosis(
    campaign: str, out: Path, only: Sequence[str], exclude: Sequence[str], effect_files: Sequence[str], progress: Progress
) -> Done:
    """Diagnose a campaign and write everything about it.

    Parameters
    ----------
    campaign : str
        Its file.
    out : Path
        Folder.
    only, exclude : sequence of str
        Names of effects that are allowed, or not.
    effect_files : sequence of str
        Python files with further effects.
    progress : Progress
        Told how far the work is.

    Returns
    -------
    Done

    Raises
    ------
    InputError
        If the campaign, a name or a file cannot be used.
    """
    further = [kind for file in effect_files for kind in effects_from(file)]
    kinds = choose(catalogue(further), only, exclude)
    read = read_campaign(campaign, further)
    refuse_to_replace(read, out)
    found = diagnose(read, kinds, progress)
    with together(out) as draft:
        pictures = [out / drawn.name for drawn in write_diagnosis_report(found, draft)]
        # A verdict goes before anything else of it is replaced, and comes last: where it is, everything is.
        (out / RESULT).unlink(missing_ok=True)
    files = write_diagnosis(found, out)
    lines = [f"{found.naming.verdict}: {found.naming.sentence}", *found.proof.reasons]
    lines += [one.sentence for one in found.suggestions[:1]]
    return Done(lines, [*files, *pictures])
