"""Rooms are fitted, chosen and applied as the program does it, to the bit."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
from conftest import Program, columns_of, pose_parts, same

import trackwright
from trackwright import Environment


def fitted_by(program: Program, tmp_path: Path, command: str, *arguments: object) -> tuple[Any, str]:
    """The figures and the file of a room that the program makes."""
    file = tmp_path / "program" / "room.env.ron"
    file.parent.mkdir()
    return program.json(command, *arguments, "-o", file), file.read_text()


def text_of(room: Environment, tmp_path: Path) -> str:
    file = tmp_path / "room.env.ron"
    room.save(file, overwrite=True)
    return file.read_text()


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        ({"order": 2, "directions": 14}, ["--order", 2, "--directions", 14]),
        ({"order": 2, "directions": 6, "method": "joint", "ridge": 1e-3, "support": False},
         ["--order", 2, "--directions", 6, "--method", "joint", "--ridge", 1e-3, "--no-support"]),
        ({"map": "correction", "order": 1, "directions": 1, "sensors": "6dof", "volume": "cube",
          "jitter_position_mm": 0.1, "jitter_angle_deg": 0.2},
         ["--map", "correction", "--order", 1, "--directions", 1, "--sensors", "6dof", "--volume",
          "cube", "--jitter-position-mm", 0.1, "--jitter-angle-deg", 0.2]),
        ({"generator": "planar-nine", "degree": 2, "ridge": 1e-2, "lag": -0.5, "sensor_offset": 0.2,
          "registration_mm": 0.3, "registration_deg": 0.1},
         ["--generator", "planar-nine", "--degree", 2, "--ridge", 1e-2, "--lag", -0.5, "--sensor-offset", 0.2,
          "--registration-mm", 0.3, "--registration-deg", 0.1]),
    ],
)
def test_a_fit_is_that_of_the_program(
    program: Program,
    few_rows: Path,
    holdout_table: Path,
    tmp_path: Path,
    options: dict[str, Any],
    arguments: list[object],
) -> None:
    printed, text = fitted_by(
        program, tmp_path, "fit", few_rows, "--holdout", holdout_table, *arguments
    )
    room = Environment.fit(few_rows, holdout=holdout_table, name="room", **options)
    assert room.figures == printed
    assert text_of(room, tmp_path) == text


def test_a_choice_is_that_of_the_program(
    program: Program, few_rows: Path, tmp_path: Path
) -> None:
    arguments = ["--orders", "1-2", "--directions", "1,6", "--ridges", "0,1e-3", "--folds", 4]
    printed, text = fitted_by(program, tmp_path, "select", few_rows, *arguments)
    room = Environment.select(
        few_rows, orders=[1, 2], directions=[1, 6], ridges=[0, 1e-3], folds=4, name="room"
    )
    assert room.figures == printed
    assert text_of(room, tmp_path) == text


def test_tables_in_memory_make_the_same_room(few_rows: Path, tmp_path: Path) -> None:
    options: dict[str, Any] = {"order": 1, "directions": 6, "name": "room"}
    from_file = Environment.fit(few_rows, **options)
    columns = columns_of(few_rows)
    frame = pandas.DataFrame(columns)
    records = np.rec.fromarrays(list(columns.values()), names=list(columns))
    # Every second of twice as many: not contiguous, and nothing is to be copied for that.
    strided = {name: np.repeat(column, 2)[::2] for name, column in columns.items()}
    expected = text_of(from_file, tmp_path).replace(few_rows.name, "table")
    tables: list[Any] = [columns, strided, records, frame]
    for table in tables:
        room = Environment.fit(table, **options)
        assert room.figures == from_file.figures
        assert text_of(room, tmp_path) == expected


def test_columns_of_groups_are_held_out(few_rows: Path) -> None:
    columns: dict[str, Any] = dict(columns_of(few_rows))
    rows = len(columns["ideal_x"])
    columns["cluster"] = [f"group {row % 7}" for row in range(rows)]
    options: dict[str, Any] = {"orders": [1], "directions": [1], "ridges": [0]}
    chosen = Environment.select(columns, **options).figures
    assert chosen is not None
    assert chosen["groups"] == {"by": "column cluster", "count": 7}
    frame = pandas.DataFrame(columns)
    assert Environment.select(frame, **options).figures == chosen


def test_empty_cells_of_data_frames_are_refused(few_rows: Path) -> None:
    frame = pandas.DataFrame(columns_of(few_rows))
    frame.loc[3, "ideal_x"] = None
    with pytest.raises(trackwright.TrackwrightError, match="ideal_x, row 3: found NaN"):
        Environment.fit(frame, order=1, directions=1)
    whole = frame.assign(ideal_x=pandas.array([None] * len(frame), dtype="Float64"))
    with pytest.raises(trackwright.TrackwrightError, match="ideal_x: found empty cells"):
        Environment.fit(whole, order=1, directions=1)


@pytest.mark.parametrize("outside", ["clamp", "extrapolate", "reject"])
def test_poses_are_distorted_as_by_the_program(
    program: Program, room_file: Path, fit_table: Path, tmp_path: Path, outside: Any
) -> None:
    table = poses_file(fit_table, tmp_path, scale=1.2)
    out = tmp_path / "out.csv"
    done = program.run("distort", room_file, table, "-o", out, "--outside", outside)
    assert done.returncode == 0, done.stderr
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        positions, quaternions = pose_parts(columns_of(table))
        found = Environment.load(room_file).distort(positions, quaternions, outside=outside)
    # What the program prints as a warning or a note is a warning here.
    assert [str(each.message) for each in caught] == [done.stderr.strip().split(": ", 1)[1]]
    written = columns_of(out)
    expected = pose_parts(written)
    assert same(found.positions, expected[0]) and same(found.quaternions, expected[1])
    assert same(found.outside, written["outside"])
    assert found.outside.any() and not found.outside.all()


def test_readings_are_compensated_as_by_the_program(
    program: Program, room_file: Path, fit_table: Path, tmp_path: Path
) -> None:
    table = poses_file(fit_table, tmp_path)
    out = tmp_path / "out.csv"
    printed = program.json("compensate", room_file, table, "-o", out)
    found = Environment.load(room_file).compensate(*pose_parts(columns_of(table)))
    assert found.figures == printed
    written = columns_of(out)
    expected = pose_parts(written)
    assert same(found.positions, expected[0]) and same(found.quaternions, expected[1])
    for name in ("outside", "converged", "ambiguous"):
        assert same(getattr(found, name), written[name]), name


def test_validity_is_that_of_the_program(
    program: Program, room_file: Path, fit_table: Path, tmp_path: Path
) -> None:
    table = poses_file(fit_table, tmp_path)
    out = tmp_path / "out.csv"
    assert program.run("distort", room_file, table, "-o", out, "--support").returncode == 0
    found = Environment.load(room_file).validity(*pose_parts(columns_of(table)))
    written = columns_of(out)
    assert found.dtype.names is not None
    for name in found.dtype.names:
        assert same(found[name], written[name]), name


def test_a_room_comes_back_from_its_file(room_file: Path, tmp_path: Path) -> None:
    room = Environment.load(room_file)
    assert text_of(room, tmp_path) == room_file.read_text()
    assert (room.name, room.map, room.model, room.figures) == (
        "room",
        "distortion",
        "bernstein",
        None,
    )
    assert room.bounds.shape == (2, 3) and (room.bounds[0] < room.bounds[1]).all()


def poses_file(fit_table: Path, tmp_path: Path, scale: float = 1.0) -> Path:
    """Some poses of a measurement table as a table of poses."""
    columns = columns_of(fit_table)
    names = ("x", "y", "z", "qw", "qx", "qy", "qz")
    rows = np.column_stack([columns[f"measured_{name}"] for name in names])[:60]
    rows[:, :2] *= scale
    file = tmp_path / "poses.csv"
    lines = [",".join(names), *(",".join(repr(float(v)) for v in row) for row in rows)]
    file.write_text("\n".join(lines) + "\n")
    return file


def test_unknown_keywords_are_refused(fit_table: Path) -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument \"ordre\""):
        Environment.fit(fit_table, ordre=2)  # type: ignore[call-arg]


def test_a_document_of_others_is_not_written_over(room_file: Path, tmp_path: Path) -> None:
    taken = tmp_path / "taken.env.ron"
    taken.write_text("not a room")
    room = Environment.load(room_file)
    with pytest.raises(trackwright.TrackwrightError, match="that no command wrote"):
        room.save(taken)
    assert taken.read_text() == "not a room"
    room.save(taken, overwrite=True)
    assert taken.read_text() == room_file.read_text()
