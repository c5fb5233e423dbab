"""How the scenes rank trackers beside KITTI: measured figures, kept with the package.

`python -m benchmarks.closed_loop --root KITTI --scenes all --keep-ranks` measures and writes them.
"""

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

from mot_sim.experiments.validation.agreement import Agreement
from mot_sim.experiments.validation.sums import METRICS
from mot_sim.files.documents import read_toml
from mot_sim.files.writing import write_lines
from tracker.errors import BadFile

RANKS = Path(__file__).with_name("scene_ranks.toml")
TRUSTED_RANK = 0.8  # Spearman's correlation from which a scene's ranks count as KITTI's
Ranks = dict[str, float]  # Spearman's correlation by metric, and `trackers`


@lru_cache(maxsize=4)
def read_ranks(path: Path = RANKS) -> dict[str, Ranks]:
    """Ranks by scene. Raises BadFile for what is no such file."""
    content, found = read_toml(path, "no ranks can be read"), {}
    for scene, table in content.items():
        if not isinstance(table, dict) or not {*METRICS, "trackers"} <= table.keys():
            raise BadFile(f"{path}: [{scene}]: give trackers, {', '.join(METRICS)}")
        found[scene] = {name: float(value) for name, value in table.items()}
    return found


def write_ranks(scenes: Mapping[str, Agreement], path: Path = RANKS) -> None:
    """Keep the ranks of these scenes; those of others stay."""
    ranks = read_ranks(path) if path.is_file() else {}
    for name, agreement in scenes.items():
        ranks[name] = {"trackers": len(agreement.names)} | {
            metric: round(agreement.rank_correlation(metric), 3) for metric in METRICS
        }
    lines = [
        "# Spearman's correlation of the ranks of trackers in a scene with those on KITTI's given",
        "# drives; written by",
        "# python -m benchmarks.closed_loop --root KITTI --scenes all --keep-ranks",
    ]
    for name in sorted(ranks):
        lines += ["", f"[{name}]", *(f"{key} = {value:g}" for key, value in ranks[name].items())]
    write_lines(path, lines)
    read_ranks.cache_clear()


def rank_line(scene: str) -> str:
    """What is known of a scene's ranks, in a sentence."""
    found = read_ranks().get(scene)
    if found is None:
        return (
            f"{scene}: whether it ranks trackers as KITTI does is not measured; mot-sim "
            f"validate-sim --scenes {scene} measures it."
        )
    said = ", ".join(f"{found[metric]:.2f} by {metric}" for metric in METRICS)
    weak = [metric for metric in METRICS if found[metric] < TRUSTED_RANK]
    trust = f"; do not read ranks by {', '.join(weak)} as KITTI's" if weak else ""
    return (
        f"{scene}: ranks of {found['trackers']:.0f} trackers agree with those on KITTI by "
        f"Spearman's correlation {said}{trust}."
    )
