"""Any sequence with images, its frames' motion seen in them."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TypeVar

from tracker.ego.odometry import VisualOdometry
from tracker.errors import MissingCue
from tracker.types import Frame, SequenceWrapper

Item = TypeVar("Item")


def with_visual_motion(frames: Iterable[Frame], odometry: VisualOdometry) -> Iterator[Frame]:
    """The frames with T_now_before and motion_cov from their images, their boxes left out.

    Frames without an image coast, see `VisualOdometry.step`; MissingCue after the last frame if
    not one of them had an image.
    """
    time, images, count = None, 0, 0
    for frame in frames:
        seconds = 0.1 if time is None else frame.time - time
        T_now_before, cov = odometry.step(frame.image, frame.found.boxes, seconds)
        first = time is None
        time, images, count = frame.time, images + (frame.image is not None), count + 1
        if first:
            T_now_before, cov = None, None
        yield replace(frame, T_now_before=T_now_before, motion_cov=cov)
    if count and not images:
        raise MissingCue(
            f"none of {count} frames has an image to see the motion in: load them (images=True)"
        )


@dataclass(frozen=True, eq=False)
class VisualSequence(SequenceWrapper):
    """A sequence whose frames carry the motion that their images show."""

    threaded: bool = False
    """Whether frames are made one ahead, on a thread of their own; the results are the same."""

    def __iter__(self) -> Iterator[Frame]:
        frames = with_visual_motion(self.sequence, VisualOdometry(self.camera))
        return prefetch(frames) if self.threaded else frames


def prefetch(items: Iterable[Item]) -> Iterator[Item]:
    """The same items in the same order, each started while the one before it is used.

    All of them are made on one thread, one after the other, so nothing about them changes; an
    error comes out where its item was due.
    """
    iterator, end = iter(items), object()
    with ThreadPoolExecutor(1, thread_name_prefix="ahead") as thread:
        coming = thread.submit(next, iterator, end)
        while (item := coming.result()) is not end:
            coming = thread.submit(next, iterator, end)
            yield item  # type: ignore[misc]
