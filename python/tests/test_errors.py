"""Exceptions have the text that the program prints, but that options are keywords here."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from conftest import Program

import trackwright
from trackwright import Design, Environment, Recording, Tool, TrackwrightError


def raised(call: Callable[[], object]) -> Exception:
    with pytest.raises(Exception) as caught:
        call()
    return caught.value


@pytest.fixture()
def files(tmp_path: Path, fit_table: Path) -> dict[str, Path]:
    """Files that are not what they should be."""
    head, *rows = fit_table.read_text().splitlines()
    texts = {
        "no.design.ron": "(version: 1, name: 3)",
        "new.design.ron": "(version: 99)",
        "no.env.ron": "()",
        "cell.csv": "\n".join([head, rows[0], "x" + rows[1]]),
        "nan.csv": "\n".join([head, rows[0].replace(rows[0].split(",")[0], "NaN")]),
        "head.csv": "ideal_x,ideal_y\n1,2\n",
        "empty.csv": head + "\n",
        "poses.csv": "x,y,z,qw,qx,qy,qz\n1,2,3,2,0,0,0\n",
        "few.csv": "x,y,z,qw,qx,qy,qz\n" + "1,2,3,1,0,0,0\n" * 3,
        "still.csv": "x,y,z,qw,qx,qy,qz\n" + "1,2,3,1,0,0,0\n" * 30,
        "line.csv": "x,y,z\n0,0,0\n1,0,0\n2,0,0\n3,0,0\n",
        "two.csv": "x,y,z\n0,0,0\n1,0,0\n",
        "text.rom": "not a ROM",
    }
    found = {}
    for name, text in texts.items():
        found[name] = tmp_path / name
        found[name].write_text(text)
    return found


OUT = "out.file"

# The program's arguments and the call, of which each file is given by its name.
CASES: dict[str, tuple[list[Any], Callable[[dict[str, Path]], object]]] = {
    "no design": (
        ["simulate", "no.design.ron", "--mode", "single"],
        lambda f: Design.load(f["no.design.ron"]),
    ),
    "another version": (
        ["simulate", "new.design.ron", "--mode", "single"],
        lambda f: Design.load(f["new.design.ron"]),
    ),
    "no room": (
        ["distort", "no.env.ron", "few.csv", "-o", OUT],
        lambda f: Environment.load(f["no.env.ron"]),
    ),
    "a cell": (
        ["fit", "cell.csv", "-o", OUT, "--order", "1", "--directions", "1"],
        lambda f: Environment.fit(f["cell.csv"], order=1, directions=1),
    ),
    "not a number": (
        ["fit", "nan.csv", "-o", OUT, "--order", "1", "--directions", "1"],
        lambda f: Environment.fit(f["nan.csv"], order=1, directions=1),
    ),
    "columns": (
        ["fit", "head.csv", "-o", OUT, "--order", "1", "--directions", "1"],
        lambda f: Environment.fit(f["head.csv"], order=1, directions=1),
    ),
    "no rows": (
        ["select", "empty.csv"],
        lambda f: Environment.select(f["empty.csv"]),
    ),
    "quaternions": (
        ["pivot", "poses.csv"],
        lambda f: trackwright.pivot(f["poses.csv"]),
    ),
    "few poses": (
        ["pivot", "few.csv", "--min-poses", "5"],
        lambda f: trackwright.pivot(f["few.csv"], min_poses=5),
    ),
    "no turns": (["pivot", "still.csv"], lambda f: trackwright.pivot(f["still.csv"])),
    "no shaft": (["pivot", "--spin", "still.csv"], lambda f: trackwright.spin(f["still.csv"])),
    "two points": (
        ["register", "two.csv", "two.csv"],
        lambda f: trackwright.register(f["two.csv"], f["two.csv"]),
    ),
    "a line": (
        ["register", "line.csv", "line.csv"],
        lambda f: trackwright.register(f["line.csv"], f["line.csv"]),
    ),
    "no ROM": (
        ["convert", "text.rom", "out.body.ron"],
        lambda f: Tool.load(f["text.rom"]),
    ),
}

# How the program names an option, and how it is named here.
OPTIONS = {
    "--min-poses": "min_poses",
    "--min-range-deg": "min_range_deg",
    "--as-is": "as_is=True",
}


@pytest.mark.parametrize("name", CASES)
def test_texts_are_those_of_the_program(
    program: Program, files: dict[str, Path], tmp_path: Path, name: str
) -> None:
    arguments, call = CASES[name]
    named = [files.get(argument, argument) for argument in arguments]
    printed = program.error(*named, cwd=tmp_path)
    for option, keyword in OPTIONS.items():
        printed = printed.replace(option, keyword)
    # Calls with two files do not name them: they may be arrays.
    both = f"{files['two.csv']} and {files['two.csv']}: "
    printed = printed.replace(both, "").replace(both.replace("two", "line"), "")
    error = raised(lambda: call(files))
    assert isinstance(error, TrackwrightError) and isinstance(error, ValueError)
    assert str(error) == printed


@pytest.mark.parametrize(
    ("arguments", "load"),
    [
        (["simulate", "none.design.ron", "--mode", "single"], Design.load),
        (["distort", "none.design.ron", "few.csv", "-o", OUT], Environment.load),
        (["convert", "none.design.ron", "out.body.ron"], Tool.load),
        (["fit", "none.design.ron", "-o", OUT], Environment.fit),
        (["pivot", "none.design.ron"], trackwright.pivot),
    ],
)
def test_missing_files_are_not_found(
    program: Program,
    files: dict[str, Path],
    tmp_path: Path,
    arguments: list[Any],
    load: Callable[[Path], object],
) -> None:
    missing = tmp_path / "none.design.ron"
    named = [missing if a == missing.name else files.get(a, a) for a in arguments]
    error = raised(lambda: load(missing))
    assert isinstance(error, FileNotFoundError)
    assert str(error) == program.error(*named, cwd=tmp_path)


def test_what_the_system_refuses_is_an_os_error(tmp_path: Path, room_file: Path) -> None:
    for error in (
        raised(lambda: Recording.load(tmp_path)),
        raised(lambda: Environment.load(room_file).save(tmp_path / "none" / "room.env.ron")),
    ):
        assert isinstance(error, OSError), error


def test_doubted_tables_are_taken_on_request(few_rows: Path) -> None:
    from conftest import columns_of

    # In metres: no tracker's table is like that.
    columns = columns_of(few_rows)
    metres = {
        name: column / 1000 if name.endswith(("_x", "_y", "_z")) else column
        for name, column in columns.items()
        if not name.endswith(("qx", "qy", "qz", "qw"))
    }
    with pytest.raises(TrackwrightError, match="as_is=True takes the table as it stands"):
        Environment.fit(metres, order=1, directions=1)
    with pytest.warns(trackwright.TrackwrightWarning):
        assert Environment.fit(metres, order=1, directions=1, as_is=True).bounds.max() < 1.0


def test_warnings_can_be_made_errors(few_rows: Path) -> None:
    import warnings

    room = Environment.fit(few_rows, order=1, directions=1)
    far = [[1e4, 0.0, 0.0]], [[1.0, 0.0, 0.0, 0.0]]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(trackwright.TrackwrightWarning, match="outside the room's box"):
            room.distort(*far)
