"""Recordings for the rerun viewer."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mot_sim.report import Film, Layers
from mot_sim.report.rerun_file import require_rerun, write_rerun
from tests.mot_sim.report.small import drive, exact_tracks
from tracker.errors import BadConfig, BadOutput, OutputExists


def test_without_the_extra_the_error_says_what_to_install(tmp_path, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(BadConfig, match=r"pip install 'mot-sim\[view\]'"):
        require_rerun(tmp_path / "film.rrd")


def test_the_target_is_checked_before_any_work(tmp_path) -> None:
    (tmp_path / "old.rrd").write_bytes(b"")
    with pytest.raises(BadConfig, match=r"ends in \.rrd"):
        require_rerun(tmp_path / "film.mp4")
    with pytest.raises(OutputExists, match="--overwrite"):
        require_rerun(tmp_path / "old.rrd")
    with pytest.raises(BadOutput, match="no folder that can be written to"):
        require_rerun(tmp_path / "old.rrd" / "film.rrd")


class Stream:
    """Keeps what is logged, as (frame, place, what)."""

    def __init__(self, *_: object, **__: object) -> None:
        self.logged: list[tuple[int | None, str, SimpleNamespace]] = []
        self.frame: int | None = None

    def save(self, path: str) -> None:
        Path(path).write_bytes(b"RRF2")

    def set_time(self, timeline: str, *, sequence: int = -1, duration: float = -1.0) -> None:
        if timeline == "frame":
            self.frame = sequence

    def log(self, place: str, what: object, static: bool = False) -> None:
        self.logged.append((None if static else self.frame, place, what))

    def disconnect(self) -> None:
        """Nothing is open."""


@pytest.fixture
def stream(monkeypatch: pytest.MonkeyPatch) -> Stream:
    """What stands in for rerun-sdk: whatever is made of its classes keeps its arguments."""
    one = Stream()

    def kept(name: str) -> object:
        return lambda **given: SimpleNamespace(kind=name, **given)

    names = ("Pinhole", "Transform3D", "EncodedImage", "Boxes2D", "Boxes3D")
    fake = SimpleNamespace(
        RecordingStream=lambda *_, **__: one,
        ViewCoordinates=SimpleNamespace(FRD="FRD", RDF="RDF"),
        Box2DFormat=SimpleNamespace(XYXY="XYXY"),
        LineStrips3D=lambda ways, **given: SimpleNamespace(kind="LineStrips3D", ways=ways, **given),
        **{name: kept(name) for name in names},
    )
    monkeypatch.setitem(sys.modules, "rerun", fake)
    return one


def film() -> Film:
    return Film(drive(), exact_tracks(), "exact", Layers(truth=True), drive().truth)


def test_everything_is_logged_at_its_frame_and_in_its_place(tmp_path, stream: Stream) -> None:
    write_rerun(tmp_path / "film.rrd", film(), 1, 5, lambda: None)
    assert [each.name for each in tmp_path.iterdir()] == ["film.rrd"]
    found = {(frame, place): what for frame, place, what in stream.logged}
    assert {frame for frame, _ in found} == {None, 1, 2, 3, 4}
    world = drive().traffic_states[4]
    truth = found[4, "map/truth"]
    np.testing.assert_allclose(truth.centers[:, :2], np.stack((world.x, world.y), axis=1))
    np.testing.assert_allclose(truth.centers[:, 2], -0.5 * world.size[:, 1])  # z is down
    np.testing.assert_allclose(truth.half_sizes, 0.5 * world.size[:, [0, 2, 1]])
    half_turns = 2.0 * np.arctan2(truth.quaternions[:, 2], truth.quaternions[:, 3])
    np.testing.assert_allclose(half_turns, world.heading, atol=1e-9)
    camera = found[4, "map/camera"]
    np.testing.assert_allclose(camera.translation, [*world.ego[:2], -1.65])
    np.testing.assert_allclose(camera.mat3x3[:, 2], [1.0, 0.0, 0.0], atol=1e-9)  # looks ahead
    near = found[4, "map/tracks"].centers[:, :2] - truth.centers[:, :2]
    assert np.hypot(*near.T).max() < 2.5
    assert [len(way) for way in found[4, "map/trails"].ways] == [4, 4]
    assert found[2, "map/camera/image/tracks"].labels == ["10", "11"]
    assert found[2, "map/camera/image"].contents[:2] == b"\xff\xd8"  # a JPEG


def test_the_real_package_writes_a_recording(tmp_path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk, the extra `view`, is not installed")
    seen: list[int] = []
    write_rerun(tmp_path / "film.rrd", film(), 1, 5, lambda: seen.append(1))
    assert len(seen) == 4
    content = (tmp_path / "film.rrd").read_bytes()
    assert len(content) > 10_000
    assert content.startswith(b"RRF")
    assert [each.name for each in tmp_path.iterdir()] == ["film.rrd"]


def test_an_interrupted_recording_leaves_nothing(tmp_path, stream: Stream) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_rerun(tmp_path / "film.rrd", film(), 0, 6, interrupted)
    assert list(tmp_path.iterdir()) == []
