"""Computes a sweep as tasks of Ray: python ray_sweep.py PLAN FOLDER [PARTS [ADDRESS]]."""

import os
import sys
from pathlib import Path

import ray
import trackwright


@ray.remote(num_cpus=1, max_retries=2)
def compute(plan: str, folder: str, parts: int, part: int) -> int:
    """Computes one part on one core; rows that are there are kept."""
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    report = trackwright.Sweep.load(plan).compute(folder, shard=(part, parts))
    return report["computed"]


def main() -> None:
    plan, folder, *rest = sys.argv[1:]
    plan, folder = (str(Path(name).resolve()) for name in (plan, folder))
    parts = int(rest[0]) if rest else 64
    ray.init(*rest[1:])
    computed = ray.get([compute.remote(plan, folder, parts, part) for part in range(1, parts + 1)])
    merged = trackwright.merge_sweep(folder, Path(folder, "rows.parquet"), overwrite=True)
    print(f"{sum(computed)} rows computed, {merged['rows']} are in {folder}/rows.parquet")


if __name__ == "__main__":
    main()
