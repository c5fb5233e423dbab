"""Other trackers' results on the labelled KITTI sequences, where they lie beside the root."""

from pathlib import Path

import pytest

from mot_sim.datasets import read_labels, read_results
from mot_sim.datasets.kitti.places import TRAINING_FRAMES
from tracker.types import Tracks


def golden_results(kitti_root: Path, tracker: str) -> dict[str, tuple[Tracks, Tracks, int]]:
    """Labels, output and number of frames by sequence, as `evaluate` takes them; else a skip."""
    folder = kitti_root.parent / "golden_scores" / tracker
    if not folder.is_dir():
        pytest.skip("no golden result files beside the KITTI root")
    return {
        path.stem: (
            read_labels(path),
            read_results(folder / path.name),
            TRAINING_FRAMES[int(path.stem)],
        )
        for path in sorted((kitti_root / "training" / "label_02").glob("*.txt"))
    }
