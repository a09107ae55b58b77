"""Computes a sweep as a Dask map: python dask_sweep.py PLAN FOLDER [PARTS [SCHEDULER]]."""

import os
import sys
from functools import partial
from pathlib import Path

import trackwright
from distributed import Client


def compute(plan: str, folder: str, parts: int, part: int) -> int:
    """Computes one part on one core; rows that are there are kept."""
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    report = trackwright.Sweep.load(plan).compute(folder, shard=(part, parts))
    return report["computed"]


def main() -> None:
    plan, folder, *rest = sys.argv[1:]
    plan, folder = (str(Path(name).resolve()) for name in (plan, folder))
    parts = int(rest[0]) if rest else 64
    with Client(*rest[1:]) if rest[1:] else Client(threads_per_worker=1) as client:
        work = partial(compute, plan, folder, parts)
        computed = client.gather(client.map(work, range(1, parts + 1), retries=2))
    merged = trackwright.merge_sweep(folder, Path(folder, "rows.parquet"), overwrite=True)
    print(f"{sum(computed)} rows computed, {merged['rows']} are in {folder}/rows.parquet")


if __name__ == "__main__":
    main()
