"""The trackers whose scores are foretold: ours, variants of ours, and other people's."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from mot_sim.experiments.guests import (
    GUESTS,
    ExternalSequenceTracker,
    ExternalTracker,
    OwnTracker,
    SequenceTracker,
    find_sequence_tracker,
)
from tracker import Tracker
from tracker.association import Greedy
from tracker.errors import BadConfig
from tracker.lifecycle import Lifecycle

SHORT_MEMORY = Lifecycle(0.8, 0.5)
VARIANTS: dict[str, OwnTracker] = {
    each.name: each
    for each in (
        OwnTracker(
            "greedy", lambda camera, _: replace(Tracker.default(camera), associate=Greedy(0.7))
        ),
        OwnTracker("no-ego", lambda camera, _: Tracker.default(camera), uses_motion=False),
        OwnTracker(
            "low-memory",
            lambda camera, _: replace(Tracker.default(camera), lifecycle=SHORT_MEMORY),
        ),
    )
}
OURS = ("default", "paper", "iou", *VARIANTS)
MIN_CONTESTANTS = 3  # from which ranks mean anything


@dataclass(frozen=True)
class Contestant:
    """A tracker of the table."""

    name: str
    """Its name, by which `find_contestant` gives the same again."""
    tracker: SequenceTracker
    """What tracks."""

    @property
    def guest(self) -> ExternalTracker | None:
        """The program of another author; None: one of ours."""
        mine = self.tracker
        return mine.guest if isinstance(mine, ExternalSequenceTracker) else None


def find_contestant(name: str, guests: Mapping[str, ExternalTracker] = GUESTS) -> Contestant:
    """One of VARIANTS, or a tracker as `find_sequence_tracker` knows it.

    Raises UnknownName, and BadConfig for a tracker of yours that cannot be built.
    """
    if name in VARIANTS:
        return Contestant(name, VARIANTS[name])
    return Contestant(name, find_sequence_tracker(name, guests))


def find_contestants(names: Sequence[str]) -> list[Contestant]:
    """All of these; by default ours and the guests. Raises BadConfig for fewer than three."""
    chosen = [find_contestant(name) for name in names or (*OURS, *GUESTS)]
    if len(chosen) < MIN_CONTESTANTS:
        raise BadConfig(
            f"{len(chosen)} trackers: ranks need {MIN_CONTESTANTS} or more; give all (the "
            f"default), or names of {', '.join((*OURS, *GUESTS))}"
        )
    return chosen
