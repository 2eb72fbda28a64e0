"""Work on all cores: results in order, and children that end where nobody waits for them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import time
from pathlib import Path

import pytest
from threadpoolctl import threadpool_info

from gearfem.foundation import InputError
from gearfem.foundation.side_by_side import side_by_side

CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
FORKS = pytest.mark.skipif(CORES < 2 or "fork" not in multiprocessing.get_all_start_methods(), reason="works on one core here")


def _runs(number: int) -> bool:
    """Return whether a process works or sleeps: one that has ended may wait to be asked for."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_results_come_in_order() -> None:
    factor = 3
    assert list(side_by_side(lambda item: factor * item, range(7))) == [0, 3, 6, 9, 12, 15, 18]


@FORKS
def test_each_child_keeps_to_one_core() -> None:
    """Threads of linear algebra in every child would wait for each other: the work took twice as long."""
    threads = side_by_side(lambda _: [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"], range(2))
    assert [set(own) for own in threads] == [{1}, {1}]


@FORKS
@pytest.mark.parametrize("way", ["interrupt", "error"])
def test_children_end_with_what_they_work_for(tmp_path: Path, way: str) -> None:
    def work(item: int) -> int:
        if way == "error" and item == 0:
            raise ArithmeticError
        (tmp_path / f"began_{item}").touch()
        time.sleep(20.0)
        (tmp_path / f"ended_{item}").touch()
        return item

    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        if way == "interrupt":
            signal.setitimer(signal.ITIMER_REAL, 1.0)
        with pytest.raises(KeyboardInterrupt if way == "interrupt" else ArithmeticError):
            list(side_by_side(work, range(4)))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert multiprocessing.active_children() == []
    assert not list(tmp_path.glob("ended_*"))


@FORKS
def test_a_child_shares_its_own_work_out_over_cores_that_others_have_left() -> None:
    """Of a few fits of unlike length the longest one would keep all cores but one waiting."""

    def inner(_: int) -> int:
        time.sleep(0.3)
        return os.getpid()

    def work(item: int) -> set[int]:
        # The last one only begins to share out when the others are done.
        time.sleep(1.0 if item == CORES - 1 else 0.0)
        return set(side_by_side(inner, range(CORES))) if item == CORES - 1 else {os.getpid()}

    *_, last = side_by_side(work, range(CORES))
    assert len(last) == CORES


@FORKS
def test_a_child_keeps_its_work_where_no_core_is_free() -> None:
    def work(_: int) -> bool:
        time.sleep(0.5)
        here = set(side_by_side(lambda _: os.getpid(), range(4))) == {os.getpid()}
        time.sleep(0.5)
        return here

    assert all(side_by_side(work, range(CORES)))


@FORKS
@pytest.mark.skipif(sys.platform != "linux", reason="a child is told of its parent's end by Linux alone")
def test_no_child_of_a_child_outlives_it(tmp_path: Path) -> None:
    def inner(item: int) -> None:
        (tmp_path / f"{os.getpid()}").touch()
        time.sleep(20.0)

    def work(item: int) -> None:
        if item == CORES - 1:
            time.sleep(1.0)
            list(side_by_side(inner, range(CORES)))

    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 3.0)
        with pytest.raises(KeyboardInterrupt):
            list(side_by_side(work, range(CORES)))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    began = [int(path.name) for path in tmp_path.iterdir()]
    assert len(began) == CORES
    deadline = time.monotonic() + 10.0
    while any(_runs(number) for number in began) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not any(_runs(number) for number in began)


@FORKS
def test_an_error_of_a_child_says_what_it_said_there() -> None:
    def work(item: int) -> int:
        raise InputError("pinion.teeth", item, "6 or more", "pair.toml")

    with pytest.raises(InputError, match=r"^pair\.toml: pinion\.teeth: found 0; allowed: 6 or more$"):
        list(side_by_side(work, range(2)))
