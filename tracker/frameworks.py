"""Ways from costs to identities, by name: two frames, a window, or the whole drive at once."""

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol, runtime_checkable

from tracker.association import ASSOCIATIONS, Associate
from tracker.multi_frame import NetworkFlow, Window
from tracker.state import TrackerStatistics
from tracker.tracker import Tracker
from tracker.types import Frame, Tracks


@runtime_checkable
class Delayed(Protocol):
    """A tracker whose rows come later: `step` gives rows of earlier frames, `finish` the rest."""

    @property
    def counts(self) -> TrackerStatistics:
        """What was done since the reset."""
        ...

    def reset(self) -> None:
        """Forget everything; ids start anew."""
        ...

    def step(self, frame: Frame) -> Tracks:
        """The rows that are decided by now, in the order of frames; perhaps none."""
        ...

    def finish(self) -> Tracks:
        """The rows of all frames that `step` gave none of."""
        ...


def online(associate: Callable[[float], Associate]) -> Callable[[Tracker], Tracker]:
    """The framework of a two-frame association: the tracker with it, largest cost kept."""

    def with_it(tracker: Tracker) -> Tracker:
        max_cost = getattr(tracker.associate, "max_cost", 1.0)
        return replace(tracker, associate=associate(max_cost))

    with_it.__doc__ = associate.__doc__
    return with_it


# From a tracker, whose costs and other components stay, to the same in another framework.
FRAMEWORKS: dict[str, Callable[[Tracker], Tracker | Delayed]] = {
    **{name: online(associate) for name, associate in ASSOCIATIONS.items()},
    "network_flow": NetworkFlow,
    "window": Window,
}
