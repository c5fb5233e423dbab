"""Which noise source causes each switch: the drive is tracked again with one source off.

A source is off from WINDOW_SECONDS before the car's last frame under the old track id to
WINDOW_SECONDS after its first frame under the new one. Outside that window, and in all other
random draws, nothing changes. The switch is gone when the true car is matched on both sides of
it under one track id, and keeps that id for another WINDOW_SECONDS: a switch that only comes a
little earlier or later is not gone.
"""

from collections.abc import Iterable, Iterator
from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from mot_sim.diagnosis.context_events import by_id
from mot_sim.diagnosis.sources import DetectionStream, SourceAblation
from mot_sim.experiments.sweep.following import TrackerFailed
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec, tracker_specs_of
from mot_sim.experiments.sweep.trial import require_rows, wrong_motion_allowed
from mot_sim.foreign.answers import BadRows
from mot_sim.foreign.isolation import (
    DEFAULT_ISOLATION,
    Isolation,
    TrackerStopped,
    close_tracker,
    steps_of,
)
from mot_sim.foreign.protocol import Steps
from mot_sim.metrics.breaks import Breaks, Matches
from tracker.errors import BadConfig
from tracker.types import Frame, Tracks

BEFORE_FIRST_FRAME = -1
WINDOW_SECONDS = 1.0
# The verdicts. The first two name sources; the others say that no single source explains it.
ONE_SOURCE = "one source"
EITHER_SOURCE = "either of several"
SEVERAL_TOGETHER = "several together"
EARLIER_NOISE = "noise long before"
NO_NOISE = "scene or tracker"
VERDICTS = (ONE_SOURCE, EITHER_SOURCE, SEVERAL_TOGETHER, EARLIER_NOISE, NO_NOISE)


@dataclass(frozen=True, eq=False)
class TrackerSnapshot:
    """A tracker after some frames, and the rows that it has returned so far."""

    tracker: Steps
    """The tracker in its state after those frames."""
    frames: tuple[int, ...] = ()
    """Indices of the frames that it was given, increasing."""
    rows: tuple[Tracks, ...] = ()
    """What it returned for each of those frames."""


@dataclass(eq=False)
class Replays:
    """Runs of one tracker. Our own trackers continue from copies; others start anew each time."""

    tracker_spec: TrackerSpec
    """How the tracker is built."""
    kept: dict[int, TrackerSnapshot] = field(default_factory=dict)
    """Snapshots by the frame after which they were taken; our own trackers only."""
    is_late: bool = False
    """Whether the tracker has a `finish`, and so must see a drive to its end; known after the first
    run."""

    def run(self, stream: DetectionStream, last: int, keep: Iterable[int] = ()) -> Tracks:
        """All rows up to the frame `last`. keep: frames after which a snapshot is kept.

        Raises TrackerFailed when the tracker raises or returns rows that cannot be scored, and
        BadConfig when it cannot be built.
        """
        spec = self.tracker_spec
        can_copy = spec.is_ours and not spec.isolation.covers(is_ours=True)
        wanted = set(keep) if can_copy else set()
        tracker = self._start(stream)
        try:
            start = TrackerSnapshot(tracker)
            return self._continue(start, BEFORE_FIRST_FRAME, stream, last, wanted)
        finally:
            close_tracker(tracker)

    def _start(self, stream: DetectionStream) -> Steps:
        """A fresh tracker. Raises TrackerFailed where its process does not start it."""
        try:
            return self.tracker_spec.start(stream.camera, stream.frame_rate)
        except TrackerStopped as stopped:
            where = f"before the first frame of {stream.recorded.name}"
            raise TrackerFailed(self.tracker_spec.name, where, str(stopped), None) from stopped

    def run_from(self, before: int, stream: DetectionStream, last: int) -> Tracks:
        """The same, from the snapshot after the frame `before` if there is one.

        Up to that frame the stream must equal the one that the snapshot was taken from.
        """
        if before not in self.kept:
            return self.run(stream, last)
        kept = self.kept[before]
        start = TrackerSnapshot(deepcopy(kept.tracker), kept.frames, kept.rows)
        return self._continue(start, before, stream, last, set())

    def _continue(
        self,
        start: TrackerSnapshot,
        before: int,
        stream: DetectionStream,
        last: int,
        wanted: set[int],
    ) -> Tracks:
        """The frames after `before`, up to `last`."""
        tracker, frames, rows = start.tracker, list(start.frames), list(start.rows)
        is_late = self.is_late = callable(getattr(tracker, "finish", None))
        now: int | None = None

        def asked(frame: Frame) -> None:
            nonlocal now
            now = frame.index
            for earlier in sorted(each for each in wanted if each < now):
                snapshot = TrackerSnapshot(deepcopy(tracker), tuple(frames), tuple(rows))
                self.kept[earlier] = snapshot
                wanted.discard(earlier)
            frames.append(now)

        given = (frame for frame in stream.until(last) if frame.index > before)
        try:
            with wrong_motion_allowed():
                for answer in steps_of(tracker, given, asked):
                    require_rows(answer, frames if is_late else frames[-1:])
                    rows.append(answer)
            if is_late:
                now = None
                rows.append(tracker.finish())  # type: ignore[attr-defined]
            found = Tracks.concatenate(rows) if rows else Tracks.empty()
            require_rows(found, frames)
        except (Exception, SystemExit) as error:
            where = "in the end" if now is None else f"in frame {now} of {stream.recorded.name}"
            kind = "" if isinstance(error, BadRows) else f"{type(error).__name__}: "
            reason = " ".join(f"{kind}{error}".split())
            raise TrackerFailed(self.tracker_spec.name, where, reason, now) from error
        return found


def require_tracker(word: str, isolation: Isolation = DEFAULT_ISOLATION) -> TrackerSpec:
    """The tracker of a word, as `mot-sim sweep` takes it. Raises UnknownName and BadConfig."""
    found = tracker_specs_of([name for name in word.split(",") if name])
    if len(found) != 1:
        raise BadConfig(f"--tracker {word}: give one tracker; run the command again for another")
    spec = replace(found[0], isolation=isolation)
    spec.check()
    return spec


class Attribution(NamedTuple):
    """The verdict on a switch, and the noise sources that cause it."""

    verdict: str
    """One of VERDICTS."""
    sources: tuple[str, ...] = ()
    """The sources each of which, switched off alone, removes the switch."""
    by_control: bool | None = None
    """Whether the switch also vanishes when its one source is off only just before its window, as
    long; None: not tested."""


@dataclass(frozen=True)
class Cause:
    """The cause of one switch of a car between two frames (see `Breaks`)."""

    before: int
    """Last frame in which the car was matched under its old track id."""
    frame: int
    """First frame in which the car is matched under its new track id."""
    car: int
    """Label id of the car."""
    verdict: str
    """One of VERDICTS."""
    sources: tuple[str, ...] = ()
    """The sources each of which, switched off alone, removes the switch."""
    by_control: bool | None = None
    """See `Attribution`."""


@dataclass(frozen=True)
class Incident:
    """Switches of one car that follow one another so closely that they get one verdict."""

    car: int
    """Label id of the car."""
    before: int
    """Last frame in which the car was matched under the first track id."""
    frame: int
    """First frame in which the car is matched under the last track id."""
    rows: tuple[int, ...]
    """Rows of the table of switches."""


class AblationWindow(NamedTuple):
    """The frames in which a source is off, and how far the drive is tracked."""

    first: int
    """First frame in which the source is off."""
    last: int
    """Last frame in which the source is off."""
    until: int
    """Last frame that is tracked."""


def incidents(switches: Breaks, window: int) -> Iterator[Incident]:
    """The switches of each car, grouped where their windows (in frames) touch."""
    for car, rows in by_id(switches.cars):
        apart = switches.before[rows[1:]] - switches.frames[rows[:-1]]
        for group in np.split(rows, np.flatnonzero(apart > 2 * window) + 1):
            first, last = int(switches.before[group[0]]), int(switches.frames[group[-1]])
            yield Incident(car, first, last, tuple(group.tolist()))


def is_kept(matches: Matches, incident: Incident, window: int) -> bool:
    """Whether the car has one track id around an incident, and was matched at both ends."""
    own = matches.of_car(incident.car)
    first, last = incident.before - window, incident.frame + 2 * window
    own = own.select((own.frames >= first) & (own.frames <= last))
    if not len(own) or (own.track_ids != own.track_ids[0]).any():
        return False
    return bool(own.frames[0] <= incident.before and own.frames[-1] >= incident.frame)


@dataclass(eq=False)
class Attributor:
    """Attributes the switches of one drive to noise sources."""

    ablation: SourceAblation
    """The drive as it is, and with each of its sources off."""
    labels: Tracks
    """The labels of all frames of the recording."""
    replays: Replays
    """Runs of the tracker that made the switches."""
    replayed: dict[tuple[str, AblationWindow], Matches] = field(default_factory=dict)
    """The matches of the replays so far, by what was off and in which window."""

    def attribute(self, switches: Breaks) -> list[Cause]:
        """The cause of every switch, in their order."""
        stream = self.ablation.stream
        groups = list(incidents(switches, self._margin))
        starts = {self.window_of(each).first - 1 for each in groups} - {BEFORE_FIRST_FRAME}
        self.replays.run(stream, stream.frame_count, starts)
        found: dict[int, Cause] = {}
        for incident in groups:
            attribution = self._attribution(incident)
            for row in incident.rows:
                before, frame = int(switches.before[row]), int(switches.frames[row])
                found[row] = Cause(before, frame, incident.car, *attribution)
        return [found[row] for row in range(len(switches))]

    def window_of(self, incident: Incident) -> AblationWindow:
        """The frames around an incident, inside the recording."""
        end = self._last_frame
        first, last = incident.before - self._margin, incident.frame + self._margin
        until = end if self.replays.is_late else min(last + self._margin, end)
        return AblationWindow(max(first, 0), min(last, end), until)

    @property
    def _margin(self) -> int:
        """WINDOW_SECONDS in frames."""
        return round(WINDOW_SECONDS * self.ablation.stream.frame_rate)

    @property
    def _last_frame(self) -> int:
        return self.ablation.stream.frame_count - 1

    def _attribution(self, incident: Incident) -> Attribution:
        """First each source alone, then all of them in the window, then all in the whole drive."""
        window = self.window_of(incident)
        sources = tuple(
            source for source in self.ablation.off if self._vanishes(incident, source, window)
        )
        if len(sources) == 1:
            return Attribution(ONE_SOURCE, sources, self._control(incident, sources[0], window))
        if sources:
            return Attribution(EITHER_SOURCE, sources)
        calm = self.ablation.without_any(window.first, window.last)
        if self._is_kept(incident, "all", window, calm):
            return Attribution(SEVERAL_TOGETHER)
        everywhere = AblationWindow(0, self._last_frame, window.until)
        if self._is_kept(incident, "all", everywhere, self.ablation.silent):
            return Attribution(EARLIER_NOISE)
        return Attribution(NO_NOISE)

    def _vanishes(self, incident: Incident, source: str, window: AblationWindow) -> bool:
        """Whether an incident is gone when a source is off in a window."""
        stream = self.ablation.without(source, window.first, window.last)
        return stream is not None and self._is_kept(incident, source, window, stream)

    def _control(self, incident: Incident, source: str, window: AblationWindow) -> bool | None:
        """Whether it is also gone when the source is off only just before its window."""
        earlier = max(window.first - (window.last - window.first + 1), 0)
        if earlier >= window.first or source in self.ablation.whole:
            return None
        return self._vanishes(
            incident, source, AblationWindow(earlier, window.first - 1, window.until)
        )

    def _is_kept(
        self, incident: Incident, what: str, window: AblationWindow, stream: DetectionStream
    ) -> bool:
        """Whether the car keeps its track id over a changed stream. what: is off in the window."""
        key = what, window
        if key not in self.replayed:
            self.replayed[key] = self._matches(window, stream)
        return is_kept(self.replayed[key], incident, self._margin)

    def _matches(self, window: AblationWindow, stream: DetectionStream) -> Matches:
        """The matches of the tracker over a stream that is changed in a window."""
        if stream.camera is self.ablation.stream.camera:
            output = self.replays.run_from(window.first - 1, stream, window.until)
        else:  # another calibration: the tracker must be built anew
            output = self.replays.run(stream, window.until)
        frames = self.labels.frames
        truth = self.labels.select(np.isin(frames, stream.frames) & (frames <= window.until))
        return Matches.of(truth, output, window.until + 1)


def shares(causes: list[Cause]) -> dict[str, float]:
    """How many switches each source causes; several that suffice alone get equal parts of one."""
    found: dict[str, float] = {}
    for cause in causes:
        for source in cause.sources:
            found[source] = found.get(source, 0.0) + 1.0 / len(cause.sources)
    return found
