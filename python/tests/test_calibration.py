"""Calibrations are those of the program, whichever way the poses come in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas
import pytest
from conftest import Program

import trackwright

Floats = npt.NDArray[np.float64]
NAMES = ("x", "y", "z", "qw", "qx", "qy", "qz")


def quaternion(vector: npt.ArrayLike) -> Floats:
    """Of a rotation vector in radians, scalar first."""
    vector = np.asarray(vector, float)
    angle = float(np.linalg.norm(vector))
    return np.array([np.cos(angle / 2), *(np.sinc(angle / (2 * np.pi)) / 2 * vector)])


def rotation(q: npt.ArrayLike) -> Floats:
    w, x, y, z = np.asarray(q, float)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def product(a: Floats, b: Floats) -> Floats:
    """The pose `a · b` of two poses."""
    aw, av, bw, bv = a[3], a[4:], b[3], b[4:]
    w = aw * bw - av @ bv
    return np.array(
        [*(a[:3] + rotation(a[3:]) @ b[:3]), w, *(aw * bv + bw * av + np.cross(av, bv))]
    )


def turned_about(tip: Floats, point: Floats, count: int, noise_mm: float) -> Floats:
    random = np.random.default_rng(3)
    poses = np.empty((count, 7))
    for pose in poses:
        pose[3:] = quaternion(random.uniform(-0.6, 0.6, 3))
        pose[:3] = point - rotation(pose[3:]) @ tip + random.normal(0.0, noise_mm, 3)
    return poses


def written(poses: Floats, file: Path) -> Path:
    lines = [",".join(NAMES), *(",".join(repr(float(v)) for v in row) for row in poses)]
    file.write_text("\n".join(lines) + "\n")
    return file


TIP, POINT = np.array([1.0, -2.0, 150.0]), np.array([80.0, -30.0, -310.0])


@pytest.fixture(scope="module")
def pivot_poses() -> Floats:
    return turned_about(TIP, POINT, 120, 0.2)


def test_a_tip_is_that_of_the_program(
    program: Program, pivot_poses: Floats, tmp_path: Path
) -> None:
    file = written(pivot_poses, tmp_path / "poses.csv")
    printed = program.json("pivot", file)
    frame = pandas.DataFrame(dict(zip(NAMES, pivot_poses.T)))
    strided = np.repeat(pivot_poses, 2, axis=0)[::2]
    given: list[Any] = [pivot_poses, strided, pivot_poses.tolist(), file, str(file), [file], frame]
    for poses in given:
        found = trackwright.pivot(poses)
        assert found.figures == printed
    assert np.array_equal(found.tip, printed["tip"])
    assert np.linalg.norm(found.tip - TIP) < 0.2
    assert str(found) == program.text("pivot", file).rstrip()
    rms = f"{printed['rms_mm']:.3f} mm"
    assert isinstance(found, trackwright.Found)
    assert rms in str(found) and f"<td>{rms}" in found._repr_html_()


def test_a_shaft_is_that_of_the_program(program: Program, tmp_path: Path) -> None:
    random = np.random.default_rng(4)
    poses = np.empty((90, 7))
    for number, pose in enumerate(poses):
        pose[:3] = random.normal(0.0, 0.1, 3) + [10.0, 20.0, -300.0]
        pose[3:] = quaternion([0.002 * random.normal(), 0.002 * random.normal(), 0.07 * number])
    file = written(poses, tmp_path / "poses.csv")
    printed = program.json("pivot", "--spin", file, "--tip", "0,0,-150")
    found = trackwright.spin(poses, tip=[0.0, 0.0, -150.0])
    assert found.figures == printed["spin"]
    assert found.towards_tip and found.shaft[2] < -0.99


def test_a_registration_is_that_of_the_program(program: Program, tmp_path: Path) -> None:
    random = np.random.default_rng(5)
    source = random.uniform(-80.0, 80.0, (9, 3))
    target = source @ rotation(quaternion([0.3, -0.2, 0.9])).T + [10.0, 20.0, 30.0]
    target += random.normal(0.0, 0.3, target.shape)
    files = []
    for name, points in (("source", source), ("target", target)):
        file = tmp_path / f"{name}.csv"
        rows = "\n".join(",".join(repr(float(v)) for v in row) for row in points)
        file.write_text(f"x,y,z\n{rows}\n")
        files.append(file)
    printed = program.json("register", *files)
    found = trackwright.register(source, target)
    assert found.figures == printed
    assert trackwright.register(*files).figures == printed
    assert np.array_equal(found.residuals_mm, printed["residuals_mm"])
    moved, tre_mm = found.move_points(source)
    assert np.allclose(np.linalg.norm(moved - target, axis=1), found.residuals_mm, atol=1e-9)
    assert tre_mm.shape == (9,) and (tre_mm > 0.0).all()


def test_two_trackers_are_laid_over_each_other() -> None:
    random = np.random.default_rng(6)
    tracker_from_reference = np.array([100.0, -50.0, 20.0, *quaternion([0.1, 1.2, -0.4])])
    body_from_sensor = [
        np.array([10.0, 0.0, 5.0, *quaternion([0.3, 0.1, 0.0])]),
        np.array([-20.0, 8.0, 0.0, *quaternion([0.0, -0.7, 0.2])]),
    ]
    read, reference, sensors, moments = [], [], [], []
    for moment in range(30):
        body = np.array([*random.uniform(-100, 100, 3), *quaternion(random.uniform(-0.8, 0.8, 3))])
        for sensor, own in enumerate(body_from_sensor):
            read.append(product(product(tracker_from_reference, body), own))
            reference.append(body)
            sensors.append(sensor)
            moments.append(moment)
    found = trackwright.hand_eye(read, reference, sensor=np.array(sensors), pose=moments)
    assert np.allclose(found.tracker_from_reference, tracker_from_reference, atol=1e-6)
    for own, expected in zip(found.body_from_sensor, body_from_sensor):
        assert np.allclose(own * np.sign(own[3:] @ expected[3:]), expected, atol=1e-6) or (
            np.allclose(own, expected, atol=1e-6)
        )
    assert found.errors_mm.max() < 1e-6 and found.errors_deg.max() < 1e-6
    noisy = np.array(read)
    noisy[:, :3] += random.normal(0.0, 0.2, (len(noisy), 3))
    found = trackwright.hand_eye(noisy, reference, sensor=sensors, pose=moments)
    assert 0.1 < found.errors_mm.mean() < 0.6
    assert found.covariance.shape == (18, 18)
    # Rounding of sums alone: to the digits of the largest.
    rounding = 1e-12 * np.abs(found.covariance).max()
    assert np.allclose(found.covariance, found.covariance.T, rtol=0.0, atol=rounding)
    off = found.tracker_from_reference[:3] - tracker_from_reference[:3]
    # Five standard errors.
    assert (np.abs(off) < 5 * np.sqrt(np.diag(found.covariance)[3:6])).all()
