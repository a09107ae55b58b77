"""Sweeps: the rows and the bytes that the program writes, in parts, interrupted and refused."""

from __future__ import annotations

import os
import signal
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Program

import trackwright
from trackwright import Design, Sweep, SweepTable, TrackwrightError

SHAFT = 'tool.body.sensors["shaft"].position.z'
IN_RON = SHAFT.replace('"', '\\"')
VALUES = [60.0, 66.0, 72.0, 78.0, 84.0]


def plan_text(values: list[float]) -> str:
    return f"""(
        version: 1,
        designs: ["pointer-on-head", "endoscope"],
        vary: [Grid([(path: "{IN_RON}", values: List({values}))])],
        motions: [Single],
        figures: ["position_rms", "angle_rms"],
    )"""


@pytest.fixture()
def plan(tmp_path: Path) -> Path:
    file = tmp_path / "plan.sweep.ron"
    file.write_text(plan_text(VALUES).replace(', "endoscope"', ""))
    return file


def test_merged_bytes_are_those_of_the_program(
    program: Program, plan: Path, tmp_path: Path
) -> None:
    sweep = Sweep.load(plan)
    assert sweep.rows == len(VALUES)
    reports = [sweep.compute(tmp_path / "own", shard=(part, 3)) for part in (2, 3, 1)]
    assert [report["computed"] for report in reports] == [2, 2, 1]
    printed = program.json("sweep", plan, "-o", tmp_path / "theirs")
    again = sweep.compute(tmp_path / "own")
    assert again.keys() == printed.keys() - {"seconds"}
    assert (again["kept"], again["computed"], again["rows_there"]) == (5, 0, 5)
    status = trackwright.sweep_status(tmp_path / "own")
    assert status == program.json("sweep", "status", tmp_path / "own")
    assert (status["rows_there"], status["missing"]) == (5, [])
    files = tmp_path / "own.parquet", tmp_path / "theirs.parquet"
    merged = trackwright.merge_sweep(tmp_path / "own", files[0])
    printed = program.json("sweep", "merge", tmp_path / "theirs", "-o", files[1])
    assert (merged["rows"], merged["bytes"]) == (printed["rows"], printed["bytes"])
    assert files[0].read_bytes() == files[1].read_bytes()


def test_rows_are_what_simulate_finds(plan: Path, tmp_path: Path) -> None:
    Sweep.load(plan).compute(tmp_path / "out")
    # A folder is a table too.
    table = SweepTable.load(tmp_path / "out")
    assert table.rows == len(VALUES) and table.parameters == [SHAFT]
    assert table.columns["position_rms"] == "mm" and table.columns["design"] == ""
    assert table[SHAFT].tolist() == VALUES and table[SHAFT].dtype == np.float64
    assert table["row"].tolist() == [0, 1, 2, 3, 4]
    assert table["design"].tolist() == ["pointer-on-head"] * 5
    assert table["problem"].tolist() == [""] * 5
    design = Design.builtin("pointer-on-head")
    shaft = next(sensor for sensor in design.sensors() if sensor.name == "shaft")
    assert design.numbers()["tool.body.sensors[0].position.z"] == (shaft.position[2], "mm")
    for row, z in enumerate(VALUES):
        moved = design.with_sensor("shaft", [*shaft.position[:2], z])
        figures = trackwright.simulate(moved).figures["figures"]
        for column, part in (("position_rms", "position_mm"), ("angle_rms", "angle_deg")):
            for ending, end in (("", "value"), ("_low", "low"), ("_high", "high")):
                assert table[column + ending][row] == figures[part]["rms"][end]


def test_rows_without_figures_state_why(tmp_path: Path) -> None:
    plan = tmp_path / "plan.sweep.ron"
    plan.write_text(plan_text([60.0, 61.0]))
    # The second design has no sensor of that name.
    with pytest.warns(trackwright.TrackwrightWarning, match="all its rows will state it"):
        sweep = Sweep.load(plan)
    report = sweep.compute(tmp_path / "out")
    assert (report["computed"], report["problems"]) == (4, 2)
    table = SweepTable.load(tmp_path / "out")
    assert np.isnan(table["position_rms"]).tolist() == [False, False, True, True]
    assert [bool(why) for why in table["problem"]] == [False, False, True, True]


def test_errors_have_the_programs_text(program: Program, plan: Path, tmp_path: Path) -> None:
    sweep, out = Sweep.load(plan), tmp_path / "out"
    sweep.compute(out, shard=(1, 2))
    target = tmp_path / "rows.parquet"

    def check(call: Any, *arguments: object, kind: type = TrackwrightError) -> str:
        with pytest.raises(kind) as caught:
            call()
        printed = program.error("sweep", *arguments)
        assert str(caught.value) in printed
        return printed

    part = check(lambda: sweep.compute(out, shard=(3, 2)), plan, "-o", out, "--shard", "3/2")
    assert "expected K/N with K from 1 to N" in part
    gap = check(lambda: trackwright.merge_sweep(out, target), "merge", out, "-o", target)
    assert gap.startswith("rows 2 to 4 are missing") and not target.exists()
    none = tmp_path / "none"
    check(lambda: trackwright.merge_sweep(none, target), "merge", none, "-o", target)
    check(lambda: trackwright.sweep_status(tmp_path), "status", tmp_path)
    check(lambda: Sweep.load(none), none, "-o", out, kind=FileNotFoundError)
    other = tmp_path / "other.sweep.ron"
    other.write_text(plan.read_text().replace("84.0", "85.0"))
    check(lambda: Sweep.load(other).compute(out), other, "-o", out)
    with pytest.raises(TrackwrightError, match="found no column tip, expected one of row, design"):
        SweepTable.load(out)["tip"]
    target.write_text("of somebody else")
    sweep.compute(out)
    check(lambda: trackwright.merge_sweep(out, target), "merge", out, "-o", target)
    assert trackwright.merge_sweep(out, target, overwrite=True)["rows"] == 5


def test_progress_goes_from_none_to_all(plan: Path, tmp_path: Path) -> None:
    parts: list[float] = []
    threads: set[int] = set()

    def progress(part: float) -> None:
        parts.append(part)
        threads.add(threading.get_ident())

    Sweep.load(plan).compute(tmp_path / "out", progress=progress)
    assert parts == sorted(set(parts)) and parts[-1] == 1.0
    assert threads == {threading.get_ident()}
    parts.clear()
    trackwright.merge_sweep(tmp_path / "out", tmp_path / "rows.parquet", progress=progress)
    assert parts[-1] == 1.0


def long_plan(folder: Path) -> Path:
    file = folder / "long.sweep.ron"
    # Hours of work.
    file.write_text(f"""(
        version: 1,
        designs: ["pointer-on-head"],
        vary: [LatinHypercube(count: 100000, ranges: [
            (path: "{IN_RON}", from: 60, to: 90),
        ])],
        motions: [Motion],
    )""")
    return file


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_keeps_the_rows_so_far(tmp_path: Path) -> None:
    sweep, is_sent = Sweep.load(long_plan(tmp_path)), False

    def interrupt(part: float) -> None:
        nonlocal is_sent
        if part > 0.0 and not is_sent:
            is_sent = True
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        sweep.compute(tmp_path / "out", progress=interrupt)
    status = trackwright.sweep_status(tmp_path / "out")
    assert 0 < status["rows_there"] < sweep.rows and status["torn"] == 0


def test_an_exception_of_progress_ends_the_work(tmp_path: Path) -> None:
    def refuse(part: float) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        Sweep.load(long_plan(tmp_path)).compute(tmp_path / "out", progress=refuse)
    assert trackwright.sweep_status(tmp_path / "out")["rows_there"] > 0
