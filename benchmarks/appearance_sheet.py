"""The pairs of cars that a descriptor confuses most often, as a picture. Look at it."""

import numpy as np
from numpy import ndarray as Array

from benchmarks.appearance_samples import CROP, Seen, matches
from mot_sim.plotting.canvas import draw_text

COLUMNS, ROWS = 4, 4  # of pairs, for each set
WHITE = (255, 255, 255)


def confusion_sheet(sets: dict[str, list[Seen]], name: str, gap: int = 5) -> Array:
    """For each set, the pairs most often confused over `gap` frames.

    From left to right: the car that asks, the same car later, and whom it was taken for.
    """
    return np.concatenate([_panel(what, seen, name, gap) for what, seen in sets.items()])


def _panel(what: str, seen: list[Seen], name: str, gap: int) -> Array:
    """One set's pairs, under its name."""
    found = matches(seen, name, gap)
    tile = (CROP + 22, 3 * (CROP * 3 // 2) + 12)
    rows = min(-(-len(found.confused) // COLUMNS), ROWS)
    canvas = np.zeros((26 + rows * tile[0], COLUMNS * tile[1], 3), np.uint8)
    rank = f"rank-1 {100 * found.rank1:.1f} % of {found.queries}, {gap} frames apart"
    draw_text(canvas, f"{what}, {name}: {rank}", (6, 18), WHITE)
    for number, ((drive, asker, other), count) in enumerate(
        found.confused.most_common(ROWS * COLUMNS)
    ):
        top = 26 + number // COLUMNS * tile[0]
        left = number % COLUMNS * tile[1]
        strip = _example(seen, name, gap, (drive, asker, other))
        canvas[top : top + CROP, left : left + strip.shape[1]] = strip
        words = f"{drive}: {asker} as {other}, {count}x"
        draw_text(canvas, words, (left + 2, top + CROP + 15), WHITE, 13)
    return canvas


def _example(seen: list[Seen], name: str, gap: int, pair: tuple[str, int, int]) -> Array:
    """The first time that a pair was confused: asker, the same car later, the other."""
    drive, asker, other = pair
    later = {(one.drive, one.frame): one for one in seen}
    for one in seen:
        then = later.get((one.drive, one.frame + gap))
        if one.drive != drive or then is None or asker not in one.ids:
            continue
        if pair not in matches([one, then], name, gap).confused:
            continue
        rows = [int(np.flatnonzero(then.ids == number)[0]) for number in (asker, other)]
        first = one.crops[int(np.flatnonzero(one.ids == asker)[0])]
        return np.concatenate([first, *(then.crops[row] for row in rows)], axis=1)
    raise AssertionError(f"{pair} were never confused")
