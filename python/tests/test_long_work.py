"""Long work leaves Python's other threads alone, ends at Ctrl+C, and leaves no memory behind."""

from __future__ import annotations

import gc
import os
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import columns_of

import trackwright
from trackwright import Design, Environment

# A search that would take this long, had nothing ended it.
LONG_S = 120.0
# From a signal to the exception: the longest step between two looks at the token, on a machine that
# does other work beside the tests.
PROMPT_S = 5.0


def search() -> object:
    return trackwright.optimize(
        Design.builtin("pointer-on-head"), moves=["tool", "crf"], seconds=LONG_S
    )


def study() -> object:
    axis = (-60.0, 60.0, 4.0)
    design = Design.builtin("pointer-on-head").with_motion(
        {"x": axis, "y": axis, "z": axis, "rx": axis}
    )
    return trackwright.simulate(design, "motion")


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("work", [search, study])
def test_ctrl_c_stops_the_work(work: Callable[[], object]) -> None:
    sent: list[float] = []

    def interrupt() -> None:
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, interrupt)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            work()
    finally:
        timer.cancel()
    assert time.monotonic() - sent[0] < PROMPT_S
    # Nothing goes on behind one's back: a core at rest uses next to no time.
    before, start = time.process_time(), time.monotonic()
    time.sleep(0.5)
    assert time.process_time() - before < 0.5 * (time.monotonic() - start)


def test_other_threads_run_meanwhile() -> None:
    count, is_over = 0, threading.Event()

    def work() -> None:
        trackwright.optimize(Design.builtin("pointer-on-head"), moves=["tool"], seconds=1.0)
        is_over.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not is_over.wait(0.005):
        count += 1
    thread.join()
    # With the lock held there would be one or two turns of this loop in all.
    assert count > 20


def test_two_threads_work_at_once(room_file: Path, fit_table: Path) -> None:
    room = Environment.load(room_file)
    columns = columns_of(fit_table)
    pose = np.column_stack([columns[f"measured_{n}"] for n in ("x", "y", "z", "qw", "qx", "qy", "qz")])
    results: dict[int, object] = {}

    def work(number: int) -> None:
        results[number] = room.compensate(pose[:, :3], pose[:, 3:]).positions

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 4
    assert all(np.array_equal(results[0], other) for other in results.values())  # type: ignore[arg-type]


def resident_kib() -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1])
    raise AssertionError("no VmRSS")


def test_memory_does_not_grow(few_rows: Path) -> None:
    room = Environment.fit(few_rows, order=1, directions=1)
    design = Design.builtin("pointer-on-head")
    names = [sensor.name for sensor in design.sensors()]
    position = design.sensors()[0].position
    poses = np.tile([0.0, 0.0, -200.0, 1.0, 0.0, 0.0, 0.0], (4, 1))
    points = np.eye(3) * 50.0
    message = trackwright.encode_transform("Pointer", poses[0])

    def call(number: int) -> None:
        nonlocal design
        shift = 0.001 * (number % 100)
        # A chain of edits, of which each begins with the one before.
        design = design.with_sensor(names[0], position + shift)
        figures = trackwright.simulate(design, expected=False)
        assert len(figures.trials) == 1 and figures.figures["trials"] == 1
        room.distort(poses[:, :3] + shift, poses[:, 3:])
        if number % 100 == 0:
            room.validity(poses[:, :3], poses[:, 3:])
        trackwright.register(points, points + shift)
        trackwright.IgtlDecoder().feed(message)
        with pytest.raises(trackwright.TrackwrightError):
            trackwright.pivot(poses[:2])

    for number in range(500):
        call(number)
    gc.collect()
    before = resident_kib()
    for number in range(10_000):
        call(number)
    gc.collect()
    # A leak of one small array a call would be some 100 bytes, 1 MB in all; of a design some kilobytes.
    assert resident_kib() - before < 4096
