"""Searches and comparisons are those of the program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from conftest import Program

import trackwright
from trackwright import Design


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory, few_rows: Path) -> Path:
    """Two designs in a room of few measurements."""
    folder = tmp_path_factory.mktemp("search")
    room = folder / "own.env.ron"
    trackwright.Environment.fit(few_rows, order=1, directions=1).save(room)
    design = Design.builtin("pointer-on-head").with_motion({"x": (-30.0, 30.0, 30.0)})
    design = design.with_environment(room)
    design.save(folder / "a.design.ron")
    sensor = design.sensors()[1]
    moved = design.with_name("moved").with_sensor(sensor.name, sensor.position + [0.0, 0.0, 8.0])
    moved.save(folder / "b.design.ron")
    return folder


def test_a_comparison_is_that_of_the_program(program: Program, saved: Path) -> None:
    files = [saved / "a.design.ron", saved / "b.design.ron"]
    printed = program.json("compare", *files)
    assert trackwright.compare(*map(Design.load, files)) == printed


def test_rooms_are_compared_in(program: Program, saved: Path, room_file: Path) -> None:
    files = [saved / "a.design.ron", saved / "b.design.ron"]
    printed = program.json("compare", *files, "--environment", room_file, "--baseline", files[1])
    room = trackwright.Environment.load(room_file)
    found = trackwright.compare(*map(Design.load, files), environments=[room], baseline=1)
    assert found == printed


def test_places_are_those_of_the_program(program: Program, tmp_path: Path) -> None:
    file = tmp_path / "still.design.ron"
    Design.builtin("pointer-on-head").with_motion(None).save(file)
    # Long enough for the end of a search with one sensor that moves along a channel.
    options: dict[str, Any] = {"moves": ["grip"], "metric": "position_rms", "seconds": 500.0}
    printed = program.json(
        "optimize", file, "-o", tmp_path / "better.design.ron", "--move", "grip",
        "--metric", "position_rms", "--seconds", 500,
    )  # fmt: skip
    found = trackwright.optimize(Design.load(file), **options)
    figures = {**found.figures, "seconds": printed["seconds"], "written": printed["written"]}
    assert figures == printed
    better = Design.load(tmp_path / "better.design.ron")
    assert found.design.sensors() == better.sensors()
    assert found.is_better == printed["is_better"]
