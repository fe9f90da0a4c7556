"""What the engine costs: wall time and memory of many runs that do nothing. A script, not a test: it asserts nothing.

docker/run env PYTHONPATH=tests python3 tests/workers/overhead.py [RUNS [WORKERS]]
"""

import resource
import sys
import tempfile
import time
from pathlib import Path

import stand_in_runs

from ncf_fenicsx.sweeps.inputs import Column, Input
from ncf_fenicsx.sweeps.parquet import write_parquet
from ncf_fenicsx.sweeps.plans import latin
from ncf_fenicsx.workers.cluster import Place
from ncf_fenicsx.workers.engine import run_missing


def main(runs=1000, workers=2):
    plan = latin([Input((Column("a"),), (), (0.0, 1.0))], runs, 1)
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "rows.csv"
        with Place(workers=workers).opened() as connection:
            before = memory()
            start = time.perf_counter()
            run_missing(
                plan.points(), plan.headings, ["y", "ending", "reason"], stand_in_runs.trivial, connection, rows
            )
            seconds = time.perf_counter() - start
        write_parquet(rows)
        print(f"{runs} runs, {workers} workers: {1e3 * seconds / runs:.2f} ms a run")
        print(
            f"peak memory {before:.0f} MB before, {memory():.0f} MB after; {len(rows.read_text().splitlines())} lines"
        )


def memory():
    """Peak memory of this process in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
