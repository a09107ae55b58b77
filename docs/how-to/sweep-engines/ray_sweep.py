"""Computes a sweep as tasks of Ray: python ray_sweep.py PLAN FOLDER [PARTS [ADDRESS]]."""

import os
import subprocess
import sys

import ray


@ray.remote(num_cpus=1, max_retries=2)
def compute(plan: str, folder: str, part: int, parts: int) -> int:
    """Computes one part on one core; rows that are there are kept."""
    command = ["trackwright", "sweep", plan, "-o", folder, "--shard", f"{part}/{parts}"]
    subprocess.run(command, check=True, env={**os.environ, "RAYON_NUM_THREADS": "1"})
    return part


def main() -> None:
    plan, folder, *rest = sys.argv[1:]
    parts = int(rest[0]) if rest else 64
    ray.init(*rest[1:])
    done = ray.get([compute.remote(plan, folder, part, parts) for part in range(1, parts + 1)])
    print(f"{len(done)} parts are in {folder}")


if __name__ == "__main__":
    main()
