"""Computes a sweep as a HyperQueue job on a local cluster: python hyperqueue_sweep.py PLAN FOLDER [PARTS]."""

import sys
from pathlib import Path

from hyperqueue import Job, LocalCluster
from hyperqueue.cluster import WorkerConfig


def main() -> None:
    plan, folder, *rest = sys.argv[1:]
    plan, folder = str(Path(plan).resolve()), str(Path(folder).resolve())
    parts = int(rest[0]) if rest else 64
    job = Job()
    for part in range(1, parts + 1):
        command = ["trackwright", "sweep", plan, "-o", folder, "--shard", f"{part}/{parts}"]
        job.program(command, env={"RAYON_NUM_THREADS": "1"})
    with LocalCluster() as cluster:
        cluster.start_worker(WorkerConfig(cores=2))
        client = cluster.client()
        client.wait_for_jobs([client.submit(job)])
    print(f"{parts} parts are in {folder}")


if __name__ == "__main__":
    main()
