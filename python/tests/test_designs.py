"""Designs are edited as in the editor: each edit gives another one, or the editor's error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import trackwright
from trackwright import Design, TrackwrightError


@pytest.fixture(scope="module")
def pointer() -> Design:
    return Design.builtin("pointer-on-head")


def test_an_edit_leaves_the_design_before_as_it_is(pointer: Design) -> None:
    before = pointer.to_ron(), pointer.sensors()
    sensor = pointer.sensors()[0]
    moved = pointer.with_sensor(sensor.name, sensor.position + [0.0, 0.0, 5.0])
    assert (pointer.to_ron(), pointer.sensors()) == before
    assert np.array_equal(moved.sensors()[0].position, sensor.position + [0.0, 0.0, 5.0])
    assert moved.sensors()[1:] == pointer.sensors()[1:]
    assert np.array_equal(moved.sensors()[0].axis, sensor.axis)


def test_sensors_are_added_and_removed(pointer: Design) -> None:
    more = pointer.with_sensor("new", [1.0, 2.0, 3.0], axis=[0.0, 3.0, 4.0], coil=(0.8, 9.0))
    added = more.sensors()[-1]
    assert (added.name, added.degrees_of_freedom, added.coil) == ("new", 5, (0.8, 9.0))
    assert added.axis is not None and np.allclose(added.axis, [0.0, 0.6, 0.8], atol=1e-15)
    full = more.with_sensor("new", rotation=[0.5, 0.5, 0.5, 0.5])
    assert full.sensors()[-1].degrees_of_freedom == 6
    assert full.without_sensor("new").sensors() == pointer.sensors()
    assert more.with_sensor("new", new_name="tip").sensors()[-1].name == "tip"


def test_poses_tips_and_targets_are_set(pointer: Design) -> None:
    pose = [1.0, 2.0, 3.0, 0.5, -0.5, 0.5, -0.5]
    assert np.array_equal(pointer.with_tool_pose(pose).crf_from_tool, pose)
    assert np.array_equal(pointer.with_crf_pose(pose).tracker_from_crf, pose)
    assert np.array_equal(pointer.with_tip([0.0, 0.0, -40.0]).tip(), [0.0, 0.0, -40.0])
    assert pointer.with_tip(None).tip() is None
    there = pointer.with_target("here", [1.0, 2.0, 3.0])
    assert len(trackwright.simulate_crf(there)) > len(trackwright.simulate_crf(pointer)) - 1
    assert there.without_target("here").to_ron() == pointer.to_ron()


def test_requirements_and_motions_come_back(pointer: Design) -> None:
    required = {"position_rms": 1.5, "angle_max": 2.0}
    assert pointer.with_requirement(required).requirement == required
    assert pointer.with_requirement(None).requirement is None
    motion = {"x": (-10.0, 10.0, 5.0), "rz": (0.0, 90.0, 45.0)}
    assert pointer.with_motion(motion).motion == motion
    assert pointer.with_motion(None).motion is None
    for pivot in ("tip", {"body": (0.0, 1.0, 50.0)}, {"reference": (-3.0, 0.5, 0.0)}):
        about = {"pivot": pivot, **motion}
        assert pointer.with_motion(about).motion == about
    assert pointer.with_motion({"pivot": "origin", **motion}).motion == motion


def test_what_is_saved_is_loaded_again(pointer: Design, tmp_path: Path) -> None:
    sensor = pointer.sensors()[0]
    edited = pointer.with_name("mine").with_sensor(sensor.name, sensor.position + 1.0)
    written = edited.save(tmp_path / "mine.design.ron")
    assert len(written) == 6
    again = Design.load(tmp_path / "mine.design.ron")
    assert (again.name, again.sensors(), again.sensors("crf")) == (
        "mine",
        edited.sensors(),
        edited.sensors("crf"),
    )
    assert again.environment.name == edited.environment.name


def test_another_room_is_the_designs_own(pointer: Design, room_file: Path) -> None:
    there = pointer.with_environment(room_file)
    assert there.environment.name == "room"
    direct = trackwright.simulate(pointer, environment=there.environment, expected=False)
    assert trackwright.simulate(there, expected=False).figures == direct.figures


@pytest.mark.parametrize(
    ("edit", "text"),
    [
        (lambda d: d.with_name(" "), "the design's name is empty"),
        (lambda d: d.without_sensor("none"), "found no sensor \"none\", expected one of"),
        (lambda d: d.with_sensor("new", [0, 0, 0]), "expected position and one of axis"),
        (lambda d: d.with_sensor("new", [0, 0, np.nan], marker=True), "the sensor's position"),
        (lambda d: d.with_sensor("new", [0, 0, 0], axis=[0, 0, 0]), "axis: found the length 0"),
        (lambda d: d.with_sensor("new", [0, 0, 0], axis=[1, 0, 0], marker=True), "several of axis"),
        (lambda d: d.with_tool_pose([0] * 7), "length of the quaternion is 0"),
        (lambda d: d.with_tool_pose([0, 0, 1]), "found the shape (3,), expected (7,)"),
        (lambda d: d.with_motion({"x": (1.0, 0.0, 1.0)}), "motion.x: min is 1, max is 0"),
        (lambda d: d.with_motion({"w": (0.0, 1.0, 1.0)}), "found no axis \"w\", expected one of"),
        (lambda d: d.with_motion({"pivot": "hub"}), "motion, pivot: found 'hub', expected"),
        (lambda d: d.with_motion({"pivot": {"tool": (0, 0, 0)}}), "expected \"origin\", \"tip\""),
        (lambda d: d.with_motion({"pivot": {"body": (0, 0, 1e9)}}), "motion.pivot: the point is"),
        (lambda d: d.with_requirement({"tip": 1.0}), "requirement: found \"tip\", expected one of"),
        (lambda d: d.with_requirement({"position_rms": -1.0}), "position_rms"),
        (lambda d: d.sensors("head"), "body: found \"head\", expected one of tool, crf"),
    ],
)
def test_edits_that_cannot_be_are_refused(pointer: Design, edit: object, text: str) -> None:
    assert callable(edit)
    with pytest.raises(TrackwrightError) as refused:
        edit(pointer)
    assert text in str(refused.value)


def test_the_last_sensor_stays(pointer: Design) -> None:
    names = [sensor.name for sensor in pointer.sensors()]
    for name in names[1:]:
        pointer = pointer.without_sensor(name)
    with pytest.raises(TrackwrightError, match="a body needs at least one sensor"):
        pointer.without_sensor(names[0])
