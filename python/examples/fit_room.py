"""Fits a room to measurements and looks at it: how far the tracker is off in one plane.

    python fit_room.py [MEASUREMENTS.csv] [PICTURE.png]
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import trackwright

REPOSITORY = Path(__file__).resolve().parents[2]
TABLE = REPOSITORY / "assets" / "environments" / "data" / "cube-fit.csv"

# Points a side of the plane.
GRID = 25


def main(table: Path = TABLE, picture: Path | None = None) -> trackwright.Environment:
    room = trackwright.Environment.fit(table, order=2, directions=14, name="measured room")
    assert room.figures is not None
    train = room.figures["train"]
    print(f"{room.figures['samples']} samples, position RMS "
          f"{train['before']['position_rms_mm']:.2f} mm before, "
          f"{train['after']['position_rms_mm']:.2f} mm after the fit")

    # A plane across the middle of the room, sensors pointing along z.
    (x0, y0, z0), (x1, y1, z1) = room.bounds
    x, y = np.meshgrid(np.linspace(x0, x1, GRID), np.linspace(y0, y1, GRID))
    positions = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, (z0 + z1) / 2)])
    quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (len(positions), 1))

    measured = room.distort(positions, quaternions)
    error_mm = measured.positions - positions
    distance_mm = np.linalg.norm(error_mm, axis=1)
    print(f"error in the plane: mean {distance_mm.mean():.2f} mm, largest {distance_mm.max():.2f} mm")
    validity = room.validity(positions, quaternions)
    print(f"standard error of a reading: {np.median(validity.std_error_mm):.2f} mm in the median")

    # What was distorted is found again.
    back = room.compensate(measured.positions, measured.quaternions)
    found = back.converged & ~back.ambiguous
    left_mm = np.linalg.norm(back.positions[found] - positions[found], axis=1)
    print(f"compensated: {found.sum()} of {len(positions)} readings, "
          f"largest rest {left_mm.max():.1e} mm")

    figure, axes = plt.subplots(figsize=(6, 5))
    shades = axes.pcolormesh(x, y, distance_mm.reshape(x.shape), shading="gouraud")
    axes.quiver(positions[:, 0], positions[:, 1], error_mm[:, 0], error_mm[:, 1])
    figure.colorbar(shades, label="error of a reading, mm")
    axes.set(xlabel="x, mm", ylabel="y, mm", title=f"{room.name}, z = {(z0 + z1) / 2:.0f} mm")
    axes.set_aspect("equal")
    if picture is None:
        plt.show()
    else:
        figure.savefig(picture)
        print(f"written: {picture}")
    plt.close(figure)
    return room


if __name__ == "__main__":
    given = [Path(argument) for argument in sys.argv[1:]]
    main(given[0] if given else TABLE, given[1] if len(given) > 1 else None)
