"""What every framework of the register promises, online, in a window or over the whole drive."""

import pickle
from dataclasses import fields, is_dataclass, replace
from functools import cache

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, Car, Drive, drive, locked
from tracker import FRAMEWORKS, TRACKERS, Delayed, Detections, Frame, Tracker, Tracks
from tracker.association import ASSOCIATIONS
from tracker.costs import COSTS, ImageOverlap
from tracker.ego_motion import NO_MOTION, CameraMotion
from tracker.errors import BadConfig
from tracker.geometry import box_iou

every_framework = pytest.mark.parametrize("name", list(FRAMEWORKS))
every_tracker = pytest.mark.parametrize("preset", list(TRACKERS))
delayed = pytest.mark.parametrize("name", ["network_flow", "window"])
GEOMETRY = [name for name in COSTS if name in ("image_overlap", "reprojection", "volume")]


@cache
def town() -> Drive:
    """Thirty frames: parked, oncoming and crossing cars, misses, and four empty frames."""
    cars = [
        Car(-4.0, 40.0),
        Car(4.0, 50.0),
        Car(-1.5, 70.0, yaw=np.pi / 2, velocity=(0.0, -6.0)),
        Car(-15.0, 45.0, yaw=0.0, velocity=(5.0, 0.0)),
    ]
    return drive(
        cars,
        lambda t: (0.2 * t, 6.0 * t, 0.05 * np.sin(t)),
        count=30,
        hidden=lambda frame, car: 18 <= frame < 22 or (frame * 7 + car * 3) % 11 == 0,
        score=lambda frame, car: 0.85 + 0.14 * ((frame * 5 + car) % 7) / 6,
    )


def built(name: str, preset: str = "default") -> Tracker | Delayed:
    return FRAMEWORKS[name](TRACKERS[preset](LEVEL))


def run(framework: Tracker | Delayed, frames: list[Frame]) -> Tracks:
    parts = [framework.step(frame) for frame in frames]
    if isinstance(framework, Delayed):
        parts.append(framework.finish())
    return Tracks.concatenate(parts)


def assert_same(one: Tracks, other: Tracks) -> None:
    for column in ("frames", "ids", "boxes", "scores"):
        np.testing.assert_array_equal(getattr(one, column), getattr(other, column))
    np.testing.assert_array_equal(one.cuboids.base, other.cuboids.base)


def test_every_two_frame_association_is_a_framework() -> None:
    assert set(ASSOCIATIONS) | {"network_flow", "window"} == set(FRAMEWORKS)
    assert all((FRAMEWORKS[name].__doc__ or "").strip() for name in FRAMEWORKS)


@every_framework
@every_tracker
def test_rows_are_in_the_order_of_frames_and_name_each_car_once(name: str, preset: str) -> None:
    rows = run(built(name, preset), town().frames)
    assert len(rows) > 40
    assert (np.diff(rows.frames) >= 0).all()
    rows.require_unique_ids()
    assert len(rows.cuboids) == len(rows)
    assert np.isfinite(rows.boxes).all()
    assert np.isfinite(rows.cuboids.base).all()


@every_framework
@pytest.mark.parametrize("cost", GEOMETRY)
def test_every_cost_keeps_a_standing_cars_identity(name: str, cost: str) -> None:
    tracker = replace(TRACKERS["default"](LEVEL), costs=((1.0, COSTS[cost]()),))
    rows = run(FRAMEWORKS[name](tracker), drive([Car(0.0, 25.0)], count=12).frames)
    assert rows.ids.tolist() == [0] * 12
    assert rows.frames.tolist() == list(range(12))


@every_framework
def test_two_runs_say_the_same_and_leave_the_frames_as_they_were(name: str) -> None:
    assert_same(run(built(name), locked(town().frames)), run(built(name), town().frames))


@every_framework
def test_after_a_reset_it_is_as_new(name: str) -> None:
    framework = built(name)
    first = run(framework, town().frames)
    framework.reset()
    assert_same(run(framework, town().frames), first)


@every_framework
@pytest.mark.parametrize("keep", [lambda state: state, pickle.dumps])
def test_its_state_can_be_kept_and_given_back(name: str, keep) -> None:
    frames, framework = town().frames, built(name)
    for frame in frames[:25]:
        framework.step(frame)
    kept = keep(framework.state)
    rest = run(framework, frames[25:])
    other = built(name)
    other.state = pickle.loads(kept) if isinstance(kept, bytes) else kept
    assert_same(run(other, frames[25:]), rest)


@pytest.mark.parametrize("name", [*ASSOCIATIONS, "window"])
@pytest.mark.parametrize("cut", [1, 27])
def test_what_comes_after_the_lag_changes_nothing(name: str, cut: int) -> None:
    """Online: nothing that comes later; a window: nothing after the frames it has looked at."""
    whole, first = built(name), built(name)
    decided = [whole.step(frame) for frame in town().frames][:cut]
    again = [first.step(frame) for frame in town().frames[:cut]]
    for one, other in zip(again, decided, strict=True):
        assert_same(one, other)
    if name == "window":
        shown = Tracks.concatenate(again).frames
        assert shown.max(initial=-1) == max(cut - 1 - first.lag, -1)


def test_the_whole_drive_is_told_at_its_end() -> None:
    framework = built("network_flow")
    assert sum(len(framework.step(frame)) for frame in town().frames) == 0
    assert len(framework.finish()) > 40


@every_framework
def test_a_drive_without_frames_has_no_rows(name: str) -> None:
    framework = built(name)
    assert not isinstance(framework, Delayed) or len(framework.finish()) == 0


@pytest.mark.unchecked  # many frames of one shape
@delayed
def test_many_empty_frames_have_no_rows(name: str) -> None:
    frames = [Frame(i, i / 10, Detections.empty(), np.eye(4)) for i in range(200)]
    assert len(run(built(name), frames)) == 0


@every_framework
def test_one_frame_and_unknown_motion_are_no_error(name: str) -> None:
    seen = drive([Car(0.0, 25.0), Car(4.0, 30.0)], count=15, know_motion=False).frames
    assert len(run(built(name), seen[:1])) in (0, 2)  # one detection may be too little for a birth
    rows = run(built(name), seen)
    assert sorted(set(rows.ids.tolist())) == [0, 1]


@delayed
def test_a_cost_that_is_no_number_is_named(name: str) -> None:
    class Broken(ImageOverlap):
        """Infinitely cheap."""

        def __call__(self, pairing):
            return super().__call__(pairing) - np.inf

    tracker = replace(TRACKERS["default"](LEVEL), costs=((1.0, Broken()),))
    with pytest.raises(BadConfig, match=r"costs -?(inf|nan)"):
        run(FRAMEWORKS[name](tracker), town().frames)


def scribbled_over(rows: Tracks) -> None:
    """Every array of the rows, made useless."""
    cuboids = rows.cuboids.base, rows.cuboids.yaw, rows.cuboids.size
    for array in (rows.frames, rows.ids, rows.boxes, rows.scores, *cuboids):
        array[:] += 1000


@every_framework
@every_tracker
def test_what_the_caller_does_to_rows_and_frames_changes_nothing_later(
    name: str, preset: str
) -> None:
    """Rows are the caller's own; a detector may write its next boxes over the last ones."""
    expected = run(built(name, preset), town().frames)
    framework, parts = built(name, preset), []
    for frame in pickle.loads(pickle.dumps(town().frames)):
        rows = framework.step(frame)
        parts.append(rows.copied())
        scribbled_over(rows)
        frame.detections.boxes[:] = 7.0
        frame.detections.scores[:] = 0.0
        if frame.T_now_before is not None:
            frame.T_now_before[:] = np.nan
    if isinstance(framework, Delayed):
        parts.append(framework.finish())
    assert_same(Tracks.concatenate(parts), expected)


def arrays_in(thing: object) -> list[np.ndarray]:
    """Every array of a nested state."""
    if isinstance(thing, np.ndarray):
        return [thing]
    if isinstance(thing, tuple):
        return [array for part in thing for array in arrays_in(part)]
    if is_dataclass(thing):
        return [array for field in fields(thing) for array in arrays_in(getattr(thing, field.name))]
    return []


@every_framework
def test_what_is_remembered_of_tracks_cannot_be_written_to(name: str) -> None:
    framework = built(name)
    for frame in town().frames[:5]:
        framework.step(frame)
    tracks = framework.state.tracks if name in ASSOCIATIONS else framework.state.linker.recent
    remembered = arrays_in(tracks)
    assert len(remembered) > 10
    for array in remembered:
        assert not array.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        tracks.ids[:] += 1


def with_looks_at_every(frames: list[Frame], every: int) -> list[Frame]:
    """The same frames; nothing looked at those in between."""
    return [f if f.index % every == 0 else replace(f, detections=None) for f in frames]


def given_every(frames: list[Frame], every: int) -> list[Frame]:
    """Only every so many-th frame; the motion goes over those in between."""
    given, motion = [], NO_MOTION
    for frame in frames:
        motion = CameraMotion.of(frame, 0.1).after(motion)
        if frame.index % every == 0:
            known = (motion.T_now_before, motion.known_cov) if given else (None, None)
            given.append(replace(frame, T_now_before=known[0], motion_cov=known[1]))
            motion = NO_MOTION
    return given


@every_framework
@every_tracker
@pytest.mark.parametrize("every", [2, 4])
def test_frames_that_nothing_looked_at_get_rows_and_change_no_other_row(
    name: str, preset: str, every: int
) -> None:
    rows = run(built(name, preset), with_looks_at_every(town().frames, every))
    looked_at = rows.select(rows.frames % every == 0)
    expected = run(built(name, preset), given_every(town().frames, every))
    np.testing.assert_array_equal(looked_at.frames, expected.frames)
    np.testing.assert_array_equal(looked_at.ids, expected.ids)
    atol = 1e-6 if name in ASSOCIATIONS else 0.3  # a path is smoothed in smaller steps
    np.testing.assert_allclose(looked_at.boxes, expected.boxes, rtol=0, atol=atol)
    rows.require_unique_ids()
    assert (np.diff(rows.frames) >= 0).all()
    between = np.flatnonzero(np.arange(30) % every)
    assert np.isin(between[between < 14], rows.frames).all()


@every_framework
def test_where_nothing_looks_boxes_follow_the_cars_and_the_camera(name: str) -> None:
    """Looks stop for half a second: the boxes that come are where the cars are."""
    moving = [Car(-3.0, 30.0), Car(3.0, 25.0, velocity=(0.0, 4.0))]
    seen = drive(moving, lambda t: (0.0, 5 * t, 0.0))
    frames = [f if f.index < 14 else replace(f, detections=None) for f in seen.frames]
    rows = run(built(name), frames)
    for frame in seen.frames[14:19]:
        here = rows.boxes[rows.frames == frame.index]
        assert len(here) == 2
        assert box_iou(frame.detections.boxes[:, None], here[None]).max(axis=1).min() > 0.75


@every_framework
def test_a_drive_that_nothing_looks_at_has_no_rows(name: str) -> None:
    frames = [replace(frame, detections=None) for frame in town().frames[:5]]
    assert len(run(built(name), frames)) == 0
    assert len(run(built(name), frames + town().frames[5:])) > 30
