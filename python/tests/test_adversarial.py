"""Whatever comes in is used or refused with a reason; nothing crashes, nothing is taken for another."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import columns_of

import trackwright
from trackwright import Environment, TrackwrightError

Q = np.array([[1.0, 0.0, 0.0, 0.0]] * 3)
P = np.array([[0.0, 0.0, -200.0]] * 3)


@pytest.fixture(scope="module")
def room(room_file: Path) -> Environment:
    return Environment.load(room_file)


@pytest.mark.parametrize(
    ("positions", "quaternions", "text"),
    [
        (np.zeros((0, 3)), np.zeros((0, 4)), "positions: found no rows"),
        (np.zeros(3), Q, "positions: found the shape (3,), expected (n, 3)"),
        (np.zeros((3, 2)), Q, "positions: found the shape (3, 2), expected (n, 3)"),
        (np.zeros((1, 3, 3)), Q, "positions: found the shape (1, 3, 3), expected (n, 3)"),
        (np.ma.masked_equal(P, 0.0), Q, "positions: found masked cells, expected none"),
        (np.zeros((3, 3), complex), Q, "positions: found the dtype complex128"),
        (np.zeros((3, 3), bool), Q, "positions: found the dtype bool"),
        ([["a", "b", "c"]], Q, "positions: found the dtype <U1"),
        (np.full((3, 3), None), Q, "positions: found the dtype object"),
        (np.array(["2026-01-01"], "M8[D]"), Q, "positions: found the dtype datetime64"),
        (None, Q, "positions: found the dtype object"),
        (np.where(P == 0.0, np.nan, P), Q, "positions, row 0: found NaN, expected a finite number"),
        (np.where(P == 0.0, np.inf, P), Q, "positions, row 0: found inf, expected a finite number"),
        (P, Q[:2], "quaternions: found 2 rows, expected 3, one for each of positions"),
        (P, 2 * Q, "quaternions, row 0: length of the quaternion is 2"),
        (P, 0 * Q, "quaternions, row 0: length of the quaternion is 0"),
        (P, np.full_like(Q, 1e308), "quaternions, row 0: length of the quaternion is inf"),
    ],
)
def test_arrays_that_cannot_be_used(
    room: Environment, positions: Any, quaternions: Any, text: str
) -> None:
    calls: list[Callable[..., object]] = [room.distort, room.compensate, room.validity]
    for call in calls:
        with pytest.raises(TrackwrightError) as refused:
            call(positions, quaternions)
        assert text in str(refused.value)


def test_ragged_lists_are_refused(room: Environment) -> None:
    with pytest.raises(ValueError, match="inhomogeneous"):
        room.distort([[0.0, 0.0, 0.0], [0.0]], Q)


def test_every_layout_of_numbers_is_the_same(room: Environment) -> None:
    random = np.random.default_rng(1)
    positions = random.integers(-100, 100, (50, 3)).astype(float) - [0, 0, 200]
    quaternions = np.tile([0.5, 0.5, -0.5, 0.5], (50, 1))
    expected = room.distort(positions, quaternions).positions
    wide = np.zeros((100, 6))
    wide[::2, ::2] = positions
    layouts: list[Any] = [
        np.asfortranarray(positions),
        wide[::2, ::2],
        positions[::-1][::-1],
        positions.astype(np.int64),
        positions.astype(np.float32),
        positions.astype(">f8"),
        positions.tolist(),
        np.ma.masked_array(positions),
    ]
    for layout in layouts:
        assert np.array_equal(room.distort(layout, quaternions).positions, expected)
    frozen = positions.copy()
    frozen.flags.writeable = False
    assert np.array_equal(room.distort(frozen, quaternions).positions, expected)
    assert np.array_equal(positions[0], frozen[0])


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda c: {}, "found no column ideal_x, ideal_y"),
        (lambda c: {**c, "ideal_x": c["ideal_x"][:5]}, "rows, expected"),
        (lambda c: {**c, "ideal_x": c["ideal_x"].reshape(1, -1)}, "expected one dimension"),
        (lambda c: {**c, "ideal_x": ["a"] * len(c["ideal_x"])}, "expected real numbers"),
        (lambda c: {**c, "ideal_x": np.nan * c["ideal_x"]}, "row 0: found NaN"),
        (lambda c: {**c, "ideal_qw": 3 + c["ideal_qw"]}, "length of the quaternion"),
        (lambda c: {k: v for k, v in c.items() if k != "measured_qz"}, "no column measured_qz"),
        (lambda c: {k: v[:0] for k, v in c.items()}, "found no rows"),
        (lambda c: {**c, "ideal_x": np.ma.masked_less(c["ideal_x"], 0)}, "found masked cells"),
        (lambda c: 17, "found int, expected a file"),
        (lambda c: np.zeros((3, 3)), "without names of columns"),
        (lambda c: None, "found NoneType"),
    ],
)
def test_tables_that_cannot_be_used(fit_table: Path, change: Any, text: str) -> None:
    with pytest.raises(TrackwrightError) as refused:
        Environment.fit(change(columns_of(fit_table)), order=3, directions=14)
    assert text in str(refused.value)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"order": -1}, "order: found -1"),
        ({"order": 2.5}, "order: found 2.5"),
        ({"order": "two"}, "order: found two"),
        ({"order": 10**30}, "order: found"),
        ({"directions": 7}, "directions"),
        ({"ridge": -1.0}, "ridge: found -1, expected zero or more"),
        ({"ridge": np.nan}, "ridge: found NaN, expected zero or more"),
        ({"method": "best"}, "method: found \"best\", expected one of per-direction, joint"),
        ({"model": "harmonic"}, "found no generator"),
        ({"model": "kriging", "order": 2}, "order does not go with"),
        ({"degree": 3}, "found no generator"),
        ({"model": "kriging", "degree": 3}, "degree belong to"),
        ({"jitter_position_mm": 0.1}, "found one, expected both"),
        ({"volume": "room"}, "volume: found \"room\""),
        ({"holdout": "none.csv"}, "none.csv"),
        ({"as_is": "yes"}, "as_is: found yes"),
    ],
)
def test_options_that_cannot_be(fit_table: Path, options: Any, text: str) -> None:
    with pytest.raises((TrackwrightError, FileNotFoundError)) as refused:
        Environment.fit(fit_table, **options)
    assert text in str(refused.value)


def test_poses_that_determine_nothing() -> None:
    with pytest.raises(TrackwrightError, match="poses: found no rows"):
        trackwright.pivot(np.zeros((0, 7)))
    with pytest.raises(TrackwrightError, match="no tip: too few poses: 2"):
        trackwright.pivot([[0, 0, 0, 1, 0, 0, 0]] * 2)
    with pytest.raises(TrackwrightError, match="found the shape"):
        trackwright.pivot(np.zeros((9, 3)))
    with pytest.raises(TrackwrightError, match="3 source points but 4 target points"):
        trackwright.register(np.eye(3), np.eye(4)[:, :3])
    with pytest.raises(TrackwrightError, match="fle_mm: found NaN"):
        trackwright.register(np.eye(3), np.eye(3), fle_mm=float("nan"))
    with pytest.raises(TrackwrightError, match="too few poses"):
        trackwright.hand_eye(np.tile([0, 0, 0, 1, 0, 0, 0], (3, 1)), [[0, 0, 0, 1, 0, 0, 0]] * 3)


def test_modes_and_poses_go_together() -> None:
    design = trackwright.Design.builtin("pointer-on-head")
    poses = {"tool_x": [0.0]}
    for call, text in (
        (lambda: trackwright.simulate(design, "motions"), "mode: found \"motions\""),  # type: ignore[arg-type]
        (lambda: trackwright.simulate(design, "input"), "mode \"input\" needs poses"),
        (lambda: trackwright.simulate(design, "single", poses=poses), "expected \"input\""),
        (lambda: trackwright.simulate(design, "input", poses=poses), "found no column tool_y"),
        (lambda: trackwright.simulate(design.with_motion(None), "motion"), "no range of motion"),
        (lambda: trackwright.compare(design, baseline=1), "baseline: found 1"),
        (lambda: trackwright.optimize(design, moves=["none"]), "found no sensor \"none\""),
        (lambda: trackwright.optimize(design, metric="none"), "metric: found \"none\""),
        (lambda: trackwright.optimize(design, sensors=(4, 2)), "sensors: found (4, 2)"),
        (lambda: trackwright.optimize(design, kinds=[(7, 1.0)]), "kinds: found [7.0, 1.0]"),
    ):
        with pytest.raises(TrackwrightError) as refused:
            call()
        assert text in str(refused.value)
