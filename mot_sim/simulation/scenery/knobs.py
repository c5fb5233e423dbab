"""What a neighbourhood looks like, as far as somebody may choose."""

from dataclasses import dataclass

from tracker.errors import BadConfig

MOST = 3.0  # times a usual town's density


@dataclass(frozen=True)
class Knobs:
    """What a neighbourhood looks like; wear: of asphalt and paint, 0 to 1.

    houses, trees, furniture (lamps, signs, fences): 0 = none, 1 = as in a usual town, at most 3.
    """

    wear: float = 0.5
    houses: float = 1.0
    trees: float = 1.0
    furniture: float = 1.0

    def __post_init__(self) -> None:
        for name, most in (("wear", 1.0), ("houses", MOST), ("trees", MOST), ("furniture", MOST)):
            value = getattr(self, name)
            if not 0.0 <= value <= most:
                raise BadConfig(f"{name} of a neighbourhood is {value:g}: give 0 to {most:g}")
