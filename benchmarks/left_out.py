"""Settings of a tracker that are chosen on all drives but one and judged on that one."""

from collections.abc import Callable, Collection, Hashable, Mapping
from typing import TypeVar

from mot_sim.metrics import Scores, combine

Setting = TypeVar("Setting", bound=Hashable)
# By detector and drive.
DriveScores = Mapping[str, Mapping[str, Scores]]


def told(scores: Scores) -> str:
    """HOTA and MOTA in percent, and switches."""
    return f"{100 * scores['HOTA']:5.2f} {100 * scores['MOTA']:5.2f} {scores['IDSW']:3.0f}"


def together(found: DriveScores, names: Collection[str]) -> dict[str, Scores]:
    """Of each detector the scores of these drives together."""
    return {
        detector: combine([drives[name] for name in sorted(names)])
        for detector, drives in found.items()
    }


def choose(found: Mapping[Setting, DriveScores], names: Collection[str]) -> Setting:
    """The setting with the largest sum of HOTA over the detectors on these drives."""

    def merit(setting: Setting) -> float:
        return sum(scores["HOTA"] for scores in together(found[setting], names).values())

    return max(found, key=merit)  # of equals the first


def print_choice(
    found: Mapping[Setting, DriveScores], choosing: Collection[str], label: Callable[[Setting], str]
) -> None:
    """Every setting on all drives, what each gets where the others choose, and its scores.

    choosing: the drives that take part in the choice.
    """
    first = next(iter(found.values()))
    drives = next(iter(first.values())).keys()
    print(f"{'HOTA, MOTA, switches':28s}" + "".join(f"{detector:22s}" for detector in first))

    def row(title: str, scores: DriveScores) -> None:
        cells = together(scores, drives).values()
        print(f"{title:28s}" + "".join(f"{told(cell):22s}" for cell in cells), flush=True)

    for setting, scores in found.items():
        row(label(setting), scores)
    chosen = {name: choose(found, set(choosing) - {name}) for name in drives}
    for name in sorted(choosing):
        print(f"{name} left out: {label(chosen[name])}")
    left_out = {
        detector: {name: found[chosen[name]][detector][name] for name in drives}
        for detector in first
    }
    row("each as the others choose", left_out)
