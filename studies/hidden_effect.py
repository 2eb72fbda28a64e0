"""How often the diagnosis is right, on campaigns of an independent generator whose causes it cannot know.

Campaigns come from `tests/recovery/generator`, which shares neither compliance nor contact law nor integrator with gearfem, or
from a folder (`case_*/campaign.toml`, `labels/case_*.json`). Each is diagnosed as `gearfem diagnose` does it; labels are opened
when the last verdict is on disk. An interrupted study goes on where it was, with the same command.

    python studies/hidden_effect.py --out results --seed 1 --cases 150 --none 200 --jobs 2
"""

from __future__ import annotations

import argparse
import hashlib
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

import gearfem
from gearfem.cli.listener import Bars
from gearfem.diagnosis import diagnose, read_campaign, write_diagnosis
from gearfem.effects.catalogue import catalogue
from gearfem.foundation import InputError, SolveError
from gearfem.foundation.files import write_json
from gearfem.foundation.progress import Progress, quiet
from gearfem.foundation.threads import one_thread

ROOT = Path(__file__).resolve().parents[1]
KINDS = ("mix", "single", "double", "none", "hidden", "twins", "weak")
# Campaigns without any effect that stand beside a mixture take numbers from here on, and so draws of their own.
APART = 5000
INTERRUPTED = 130


@dataclass(frozen=True)
class Case:
    """A campaign, where its verdict goes and where its label lies."""

    name: str
    campaign: Path
    verdict: Path
    label: Path

    @property
    def done(self) -> bool:
        """Whether there is a verdict, or the error that it ended in."""
        return (self.verdict / "diagnosis.json").exists() or (self.verdict / "failed.json").exists()


# ---- campaigns -----------------------------------------------------------------------------------------


def generate(folder: Path, seed: int, kind: str, cases: int, first: int, progress: Progress) -> None:
    """Let the generator, a program of its own, write the campaigns that are not there yet."""
    numbers = range(first, first + cases)
    # The label is the last file of a case.
    missing = [number for number in numbers if not (folder / "labels" / f"case_{number:04d}.json").exists()]
    if not missing:
        return
    words = ["--out", folder, "--seed", seed, "--kind", kind, "--first", missing[0], "--cases", numbers[-1] - missing[0] + 1]
    command = [sys.executable, "-m", "tests.recovery.generator", *map(str, words)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for number, _ in enumerate(process.stdout, missing[0] - first + 1):
            progress(f"campaigns of kind {kind}", number, cases)
    if process.returncode:
        raise SystemExit(f"the generator ended with status {process.returncode}")


def cases_of(folder: Path, out: Path, numbers: Sequence[int] | None = None, most: int | None = None) -> list[Case]:
    """Return the campaigns of a folder in order: those of some numbers, or the first few."""
    if numbers is None:
        names = sorted(path.parent.name for path in folder.glob("case_*/campaign.toml"))[:most]
    else:
        names = [f"case_{number:04d}" for number in numbers]
    if not names:
        raise InputError("--folder", f"no case_*/campaign.toml in {folder}", "a folder of campaigns")
    verdicts = out / "verdicts" / folder.name
    return [Case(name, folder / name / "campaign.toml", verdicts / name, folder / "labels" / f"{name}.json") for name in names]


def decided(case: Case) -> Case | None:
    """Return the campaign of a twin with the record that decides, where the generator wrote one; it lies beside the labels."""
    campaign = case.label.with_name(f"{case.name}_decided") / "campaign.toml"
    name = f"{case.name}_decided"
    return Case(name, campaign, case.verdict.with_name(name), case.label) if campaign.exists() else None


# ---- verdicts ------------------------------------------------------------------------------------------


def state_of_code() -> str:
    """Return a digest of the program, so that verdicts of different states are told apart."""
    digest = hashlib.sha256()
    for path in sorted(Path(gearfem.__file__).parent.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def find(case: Case, code: str, progress: Progress = quiet) -> str:
    """Diagnose one campaign, write its verdict and return it in a few words."""
    start, before = time.perf_counter(), sum(os.times()[:4])

    def run() -> dict[str, float | str]:
        # Seconds of all cores beside those of the clock: other work on the machine changes the latter.
        return {"seconds": time.perf_counter() - start, "core_seconds": sum(os.times()[:4]) - before, "code": code}

    try:
        found = diagnose(read_campaign(case.campaign), catalogue(), progress)
    except (InputError, SolveError) as error:
        write_json(case.verdict / "failed.json", run() | {"error": str(error)})
        return f"failed: {error}"
    write_json(case.verdict / "run.json", run())
    # The verdict comes last: where it is, everything is.
    write_diagnosis(found, case.verdict)
    return found.naming.verdict


def find_all(cases: Sequence[Case], jobs: int) -> None:
    """Diagnose the campaigns that have no verdict yet; with several jobs each has one core, else each has all."""
    left = [case for case in cases if not case.done]
    for number, (case, words) in enumerate(_one_by_one(left) if jobs < 2 else _side_by_side(left, jobs), len(cases) - len(left) + 1):
        print(f"{number:4d} of {len(cases)}  {case.campaign.parent.parent.name}/{case.name}  {words}", flush=True)


def _one_by_one(cases: Sequence[Case]) -> Iterator[tuple[Case, str]]:
    code = state_of_code()
    with Bars() as bars:
        for case in cases:
            yield case, find(case, code, lambda label, done, total, case=case: bars(f"{case.name}: {label}", done, total))


def _begin() -> None:
    """Let a worker end at Ctrl-C and keep to one core: threads of linear algebra would take that of another worker."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    one_thread()


def _side_by_side(cases: Sequence[Case], jobs: int) -> Iterator[tuple[Case, str]]:
    code = state_of_code()
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), _begin)
    try:
        work = {pool.submit(find, case, code): case for case in cases}
        with Bars() as bars:
            for number, future in enumerate(as_completed(work), 1):
                bars("campaigns", number, len(cases))
                yield work[future], future.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        # Campaigns that were not finished begin again: nobody waits for them.
        for worker in multiprocessing.active_children():
            worker.terminate()


# ---- score ---------------------------------------------------------------------------------------------


def score(cases: Sequence[Case], out: Path, with_decided: bool) -> list[Path]:
    """Open the labels, which nothing has done so far, and write the score sheet.

    Raises
    ------
    InputError
        If a verdict is missing: no label is opened then.
    """
    from score_sheet import write_sheet
    from scoring import read_found, read_label, score_case

    missing = [case.name for case in cases if not case.done]
    if missing:
        raise InputError(str(out), f"no verdict on {missing[0]}", "verdicts on all campaigns before any label is opened")
    scores = []
    for case in cases:
        second = decided(case) if with_decided else None
        more = read_found(second.verdict) if second and second.done else None
        name = f"{case.campaign.parent.parent.name}/{case.name}"
        scores.append(score_case(name, read_label(case.label), read_found(case.verdict), more))
    return write_sheet(scores, out)


def main(arguments: list[str] | None = None) -> list[Path]:
    """Run the study: campaigns, verdicts, and then the score."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("results"))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, help="campaigns to generate (default 150), or how many of each folder to take")
    parser.add_argument("--kind", choices=KINDS, default="mix")
    parser.add_argument("--none", type=int, default=0, help="campaigns without any effect besides")
    parser.add_argument("--folder", type=Path, nargs="+", help="campaigns that exist already")
    parser.add_argument("--decide", action="store_true", help="diagnose twins again with the record that decides")
    parser.add_argument("--jobs", type=int, default=1, help="campaigns at a time, each on one core")
    options = parser.parse_args(arguments)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    cases: list[Case] = []
    try:
        if options.folder:
            for folder in options.folder:
                cases += cases_of(folder.resolve(), options.out, most=options.cases)
        else:
            cases = _generated(options)
        more = [second for case in cases if (second := decided(case))] if options.decide else []
        find_all([*cases, *more], options.jobs)
    except KeyboardInterrupt:
        print(f"\ninterrupted with {sum(case.done for case in cases)} verdicts; the same command goes on", file=sys.stderr)
        raise SystemExit(INTERRUPTED) from None
    except InputError as error:
        raise SystemExit(f"error: {error}") from None
    files = score(cases, options.out, options.decide)
    for path in files:
        print(f"wrote {path}")
    return files


def _generated(options: argparse.Namespace) -> list[Case]:
    wanted = [(options.kind, 150 if options.cases is None else options.cases, 0), ("none", options.none, APART)]
    cases = []
    with Bars() as bars:
        for kind, count, first in wanted:
            if count:
                folder = (options.out / f"campaigns_{options.seed}_{kind}").resolve()
                generate(folder, options.seed, kind, count, first, bars)
                cases += cases_of(folder, options.out, range(first, first + count))
    return cases


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    main()
