"""The worked cases of an independent program, through Python.

Cases of what the package does not have by itself (weights of directions, the logarithm of a rotation,
frame fits of given readings, a fit in a box of its own) are the libraries' own tests.
"""

from __future__ import annotations

import json
import shutil
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from conftest import DATA

from trackwright import Design, Environment, simulate

GOLDEN: dict[str, Any] = json.loads((DATA / "golden" / "golden.json").read_text())

# Of the cases: they were computed in another order, in which sums of some thousand terms differ.
TOLERANCE = 1e-9


def close(found: npt.ArrayLike, expected: npt.ArrayLike) -> bool:
    return np.allclose(found, expected, rtol=TOLERANCE, atol=TOLERANCE)


def turned(quaternions: npt.ArrayLike, vectors: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Rotations turned by rotation vectors in radians, from the left."""
    w, v = np.split(np.asarray(quaternions, float), [1], axis=1)
    vectors = np.asarray(vectors, float)
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    a, b = np.cos(angle / 2), np.sinc(angle / (2 * np.pi)) / 2 * vectors
    return np.hstack([a * w - (b * v).sum(1, keepdims=True), a * v + w * b + np.cross(b, v)])


def same_rotations(found: npt.ArrayLike, expected: npt.ArrayLike) -> bool:
    """A quaternion and its negative are one rotation."""
    dots = (np.asarray(found) * np.asarray(expected)).sum(1, keepdims=True)
    return close(np.asarray(found) * np.sign(dots), expected)


def check_errors(room: Environment, cases: list[dict[str, Any]], key: str, outside: Any) -> None:
    poses = np.array([case["pose"] for case in cases], float)
    errors = np.array([case[key] for case in cases], float)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = room.distort(poses[:, :3], poses[:, 3:], outside=outside)
    assert close(found.positions - poses[:, :3], errors[:, :3])
    assert same_rotations(found.quaternions, turned(poses[:, 3:], errors[:, 3:]))
    if "inside" in cases[0]:
        assert (~found.outside == [case["inside"] for case in cases]).all()


@pytest.mark.parametrize("case", GOLDEN["fits"], ids=lambda case: str(case["method"]))
def test_fits(case: dict[str, Any], fit_table: Path, holdout_table: Path) -> None:
    room = Environment.fit(
        fit_table,
        order=GOLDEN["order"],
        directions=GOLDEN["directions"],
        method=case["method"],
        holdout=holdout_table,
    )
    assert room.figures is not None
    for part, before, after in (
        ("train", "before", "after"),
        ("holdout", "holdout_before", "holdout_after"),
    ):
        for when, expected in (("before", case[before]), ("after", case[after])):
            found = room.figures[part][when]
            assert close([found[key] for key in expected], list(expected.values())), (part, when)
    assert close(room.bounds, case["box"])
    check_errors(room, case["poses"], "error", "clamp")


@pytest.fixture(scope="module")
def room(fit_table: Path) -> Environment:
    return Environment.fit(fit_table, order=GOLDEN["order"], directions=GOLDEN["directions"])


@pytest.mark.parametrize("outside", ["clamp", "extrapolate"])
def test_errors_outside_the_box(room: Environment, outside: Any) -> None:
    check_errors(room, GOLDEN["outside"], outside, outside)


def test_one_direction(fit_table: Path) -> None:
    case = GOLDEN["one_direction"]
    room = Environment.fit(fit_table, order=GOLDEN["order"], directions=1)
    assert room.figures is not None
    after = room.figures["train"]["after"]
    assert close([after[key] for key in case["after"]], list(case["after"].values()))
    check_errors(room, case["poses"], "error", "clamp")


def test_correction_map(fit_table: Path) -> None:
    case = GOLDEN["correction_map"]
    room = Environment.fit(
        fit_table, order=GOLDEN["order"], directions=GOLDEN["directions"], map="correction"
    )
    assert room.figures is not None
    after = room.figures["train"]["after"]
    assert close([after[key] for key in case["after"]], list(case["after"].values()))
    measured = np.array([each["measured"] for each in case["poses"]])
    corrected = np.array([each["corrected"] for each in case["poses"]])
    found = room.compensate(measured[:, :3], measured[:, 3:])
    assert found.converged.all()
    assert close(found.positions, corrected[:, :3])
    assert same_rotations(found.quaternions, corrected[:, 3:])


def golden_design(folder: Path, name: str, room_file: Path) -> Design:
    shutil.copytree(DATA / "golden" / name, folder / name)
    shutil.copy(room_file, folder / name / "room.env.ron")
    return Design.load(folder / name / f"{name}.design.ron")


@pytest.mark.parametrize("mode", ["single", "motion", "input"])
@pytest.mark.parametrize("case", GOLDEN["designs"], ids=lambda case: str(case["design"]))
def test_designs(case: dict[str, Any], mode: Any, room_file: Path, tmp_path: Path) -> None:
    name = Path(case["design"]).parent.name
    design = golden_design(tmp_path, name, room_file)
    poses = tmp_path / name / "input.csv" if mode == "input" else None
    found = simulate(design, mode, poses=poses, expected=False)
    expected = case[mode]
    assert found.figures["trials"] == expected["trials"]
    assert found.figures["outside"] == expected["outside"]
    assert found.figures["worst"]["trial"] == expected["worst"]
    for what in ("position_mm", "angle_deg"):
        for key, value in expected[what].items():
            assert close(found.figures[what][key], value), (what, key)
    trials = found.trials
    names = ("x", "y", "z", "qw", "qx", "qy", "qz")
    for row, trial in zip(trials, expected["first_trials"]):
        for whose in ("true", "sim"):
            pose = np.array([row[f"{whose}_{name}"] for name in names])
            assert close(pose[:3], trial[whose][:3])
            assert same_rotations([pose[3:]], [trial[whose][3:]])
        assert close([row["err_x"], row["err_y"], row["err_z"]], trial["err"])
        assert close([row["err_mm"], row["err_deg"]], [trial["err_mm"], trial["err_deg"]])
        assert row["outside"] == trial["outside"]


@pytest.mark.parametrize("case", GOLDEN["undetermined"])
def test_undetermined_rotations(case: dict[str, Any]) -> None:
    # The case's sensors alone, on a tool whose others are taken away.
    design = Design.builtin("pointer-on-head")
    names = [sensor.name for sensor in design.sensors()]
    for number, sensor in enumerate(case["sensors"]):
        design = design.with_sensor(f"case {number}", sensor["position"], axis=sensor["axis"])
    for name in names:
        design = design.without_sensor(name)
    free = simulate(design, expected=False).figures["free_axis"]
    assert free["body"] == "tool"
    axis = np.array(free["axis"])
    assert close(axis * np.sign(axis @ case["free_axis"]), case["free_axis"])
