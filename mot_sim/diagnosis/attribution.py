"""A tracker over a stream, and again from the middle of it with some frames changed."""

from collections.abc import Iterable, Iterator
from copy import deepcopy
from dataclasses import dataclass, field

import numpy as np

from mot_sim.diagnosis.context_events import by_id
from mot_sim.diagnosis.sources import DetectionStream, SourceAblation
from mot_sim.experiments.sweep.following import TrackerFailed
from mot_sim.experiments.sweep.tracker_specs import BadRows, Steps, TrackerSpec, tracker_specs_of
from mot_sim.experiments.sweep.trial import require_rows
from mot_sim.metrics.breaks import Breaks, Matches
from tracker.errors import BadConfig
from tracker.types import Tracks

BEFORE_FIRST_FRAME = -1  # the frame before the first


@dataclass(frozen=True, eq=False)
class TrackerSnapshot:
    """A tracker after a frame, and all rows that it had given by then."""

    tracker: Steps
    came: tuple[int, ...]
    rows: tuple[Tracks, ...]


@dataclass(eq=False)
class Replays:
    """Runs of one tracker. Trackers of ours go on from copies; others begin anew each time.

    is_late: whether it decides later (`finish`), and so must see a drive to its end; known after
    the first run.
    """

    contender: TrackerSpec
    kept: dict[int, TrackerSnapshot] = field(default_factory=dict)
    is_late: bool = False

    def run(self, stream: DetectionStream, last: int, keep: Iterable[int] = ()) -> Tracks:
        """All rows up to a frame. keep: frames after which the tracker is copied, to go on from.

        Raises TrackerFailed when the tracker raises, or gives what cannot be scored, BadConfig
        where it cannot be built.
        """
        fresh = TrackerSnapshot(self.contender.build(stream.camera), (), ())
        wanted = set(keep) if self.contender.is_ours else set()
        return self._go_on(fresh, BEFORE_FIRST_FRAME, stream, last, wanted)

    def run_from(self, before: int, stream: DetectionStream, last: int) -> Tracks:
        """The same for a stream that is the kept one's up to and with the frame `before`."""
        if before not in self.kept:
            return self.run(stream, last)
        start = self.kept[before]
        copied = TrackerSnapshot(deepcopy(start.tracker), start.came, start.rows)
        return self._go_on(copied, before, stream, last, set())

    def _go_on(
        self,
        start: TrackerSnapshot,
        before: int,
        stream: DetectionStream,
        last: int,
        wanted: set[int],
    ) -> Tracks:
        """Frames after `before` up to `last`."""
        tracker, came, parts = start.tracker, list(start.came), list(start.rows)
        is_late = self.is_late = callable(getattr(tracker, "finish", None))
        at: int | None = None
        try:
            for frame in stream.until(last):
                if frame.index <= before:
                    continue
                at = frame.index
                for earlier in sorted(each for each in wanted if each < at):
                    self.kept[earlier] = TrackerSnapshot(
                        deepcopy(tracker), tuple(came), tuple(parts)
                    )
                    wanted.discard(earlier)
                came.append(at)
                parts.append(tracker.step(frame))
                require_rows(parts[-1], came if is_late else came[-1:])
            if is_late:
                at = None
                parts.append(tracker.finish())  # type: ignore[attr-defined]
            found = Tracks.concatenate(parts) if parts else Tracks.empty()
            require_rows(found, came)
        except (Exception, SystemExit) as error:
            where = "in the end" if at is None else f"in frame {at} of {stream.recorded.name}"
            kind = "" if isinstance(error, BadRows) else f"{type(error).__name__}: "
            reason = " ".join(f"{kind}{error}".split())
            raise TrackerFailed(self.contender.name, where, reason, at) from error
        return found


def require_tracker(word: str) -> TrackerSpec:
    """The tracker of a word, as `mot-sim sweep` takes it. Raises UnknownName and BadConfig."""
    found = tracker_specs_of([name for name in word.split(",") if name])
    if len(found) != 1:
        raise BadConfig(f"--tracker {word}: give one tracker; run the command again for another")
    found[0].check()
    return found[0]


WINDOW_SECONDS = 1.0  # seconds
# What may come of it. The first two are explained; the others no single source explains.
ONE_SOURCE = "one source"
EITHER_SOURCE = "either of several"
SEVERAL_TOGETHER = "several together"
EARLIER_NOISE = "noise long before"
NO_NOISE = "scene or tracker"
VERDICTS = (ONE_SOURCE, EITHER_SOURCE, SEVERAL_TOGETHER, EARLIER_NOISE, NO_NOISE)


@dataclass(frozen=True)
class Cause:
    """Of one switch: of a car, between two frames (see `Breaks`).

    sources: each of which, switched off alone, removes it. by_control: whether it also vanishes
    when the one source is off in a window as long that ends before this one: then its history
    alone sufficed. None: not asked, since there is not one source, or no frame before.
    """

    before: int
    frame: int
    car: int
    verdict: str
    sources: tuple[str, ...] = ()
    by_control: bool | None = None


@dataclass(frozen=True)
class Incident:
    """Switches of one car that follow so closely that they are judged as one."""

    car: int
    before: int
    frame: int
    rows: tuple[int, ...]


def incidents(switches: Breaks, window: int) -> Iterator[Incident]:
    """The switches in groups, so that no window holds a switch of another group of that car."""
    for car, rows in by_id(switches.cars):
        group: list[int] = []
        for row in [*rows.tolist(), None]:
            is_near = bool(
                group and row is not None
                and switches.before[row] <= switches.frames[group[-1]] + 2 * window
            )  # fmt: skip
            if group and not is_near:
                first, last = int(switches.before[group[0]]), int(switches.frames[group[-1]])
                yield Incident(car, first, last, tuple(group))
                group = []
            if row is not None:
                group.append(row)


def is_kept(matches: Matches, incident: Incident, window: int) -> bool:
    """Whether a car has one name over the frames of an incident, and was matched at both ends."""
    own = matches.of_car(incident.car)
    first, last = incident.before - window, incident.frame + 2 * window
    own = own.select((own.frames >= first) & (own.frames <= last))
    if not len(own) or (own.track_ids != own.track_ids[0]).any():
        return False
    return bool(own.frames[0] <= incident.before and own.frames[-1] >= incident.frame)


@dataclass(eq=False)
class Attributor:
    """Judges the switches of one drive. labels: of all frames of the recording.

    replays: of the tracker that made them; asked: replays that were needed, by what was off.
    """

    bench: SourceAblation
    labels: Tracks
    replays: Replays
    asked: dict[tuple[str, int, int, int], Matches] = field(default_factory=dict)

    @property
    def window(self) -> int:
        """WINDOW in frames."""
        return round(WINDOW_SECONDS * self.bench.stream.frame_rate)

    def attribute(self, switches: Breaks) -> list[Cause]:
        """A cause for every switch, in their order."""
        groups = list(incidents(switches, self.window))
        starts = {self._bounds(each)[0] - 1 for each in groups}
        self.replays.run(
            self.bench.stream, self.bench.stream.frame_count, starts - {BEFORE_FIRST_FRAME}
        )
        found: dict[int, Cause] = {}
        for incident in groups:
            verdict, sources, control = self._verdict(incident)
            for row in incident.rows:
                found[row] = Cause(
                    int(switches.before[row]), int(switches.frames[row]), incident.car,
                    verdict, sources, control,
                )  # fmt: skip
        return [found[row] for row in range(len(switches))]

    def _bounds(self, incident: Incident) -> tuple[int, int, int]:
        """First and last frame of the window, and the last that is looked at."""
        end = self.bench.stream.frame_count - 1
        first, last = incident.before - self.window, incident.frame + self.window
        until = end if self.replays.is_late else min(last + self.window, end)
        return max(first, 0), min(last, end), until

    def _verdict(self, incident: Incident) -> tuple[str, tuple[str, ...], bool | None]:
        """What an incident hangs on."""
        sources = tuple(name for name in self.bench.off if self._vanishes(incident, name))
        if len(sources) == 1:
            return ONE_SOURCE, sources, self._control(incident, sources[0])
        if sources:
            return EITHER_SOURCE, sources, None
        first, last, until = self._bounds(incident)
        calm = self._matches("all", first, last, until, self.bench.without_any(first, last))
        if is_kept(calm, incident, self.window):
            return SEVERAL_TOGETHER, (), None
        end = self.bench.stream.frame_count - 1
        silent = self._matches("all", 0, end, until, self.bench.silent)
        return (EARLIER_NOISE if is_kept(silent, incident, self.window) else NO_NOISE), (), None

    def _vanishes(self, incident: Incident, source: str) -> bool:
        """Whether an incident is gone when a source is off around it."""
        first, last, until = self._bounds(incident)
        stream = self.bench.without(source, first, last)
        if stream is None:
            return False
        matches = self._matches(source, first, last, until, stream)
        return is_kept(matches, incident, self.window)

    def _control(self, incident: Incident, source: str) -> bool | None:
        """Whether it is gone, too, when the source is off only before its window."""
        first, last, until = self._bounds(incident)
        earlier = max(first - (last - first + 1), 0)
        if earlier >= first or source in self.bench.whole:
            return None
        stream = self.bench.without(source, earlier, first - 1)
        if stream is None:
            return False
        matches = self._matches(source, earlier, first - 1, until, stream)
        return is_kept(matches, incident, self.window)

    def _matches(
        self, what: str, first: int, last: int, until: int, stream: DetectionStream
    ) -> Matches:
        """What the tracker makes of a changed stream, up to a frame."""
        key = what, first, last, until
        if key not in self.asked:
            mine = stream.camera is self.bench.stream.camera
            run = self.replays.run_from if mine else lambda _, *rest: self.replays.run(*rest)
            output = run(first - 1, stream, until)
            came = np.isin(self.labels.frames, stream.frames) & (self.labels.frames <= until)
            truth = self.labels.select(came)
            self.asked[key] = Matches.of(truth, output, until + 1)
        return self.asked[key]


def shares(causes: list[Cause]) -> dict[str, float]:
    """How many switches hang on each source; of several that suffice each gets an equal part."""
    found: dict[str, float] = {}
    for cause in causes:
        for source in cause.sources:
            found[source] = found.get(source, 0.0) + 1.0 / len(cause.sources)
    return found
