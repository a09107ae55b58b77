"""Recordings, makers' definitions and OpenIGTLink messages go to bytes and come back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Program

import trackwright
from trackwright import IgtlDecoder, Recording, Tool, TrackwrightError, TrackwrightWarning

POSE = np.array([10.0, -20.0, -300.0, 0.5, 0.5, -0.5, 0.5])
FIELDS = ("x", "y", "z", "qw", "qx", "qy", "qz")


def table(count: int, shift_mm: float) -> dict[str, np.ndarray]:
    columns = {name: np.full(count, value) for name, value in zip(FIELDS, POSE)}
    columns["x"] = POSE[0] + shift_mm + np.arange(count)
    columns["time_s"] = 0.025 * np.arange(count)
    return columns


def test_recordings_come_back(tmp_path: Path) -> None:
    recorded = Recording.of_tools({"Pointer": table(5, 0.0), "Reference": table(5, 7.0)})
    file = tmp_path / "recording.csv"
    recorded.save(file)
    for again in (Recording.load(file), Recording.from_bytes(recorded.to_bytes())):
        assert again.tools == ["Pointer", "Reference"]
        track = again.track("Pointer")
        assert track.usable.all() and np.array_equal(track.x, POSE[0] + np.arange(5))
        assert np.allclose(track.time_s, 0.025 * np.arange(5), rtol=0.0, atol=1e-6)
        assert again.unusable("Pointer") == {}
    both = recorded.track("Pointer", relative_to="Reference")
    assert np.allclose([np.linalg.norm([row.x, row.y, row.z]) for row in both], 7.0)


def test_recordings_know_what_is_not_usable() -> None:
    text = (
        b"received_s,time_s,tool,state,x,y,z,qw,qx,qy,qz\n"
        b"1.0,1.0,Pointer,OK,1,2,3,1,0,0,0\n1.1,1.1,Pointer,missing,,,,,,,\n"
    )
    recording = Recording.from_bytes(text)
    track = recording.track()
    assert track.usable.tolist() == [True, False] and np.isnan(track.x[1])
    assert recording.unusable() == {"missing": 1}
    with pytest.raises(TrackwrightError, match="found no tool with \"Stylus\" in its name"):
        recording.track("Stylus")


def tool_file(tmp_path: Path) -> Path:
    file = tmp_path / "tool.body.ron"
    file.write_text(
        '(version: 1, name: "probe", tip: (0, 0, -35), sensors: ['
        '(name: "a", kind: FiveDof, position: (0, 0, 60), axis: (0, 0, 1)), '
        '(name: "b", kind: FiveDof, position: (8, 0, 95), axis: (0, -1, 0))])'
    )
    return file


def test_roms_come_back(program: Program, tmp_path: Path) -> None:
    tool = Tool.load(tool_file(tmp_path))
    assert tool.tip is not None and tool.tip.tolist() == [0.0, 0.0, -35.0]
    with pytest.warns(TrackwrightWarning) as caught:
        image = tool.to_bytes()
    assert "experimental" in str(caught[-1].message)
    done = program.run("convert", tmp_path / "tool.body.ron", tmp_path / "tool.rom")
    assert done.returncode == 0, done.stderr
    assert image == (tmp_path / "tool.rom").read_bytes()
    again = Tool.from_bytes(image)
    assert [sensor.name for sensor in again.sensors] == ["A", "B"] or len(again.sensors) == 2
    assert np.allclose(again.sensors[1].position, [8.0, 0.0, 95.0], atol=1e-5)
    printed = program.json("convert", tmp_path / "tool.rom", tmp_path / "back.body.ron")
    assert Tool.load(tmp_path / "tool.rom").figures == printed["read"]


def test_a_wrong_checksum_is_refused(tmp_path: Path) -> None:
    with pytest.warns(TrackwrightWarning):
        image = bytearray(Tool.load(tool_file(tmp_path)).to_bytes())
    image[100] ^= 1
    with pytest.raises(TrackwrightError, match="checksum"):
        Tool.from_bytes(bytes(image))
    assert len(Tool.from_bytes(bytes(image), accept_checksum=True).sensors) == 2


def test_messages_come_back_in_any_pieces() -> None:
    tools = np.array([POSE, POSE + [1.0, 0, 0, 0, 0, 0, 0]])
    stream = (
        trackwright.encode_transform("Pointer", POSE, timestamp_s=1.5)
        + trackwright.encode_tracking("Tracker", ["a", "b"], tools, timestamp_s=2.0)
        + trackwright.encode_status("Tracker", "ready")
    )
    decoder, found = IgtlDecoder(), []
    for start in range(0, len(stream), 11):
        found += decoder.feed(stream[start : start + 11])
    assert [message.kind for message in found] == ["TRANSFORM", "TDATA", "STATUS"]
    assert found[0].timestamp_s == 1.5 and found[0].problem is None
    assert np.allclose(found[0].poses["Pointer"], POSE, atol=1e-5)
    assert list(found[1].poses) == ["a", "b"]
    assert np.allclose(found[1].poses["b"], tools[1], atol=1e-5)
    assert (found[2].code, found[2].text) == (1, "ready")


def test_messages_that_are_damaged_have_a_problem() -> None:
    message = bytearray(trackwright.encode_transform("Pointer", POSE))
    message[-1] ^= 1
    (found,) = IgtlDecoder().feed(bytes(message))
    assert found.problem is not None and "checksum" in found.problem
    with pytest.raises(TrackwrightError, match="not OpenIGTLink"):
        IgtlDecoder().feed(b"x" * 58)
    with pytest.raises(TrackwrightError):
        trackwright.encode_transform("a name that is longer than twenty bytes", POSE)
