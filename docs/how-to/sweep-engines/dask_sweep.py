"""Computes a sweep as a Dask map: python dask_sweep.py PLAN FOLDER [PARTS [SCHEDULER]]."""

import os
import subprocess
import sys

from distributed import Client


def compute(plan: str, folder: str, part: int, parts: int) -> int:
    """Computes one part on one core; rows that are there are kept."""
    command = ["trackwright", "sweep", plan, "-o", folder, "--shard", f"{part}/{parts}"]
    subprocess.run(command, check=True, env={**os.environ, "RAYON_NUM_THREADS": "1"})
    return part


def main() -> None:
    plan, folder, *rest = sys.argv[1:]
    parts = int(rest[0]) if rest else 64
    with Client(*rest[1:]) if rest[1:] else Client(threads_per_worker=1) as client:
        tasks = [client.submit(compute, plan, folder, part, parts, retries=2) for part in range(1, parts + 1)]
        print(f"{len(client.gather(tasks))} parts are in {folder}")


if __name__ == "__main__":
    main()
