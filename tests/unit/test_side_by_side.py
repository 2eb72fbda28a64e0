"""Work on all cores: results in order, and children that end where nobody waits for them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from pathlib import Path

import pytest
from threadpoolctl import threadpool_info

from gearfem.foundation import InputError
from gearfem.foundation.side_by_side import side_by_side

CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
FORKS = pytest.mark.skipif(CORES < 2 or "fork" not in multiprocessing.get_all_start_methods(), reason="works on one core here")


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
def test_an_error_of_a_child_says_what_it_said_there() -> None:
    def work(item: int) -> int:
        raise InputError("pinion.teeth", item, "6 or more", "pair.toml")

    with pytest.raises(InputError, match=r"^pair\.toml: pinion\.teeth: found 0; allowed: 6 or more$"):
        list(side_by_side(work, range(2)))
