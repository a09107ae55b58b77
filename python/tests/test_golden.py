"""Every worked case of an independent program, through Python."""

from __future__ import annotations

import json
import shutil
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from conftest import DATA, columns_of

import trackwright
from trackwright import Design, Environment, Sensor, simulate

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
            assert close(found.figures["room_field"][what][key], value), (what, key)
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


def quaternion(rows: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """The quaternion of a rotation matrix: the eigenvector of Bar-Itzhack (J. Guidance 23(6), 2000)."""
    r = np.reshape(np.asarray(rows, float), (3, 3))
    k = np.zeros((4, 4))
    k[0, 0] = np.trace(r)
    k[0, 1:] = k[1:, 0] = [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]
    k[1:, 1:] = r + r.T - np.trace(r) * np.eye(3)
    found: npt.NDArray[np.float64] = np.linalg.eigh(k)[1][:, -1]
    return found


def rotation_matrix(q: npt.ArrayLike) -> npt.NDArray[np.float64]:
    w, x, y, z = np.asarray(q, float)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * (w * cross + cross @ cross)


def sensors_of(case: dict[str, Any]) -> list[Sensor]:
    found = []
    for number, sensor in enumerate(case["sensors"]):
        if sensor["dof"] == 6:
            how = {"rotation": quaternion(sensor["rotation"])}
        elif "rotation" in sensor:
            how = {"axis": np.reshape(sensor["rotation"], (3, 3))[:, 2]}
        else:
            how = {"axis": sensor["axis"]}
        found.append(Sensor(f"case {number}", sensor["position"], **how))
    return found


def same_frame(fit: trackwright.FrameFit, case: dict[str, Any]) -> bool:
    pose = fit.tracker_from_body
    expected = np.reshape(case["rotation"], (3, 3))
    return close(pose[:3], case["translation"]) and close(rotation_matrix(pose[3:]), expected)


@pytest.mark.parametrize("case", GOLDEN["frame_fits"])
def test_frame_fits(case: dict[str, Any]) -> None:
    fit = trackwright.fit_frame(
        sensors_of(case),
        [each["position"] for each in case["measured"]],
        [quaternion(each["rotation"]) for each in case["measured"]],
    )
    assert fit.determination == "full" and fit.free_axis is None
    assert same_frame(fit, case)
    assert close(fit.singular_values_mm2, case["singular_values"])


@pytest.mark.parametrize("case", GOLDEN["reflections"])
def test_planar_markers_are_not_reflected(case: dict[str, Any]) -> None:
    markers = [Sensor(f"{k}", at, marker=True) for k, at in enumerate(case["position"])]
    assert same_frame(trackwright.fit_frame(markers, case["measured"]), case)
    # Axes without weight are none.
    coils = [Sensor(f"{k}", at, axis=[0, 0, 1]) for k, at in enumerate(case["position"])]
    fit = trackwright.fit_frame(coils, case["measured"], orientation_weight_mm=0.0)
    assert same_frame(fit, case)


@pytest.mark.parametrize("case", GOLDEN["uncertainty"])
def test_uncertainty_of_a_tip(case: dict[str, Any]) -> None:
    sensors = sensors_of(case)
    position = np.reshape(case["position_covariance_mm2"], (3, 3))
    rotation = np.reshape(case["rotation_covariance_rad2"], (3, 3)) * np.degrees(1.0) ** 2
    expected = np.reshape(case["tip_covariance_mm2"], (3, 3))
    for each in (position, rotation), ([position] * len(sensors), [rotation] * len(sensors)):
        found = trackwright.point_covariance(
            sensors, case["tip"], *each, orientation_weight_mm=case["orientation_weight_mm"]
        )
        assert close(found, expected)


def check_weights(axis: npt.ArrayLike, directions: int, kind: Any, parts: list[dict[str, Any]]) -> None:
    found = trackwright.orientation_weights([axis], directions, weights=kind)[0]
    basis = trackwright.basis_orientations(directions)
    expected = np.zeros(directions)
    for part in parts:
        index = np.linalg.norm(basis - part["direction"], axis=1).argmin()
        assert close(basis[index], part["direction"])
        expected[index] = part["weight"]
    assert close(found, expected)


@pytest.mark.parametrize("case", GOLDEN["weights"])
def test_weights_of_the_papers_set(case: dict[str, Any]) -> None:
    check_weights(case["axis"], 14, "area", case["parts"])


@pytest.mark.parametrize("case", GOLDEN["weight_sets"])
@pytest.mark.parametrize("kind", ["area", "gnomonic"])
def test_weights_of_every_set(case: dict[str, Any], kind: Any) -> None:
    check_weights(case["axis"], case["directions"], kind, case[kind])


def test_rotation_vectors() -> None:
    cases = GOLDEN["rotation_log"]
    found = trackwright.rotation_vectors([quaternion(case["rotation"]) for case in cases])
    assert close(found, [case["log"] for case in cases])


def test_least_norm_in_a_box_of_its_own(fit_table: Path) -> None:
    case = GOLDEN["least_norm"]
    few = {name: column[: case["samples"]] for name, column in columns_of(fit_table).items()}
    order, directions = case["order"], case["directions"]
    with warnings.catch_warnings():
        # Of more unknowns than samples.
        warnings.simplefilter("ignore")
        room = Environment.fit(few, order=order, directions=directions, bounds=case["box"])
    assert close(room.bounds, case["box"]) and room.figures is not None
    assert close(list(room.figures["train"]["after"].values()), 0.0)
    check_errors(room, case["poses"], "error", "clamp")


@pytest.mark.parametrize("case", GOLDEN["undetermined"])
def test_free_axes_of_frame_fits(case: dict[str, Any]) -> None:
    sensors = sensors_of(case)
    vectors = [np.cross([0, 0, 1], sensor["axis"]) for sensor in case["sensors"]]
    # Turned from z to each axis; those along z are not.
    sines = np.linalg.norm(vectors, axis=1, keepdims=True)
    z = np.array([sensor["axis"][2] for sensor in case["sensors"]])[:, None]
    angles = np.arctan2(sines, z)
    across = np.where(sines > 0, np.divide(vectors, np.where(sines > 0, sines, 1)), [[1, 0, 0]])
    identity = np.tile([1.0, 0, 0, 0], (len(sensors), 1))
    fit = trackwright.fit_frame(
        sensors, [s["position"] for s in case["sensors"]], turned(identity, angles * across)
    )
    assert fit.determination == "free-axis" and fit.free_axis is not None
    assert close(fit.free_axis * np.sign(fit.free_axis @ case["free_axis"]), case["free_axis"])
    # The turn that is free is that of the pose nearby, the identity.
    assert close(fit.tracker_from_body, [0, 0, 0, 1, 0, 0, 0])


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
