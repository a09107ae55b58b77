"""Figures and trials are those that the program computes, to the bit."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import DATA, REPOSITORY, Program, columns_of, same

import trackwright

POINTER = REPOSITORY / "designs" / "pointer-on-head.design.ron"
FEW_POSES = {"x": (-40.0, 40.0, 40.0), "rz": (-30.0, 30.0, 30.0)}


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A built-in design with a small range of motion, as files."""
    file = tmp_path_factory.mktemp("saved") / "pointer.design.ron"
    trackwright.Design.builtin("pointer-on-head").with_motion(FEW_POSES).save(file)
    return file


@pytest.mark.parametrize("mode", ["single", "motion"])
def test_figures_are_those_of_the_program(program: Program, saved: Path, mode: str) -> None:
    found = trackwright.simulate(trackwright.Design.load(saved), mode)  # type: ignore[arg-type]
    rms = found.figures["figures"]["position_mm"]["rms"]
    assert rms["low"] < rms["value"] < rms["high"]
    assert found.figures == program.json("simulate", saved, "--mode", mode)
    assert len(found.trials) == found.figures["trials"]


@pytest.mark.parametrize(
    "name", ["endoscope", "operating-theatre", "pointer-on-head", "shaver-on-head"]
)
def test_built_in_designs_have_one_figure(program: Program, name: str) -> None:
    file = REPOSITORY / "designs" / f"{name}.design.ron"
    found = trackwright.simulate(trackwright.Design.load(file), "motion").figures
    assert found == program.json("simulate", file, "--mode", "motion")


def test_outside_its_room_a_design_meets_nothing(
    program: Program, saved: Path, tmp_path: Path
) -> None:
    file = tmp_path / "far.design.ron"
    far = trackwright.Design.load(saved).with_tool_pose([0.0, 5000.0, 30.0, 1.0, 0.0, 0.0, 0.0])
    far.save(file)
    found = trackwright.simulate(trackwright.Design.load(file), "motion").figures
    assert found["basis"] == "outside"
    assert found["requirement"]["verdict"] == "cannot_tell"
    assert found == program.json("simulate", file, "--mode", "motion")


def test_trials_are_those_of_the_log(program: Program, saved: Path, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    program.json("simulate", saved, "--mode", "motion", "--log", log)
    trials = trackwright.simulate(trackwright.Design.load(saved), "motion", expected=False).trials
    written = columns_of(log)
    assert trials.dtype.names == tuple(written)
    for name, column in written.items():
        assert same(trials[name], column), name


def test_the_crf_is_studied_alone(program: Program, saved: Path) -> None:
    design = trackwright.Design.load(saved)
    found = [each.figures for each in trackwright.simulate_crf(design)]
    printed = program.json("simulate", saved, "--mode", "single", "--body", "crf")
    assert found == printed["targets"]


@pytest.mark.parametrize("name", ["pointer-on-head", "pointer-no-crf"])
def test_given_poses_are_read_from_anywhere(
    program: Program, room_file: Path, tmp_path: Path, name: str
) -> None:
    folder = tmp_path / name
    shutil.copytree(DATA / "golden" / name, folder)
    shutil.copy(room_file, folder / "room.env.ron")
    file, poses = folder / f"{name}.design.ron", folder / "input.csv"
    design = trackwright.Design.load(file)
    printed = program.json("simulate", file, "--input", poses)
    assert trackwright.simulate(design, "input", poses=poses).figures == printed
    columns = columns_of(poses)
    assert trackwright.simulate(design, "input", poses=columns).figures == printed
    records = np.rec.fromarrays(list(columns.values()), names=list(columns))
    assert trackwright.simulate(design, "input", poses=records).figures == printed


def test_a_room_in_memory_takes_the_designs_place(few_rows: Path) -> None:
    design = trackwright.Design.builtin("pointer-on-head").with_motion(FEW_POSES)
    other = trackwright.Environment.fit(few_rows, order=1, directions=6)
    own = trackwright.simulate(design, "motion", expected=False).figures
    there = trackwright.simulate(design, "motion", environment=other, expected=False).figures
    assert own["room_field"]["position_mm"] != there["room_field"]["position_mm"]
    same_room = trackwright.simulate(
        design, "motion", environment=design.environment, expected=False
    )
    assert same_room.figures == own


def test_left_out_figures_change_no_other(saved: Path) -> None:
    design = trackwright.Design.load(saved)
    whole = trackwright.simulate(design, "motion").figures
    short = trackwright.simulate(design, "motion", expected=False).figures
    assert not {"figures", "basis", "requirement"} & short.keys()
    assert short == {key: whole[key] for key in short}


def test_outside_policies_are_those_of_the_program(saved: Path, room_file: Path) -> None:
    far = trackwright.Design.load(saved).with_tool_pose([0.0, 260.0, 30.0, 1.0, 0.0, 0.0, 0.0])
    # Polynomials: beyond its box a computed model has the field of the nearest point.
    room = trackwright.Environment.load(room_file)
    found = {
        policy: trackwright.simulate(
            far, "motion", environment=room, outside=policy, expected=False
        ).figures
        for policy in ("clamp", "extrapolate")
    }
    assert found["clamp"]["outside"] > 0
    own = {policy: figures["room_field"]["position_mm"] for policy, figures in found.items()}
    assert own["clamp"] != own["extrapolate"]


JITTER = {"jitter_position_mm": 0.1, "jitter_angle_deg": 0.2}
JITTER_OPTIONS = ["--jitter-position-mm", 0.1, "--jitter-angle-deg", 0.2]


@pytest.mark.parametrize(
    ("mode", "methods", "sampling"),
    [
        ("single", ["first-order", "monte-carlo"], {"samples": 2000, "seed": 3}),
        ("motion", ["first-order"], {}),
    ],
)
def test_scatter_is_that_of_the_program(
    program: Program, saved: Path, mode: Any, methods: Any, sampling: dict[str, int]
) -> None:
    design = trackwright.Design.load(saved)
    found = trackwright.simulate(
        design, mode, uncertainty=methods, expected=False, **sampling, **JITTER
    ).figures["uncertainty"]
    options = [part for name, value in sampling.items() for part in (f"--{name}", value)]
    printed = program.json(
        "simulate", saved, "--mode", mode, "--uncertainty", ",".join(methods),
        *options, *JITTER_OPTIONS,
    )["uncertainty"]  # fmt: skip
    assert (found["jitter"].pop("source"), printed["jitter"].pop("source")) == (
        "keywords",
        "command line",
    )
    assert found == printed and "first_order" in found


def test_scatter_needs_what_the_program_needs(saved: Path) -> None:
    design = trackwright.Design.load(saved)
    for mode, options, text in (
        ("single", {"uncertainty": "monte"}, "expected one of first-order, monte-carlo"),
        ("motion", {"uncertainty": "monte-carlo", **JITTER}, 'needs the mode "single"'),
        ("single", {"uncertainty": "first-order", "seed": 1}, "samples and seed need"),
        ("single", JITTER, "jitter_position_mm needs uncertainty"),
        ("single", {"uncertainty": "monte-carlo", "samples": 1, **JITTER}, "samples"),
    ):
        with pytest.raises(trackwright.TrackwrightError, match=text):
            trackwright.simulate(design, mode, **options)  # type: ignore[arg-type]


def test_support_is_that_of_the_program(program: Program, room_file: Path, tmp_path: Path) -> None:
    folder = tmp_path / "pointer-on-head"
    shutil.copytree(DATA / "golden" / "pointer-on-head", folder)
    shutil.copy(room_file, folder / "room.env.ron")
    file = folder / "pointer-on-head.design.ron"
    found = trackwright.simulate(
        trackwright.Design.load(file), "motion", expected=False, support=True
    )
    printed = program.json("simulate", file, "--mode", "motion", "--support")
    assert found.figures["support"] == printed["support"]
