"""Every worked case of an independent program about fields, through Python."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from conftest import DATA, columns_of, pose_parts

import trackwright
from trackwright import Environment, Generator, TrackwrightError

PHYSICS: dict[str, Any] = json.loads((DATA / "golden" / "physics.json").read_text())

# Of numbers that follow from a formula.
TOLERANCE = 1e-9
# Of poses that were found by steps, which end below this.
FOUND_MM, FOUND = 1e-6, 1e-8


def close(found: npt.ArrayLike, expected: npt.ArrayLike) -> bool:
    """Whether vectors differ by that part of their length."""
    found, expected = np.asarray(found), np.asarray(expected)
    error = np.linalg.norm(found - expected, axis=-1)
    return bool((error <= TOLERANCE * np.linalg.norm(expected, axis=-1)).all())


def test_fields_of_a_generator() -> None:
    generator = Generator.builtin("planar-nine")
    assert generator.coils == len(PHYSICS["generator"]["dipoles"])
    found = generator.field([case["at_mm"] for case in PHYSICS["field"]])
    assert close(found, [case["field"] for case in PHYSICS["field"]])
    with pytest.raises(TrackwrightError, match="expected one of planar-nine, anser"):
        Generator.builtin("none")  # type: ignore[arg-type]


def dipoles() -> str:
    """The generator's coils as its file has them."""
    each = [
        f"Dipole(position: {tuple(coil['at_mm'])}, moment: {tuple(coil['moment'])})"
        for coil in PHYSICS["generator"]["dipoles"]
    ]
    return f"[{', '.join(each)}]"


def test_a_generator_of_a_file(tmp_path: Path) -> None:
    file = tmp_path / "own.generator.ron"
    file.write_text(f'(version: 1, name: "own", coils: {dipoles()})')
    own, at = Generator.load(file), [[10.0, -20.0, -150.0]]
    assert own.name == "own"
    assert np.array_equal(own.field(at), Generator.builtin("planar-nine").field(at))


def test_gradients_of_solid_harmonics() -> None:
    cases = PHYSICS["solid_harmonic_gradients"]
    found = trackwright.solid_harmonic_gradients([case["at"] for case in cases], PHYSICS["degree"])
    expected = np.array([case["gradients"] for case in cases])
    assert found.shape == expected.shape
    assert np.abs(found - expected).max() <= TOLERANCE
    with pytest.raises(TrackwrightError, match="degree: found 11, expected 1 to 10"):
        trackwright.solid_harmonic_gradients([[0.0, 0.0, 0.0]], 11)


@pytest.fixture(scope="module")
def worked_room(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    """The room of the worked coefficients, as a file has it."""
    file = tmp_path_factory.mktemp("harmonic") / "worked.env.ron"
    file.write_text(f"""(
        version: 1,
        name: "worked",
        model: (
            order: 0,
            directions: 1,
            weighting: Area,
            map: Distortion,
            box: ((-300.0, -300.0, -600.0), (300.0, 300.0, -10.0)),
            coefficients: [],
        ),
        harmonic: (
            center_mm: {tuple(PHYSICS["centre_mm"])},
            scale_mm: {PHYSICS["scale_mm"]},
            degree: {PHYSICS["degree"]},
            generator: (name: "planar-nine", coils: {dipoles()}),
            coefficients: {np.reshape(PHYSICS["coefficients"], (9, -1)).tolist()},
        ),
    )""")
    return Environment.load(file)


def axes(quaternions: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """The local z of each rotation."""
    w, x, y, z = np.transpose(np.asarray(quaternions, float))
    return np.column_stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


def near(found: npt.ArrayLike, expected: npt.ArrayLike, tolerance: float) -> bool:
    return bool((np.linalg.norm(np.subtract(found, expected), axis=-1) < tolerance).all())


def test_readings_in_a_harmonic_room(worked_room: Environment) -> None:
    cases = PHYSICS["measured"]
    assert worked_room.model == "harmonic"
    poses = [case["position_mm"] for case in cases], [case["quaternion"] for case in cases]
    five = worked_room.distort(*poses)
    assert near(five.positions, [case["five_dof"]["position_mm"] for case in cases], FOUND_MM)
    assert near(axes(five.quaternions), [case["five_dof"]["axis"] for case in cases], FOUND)
    six = worked_room.distort_6dof(*poses)
    assert near(six.positions, [case["six_dof"]["position_mm"] for case in cases], FOUND_MM)
    expected = np.array([case["six_dof"]["quaternion"] for case in cases])
    signs = np.sign((six.quaternions * expected).sum(1, keepdims=True))
    assert near(six.quaternions * signs, expected, FOUND)
    assert not six.outside.any()


def test_other_rooms_have_no_6dof_readings(room_file: Path) -> None:
    with pytest.raises(TrackwrightError, match="found a bernstein model, expected a harmonic one"):
        Environment.load(room_file).distort_6dof([[0, 0, -200]], [[1, 0, 0, 0]])


def test_a_harmonic_fit(fit_table: Path, holdout_table: Path, tmp_path: Path) -> None:
    case = PHYSICS["fit"]
    room = Environment.fit(
        fit_table,
        model="harmonic",
        generator="planar-nine",
        degree=PHYSICS["degree"],
        loss="squares",
        holdout=holdout_table,
        support=False,
    )
    assert room.figures is not None
    raw_mm = room.figures["holdout"]["before"]["position_rms_mm"]
    assert abs(raw_mm / case["raw_rms_mm"] - 1) < TOLERANCE
    # Some rows are outside the box of the fit, where the worked case uses the harmonics as they are.
    file = tmp_path / "room.env.ron"
    room.save(file)
    text, boxes = re.subn(r"box: .*", "box: ((-500, -500, -900), (500, 500, -1)),", file.read_text())
    assert boxes == 1
    file.write_text(text)
    room = Environment.load(file)
    columns = columns_of(holdout_table)
    positions, quaternions = pose_parts(columns, "ideal_")
    found = room.distort(positions, quaternions)
    left = found.positions - pose_parts(columns, "measured_")[0]
    left_mm = np.sqrt((left**2).sum(1).mean())
    assert abs(left_mm / case["holdout_rms_mm"] - 1) < TOLERANCE
    rows = [row["row"] for row in case["predicted"]]
    expected = [row["position_mm"] for row in case["predicted"]]
    assert near(found.positions[rows], expected, FOUND_MM)
    assert near(axes(found.quaternions)[rows], [row["axis"] for row in case["predicted"]], FOUND)


# That of 60 digits: the worked one has lost six of them in a difference.
REAL_OF_1_MM = -6.6577103691467715e-12


@pytest.mark.parametrize("case", PHYSICS["sphere_factors"])
def test_factors_of_spheres(case: dict[str, Any]) -> None:
    material = case["conductivity_S_m"], case["relative_permeability"]
    found = trackwright.sphere_factor(case["radius_mm"], material, case["frequency_hz"])
    re = REAL_OF_1_MM if case["radius_mm"] == 1.0 else case["re"]
    assert abs(found.real - re) <= TOLERANCE * abs(re)
    assert abs(found.imag - case["im"]) <= TOLERANCE * abs(case["im"])


@pytest.mark.parametrize("case", PHYSICS["sphere_beside_a_dipole"])
def test_a_sphere_beside_a_dipole(case: dict[str, Any]) -> None:
    mu = case["relative_permeability"]
    found = trackwright.sphere_field(
        case["radius_mm"],
        case["dipole_at_mm"],
        case["dipole"],
        [case["at_mm"], case["at_mm"]],
        material=None if mu is None else (0.0, mu),
        frequency_hz=1e3,
    )
    assert close(found, [case["field"]] * 2)


def test_materials_are_known_by_name() -> None:
    named = trackwright.sphere_factor(20.0, "copper", 1e3)
    assert named == trackwright.sphere_factor(20.0, (5.8e7, 1.0), 1e3)
    with pytest.raises(TrackwrightError, match="material: found 'gold'|found \"gold\""):
        trackwright.sphere_factor(20.0, "gold", 1e3)
    with pytest.raises(TrackwrightError, match="radius is 0 mm, expected a length above zero"):
        trackwright.sphere_factor(0.0, "copper", 1e3)
