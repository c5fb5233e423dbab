"""What stands beside roads one by one, made once a seed: trees, bushes, lamps, signs."""

from collections.abc import Callable
from functools import lru_cache

from mot_sim.simulation.scenery.furniture import ENAMEL, lamp_post, sign
from mot_sim.simulation.scenery.plants import KINDS, bush, trees
from mot_sim.simulation.scenery.solids import Solid

DETAILS = 3  # by how near a thing is seen from: 0 = near
BUSHES = 4  # that differ
Make = Callable[[int, int], Solid]  # the number-th of a kind, at a detail

_lamp_post, _sign = lru_cache(lamp_post), lru_cache(sign)


@lru_cache(maxsize=8)
def makers(seed: int) -> dict[str, tuple[Make, float, bool]]:
    """For each kind: what makes it, half the width of its foot, whether it has leaves."""
    grown = [trees(seed, detail) for detail in range(DETAILS)]
    low = [[bush(seed, kind, detail) for kind in range(BUSHES)] for detail in range(DETAILS)]
    return {
        "tree": (lambda number, detail: grown[detail][number * 7 % KINDS], 0.3, True),
        "bush": (lambda number, detail: low[detail][number * 3 % BUSHES], 0.6, True),
        "lamp": (lambda number, detail: _lamp_post(), 0.12, False),
        "sign": (
            lambda number, detail: _sign((number * 3 + number // 5) % len(ENAMEL)), 0.12, False,
        ),
    }  # fmt: skip
