"""What the tests share: the program whose output is expected, and the files of the repository."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
DATA = REPOSITORY / "tests" / "data"

# What the program remembers is not for the person who runs the tests.
os.environ["TRACKWRIGHT_STATE"] = tempfile.mkdtemp()


class Program:
    """The command line, run as a person runs it."""

    def __init__(self, binary: Path) -> None:
        self.binary = binary

    def run(self, *arguments: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        command = [str(self.binary), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, cwd=cwd, check=False)

    def json(self, *arguments: object, cwd: Path | None = None) -> Any:
        """What the program prints with ``--format json``."""
        done = self.run(*arguments, "--format", "json", cwd=cwd)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    def text(self, *arguments: object, cwd: Path | None = None) -> str:
        """What the program prints for a person."""
        done = self.run(*arguments, cwd=cwd)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def error(self, *arguments: object, cwd: Path | None = None) -> str:
        """Why the program does not do what it is requested to do."""
        done = self.run(*arguments, cwd=cwd)
        assert done.returncode != 0, done.stdout
        last = done.stderr.rstrip("\n")
        return last[last.rindex("error: ") + len("error: ") :]


@pytest.fixture(scope="session")
def program() -> Program:
    binary = os.environ.get("TRACKWRIGHT_BIN")
    assert binary, "TRACKWRIGHT_BIN: found nothing, expected the path of the program"
    return Program(Path(binary))


def columns_of(path: Path) -> dict[str, npt.NDArray[np.float64]]:
    """The numbers of a table by column; an empty cell is not a number."""
    with path.open(newline="") as file:
        header, *rows = csv.reader(file)
    cells = [[float(cell) if cell else np.nan for cell in row] for row in rows]
    return dict(zip(header, np.array(cells).T))


def same(a: npt.ArrayLike, b: npt.ArrayLike) -> bool:
    """Whether two arrays are equal to the bit, all that are not a number taken as one."""
    return np.array_equal(np.asarray(a, float), np.asarray(b, float), equal_nan=True)


def pose_parts(
    columns: dict[str, npt.NDArray[np.float64]], begin: str = ""
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Positions and quaternions of a table's poses."""
    position = np.column_stack([columns[begin + end] for end in ("x", "y", "z")])
    quaternion = np.column_stack([columns[begin + end] for end in ("qw", "qx", "qy", "qz")])
    return position, quaternion


@pytest.fixture
def interruptible() -> Iterator[None]:
    """As in a terminal: a shell starts what runs in its background with the signal ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session")
def fit_table() -> Path:
    return DATA / "room-a" / "room-a-fit.csv"


@pytest.fixture(scope="session")
def few_rows(tmp_path_factory: pytest.TempPathFactory, fit_table: Path) -> Path:
    """Some rows of that table: enough for a room of low order, and soon fitted."""
    file = tmp_path_factory.mktemp("few") / "few.csv"
    head, *rows = fit_table.read_text().splitlines()
    file.write_text("\n".join([head, *rows[::6]]) + "\n")
    return file


@pytest.fixture(scope="session")
def holdout_table() -> Path:
    return DATA / "room-a" / "room-a-holdout.csv"


@pytest.fixture(scope="session")
def room_file(tmp_path_factory: pytest.TempPathFactory, fit_table: Path) -> Path:
    """The room that the golden designs are in, fitted by the package."""
    import trackwright

    file = tmp_path_factory.mktemp("room") / "room.env.ron"
    trackwright.Environment.fit(fit_table, order=2, directions=14, name="room").save(file)
    return file
