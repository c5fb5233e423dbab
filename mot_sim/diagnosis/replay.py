"""A tracker over a stream, and again from the middle of it with some frames changed."""

from collections.abc import Iterable
from copy import deepcopy
from dataclasses import dataclass, field

from mot_sim.diagnosis.streams import DetectionStream
from mot_sim.experiments.sweep.following import TrackerFailed
from mot_sim.experiments.sweep.tracker_specs import BadRows, Steps, TrackerSpec, tracker_specs_of
from mot_sim.experiments.sweep.trial import require_rows
from tracker import Tracks
from tracker.errors import BadConfig

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


__all__ = ["Replays", "require_tracker"]
