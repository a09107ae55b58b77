"""Calibrates a pointer's tip, beside scikit-surgerycalibration on the same poses.

    python calibrate_pointer.py
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from sksurgerycalibration.algorithms.pivot import pivot_calibration

import trackwright

TIP_MM = np.array([1.5, -0.8, 152.0])
POINT_MM = np.array([80.0, -30.0, -310.0])
JITTER_MM = 0.25
POSES = 400


def rotation_of(vector: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The quaternion, scalar first, of a rotation vector in radians."""
    angle = float(np.linalg.norm(vector))
    half = np.sinc(angle / (2 * np.pi)) / 2
    return np.array([np.cos(angle / 2), *(half * vector)])


def matrix_of(pose: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The 4x4 matrix of a pose."""
    x, y, z, qw, qx, qy, qz = pose
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (qy**2 + qz**2), 2 * (qx * qy - qz * qw), 2 * (qx * qz + qy * qw)],
        [2 * (qx * qy + qz * qw), 1 - 2 * (qx**2 + qz**2), 2 * (qy * qz - qx * qw)],
        [2 * (qx * qz - qy * qw), 2 * (qy * qz + qx * qw), 1 - 2 * (qx**2 + qy**2)],
    ]
    matrix[:3, 3] = x, y, z
    return matrix


def recorded(seed: int = 1) -> npt.NDArray[np.float64]:
    """Poses of a pointer that was turned about its tip, which rested in one point; with jitter."""
    random = np.random.default_rng(seed)
    turns = random.uniform(-0.6, 0.6, (POSES, 3))
    poses = np.empty((POSES, 7))
    for pose, turn in zip(poses, turns):
        pose[3:] = rotation_of(turn)
        pose[:3] = 0.0
        pose[:3] = POINT_MM - matrix_of(pose)[:3, :3] @ TIP_MM
    poses[:, :3] += random.normal(0.0, JITTER_MM, (POSES, 3))
    return poses


def main() -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    poses = recorded()
    found = trackwright.pivot(poses)
    low, high = np.transpose(found.figures["intervals"]["tip"])
    print(f"trackwright:                {np.round(found.tip, 3)} mm, "
          f"{found.rms_mm:.3f} mm RMS of the distance")
    print(f"  95 %: {np.round(low, 3)} to {np.round(high, 3)} mm")

    matrices = np.array([matrix_of(pose) for pose in poses])
    other, _, residual_mm = pivot_calibration(matrices, {"method": "aos"})
    other = np.asarray(other, dtype=np.float64).reshape(3)
    print(f"scikit-surgerycalibration:  {np.round(other, 3)} mm, "
          f"{float(residual_mm):.3f} mm RMS of a component")
    print(f"true:                       {TIP_MM} mm")
    print(f"difference of the two: {np.linalg.norm(found.tip - other):.1e} mm")
    return found.tip, other


if __name__ == "__main__":
    main()
