"""Benchmarks are run by themselves: their numbers depend on what else the machine does."""

collect_ignore_glob = ["bench_*.py"]
