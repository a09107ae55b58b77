"""The examples run without a screen, and find what they are to find."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def run(script: str, *arguments: object) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error::UserWarning", str(EXAMPLES / script), *map(str, arguments)],
        capture_output=True,
        text=True,
        env={**os.environ, "MPLBACKEND": "Agg"},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_room_is_fitted_and_drawn(tmp_path: Path, fit_table: Path) -> None:
    picture = tmp_path / "room.png"
    printed = run("fit_room.py", fit_table, picture)
    assert "mm after the fit" in printed and "compensated:" in printed
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_sensor_is_placed() -> None:
    printed = run("place_sensor.py")
    rms = [float(found) for found in re.findall(r"tip error ([0-9.]+) mm RMS", printed)]
    assert len(rms) == 9 and f"{min(rms):.4f} mm RMS" in printed.splitlines()[-2]


def test_a_pointer_is_calibrated_beside_another_library() -> None:
    printed = run("calibrate_pointer.py")
    difference = float(printed.splitlines()[-1].split()[-2])
    # The same least squares, solved in another way.
    assert difference < 1e-6
