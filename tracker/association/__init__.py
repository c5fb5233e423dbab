"""From costs to identities. The costs do not care which: `ASSOCIATIONS` is the register."""

from collections.abc import Callable

from tracker.association.greedy import Greedy
from tracker.association.hungarian import Hungarian
from tracker.association.match import Associate, Match
from tracker.association.stages import match_in_stages

ASSOCIATIONS: dict[str, Callable[[float], Associate]] = {
    "greedy": Greedy,
    "hungarian": Hungarian,
}

__all__ = ["ASSOCIATIONS", "Associate", "Greedy", "Hungarian", "Match", "match_in_stages"]
