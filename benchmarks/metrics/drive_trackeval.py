"""What TrackEval says: run by the Python of an environment that has trackeval==1.3.0.

Usage: python drive_trackeval.py GT_FOLDER TRACKERS_FOLDER REPEATS OUT.json
Knows nothing of this project: folders in, JSON out.
"""

import contextlib
import json
import os
import sys
from collections.abc import Callable
from time import perf_counter

import numpy as np
import trackeval


def main(gt_folder: str, trackers_folder: str, repeats: int, out: str) -> None:
    """Score every tracker in the folder; scores and seconds go into the JSON file."""
    metrics = [
        trackeval.metrics.HOTA(),
        trackeval.metrics.CLEAR({"PRINT_CONFIG": False}),
        trackeval.metrics.Identity({"PRINT_CONFIG": False}),
    ]
    dataset = trackeval.datasets.Kitti2DBox(
        {
            "GT_FOLDER": gt_folder,
            "TRACKERS_FOLDER": trackers_folder,
            "CLASSES_TO_EVAL": ["car"],
            "PRINT_CONFIG": False,
        }
    )
    results = {name: run(dataset, name, metrics, repeats) for name in sorted(dataset.tracker_list)}
    with open(out, "w") as file:
        json.dump(results, file, default=plain)


def run(dataset: object, tracker: str, metrics: list, repeats: int) -> dict:
    """Scores of one tracker, and the least seconds from memory and from files."""
    names = sorted(dataset.seq_list)

    def load() -> dict:
        return {name: dataset.get_raw_seq_data(tracker, name) for name in names}

    def score(raw: dict, overlaps: bool) -> dict:
        sequences = {}
        for name in names:
            if overlaps:  # already in what `load` gives: done again to be timed
                raw[name]["similarity_scores"] = [
                    dataset._calculate_similarities(labels, output)
                    for labels, output in zip(
                        raw[name]["gt_dets"], raw[name]["tracker_dets"], strict=True
                    )
                ]
            data = dataset.get_preprocessed_seq_data(raw[name], "car")
            sequences[name] = {metric.get_name(): metric.eval_sequence(data) for metric in metrics}
        combined = {
            metric.get_name(): metric.combine_sequences(
                {name: sequences[name][metric.get_name()] for name in names}
            )
            for metric in metrics
        }
        return {"sequences": sequences, "combined": combined}

    raw = load()
    seconds = {
        "memory": least_seconds(lambda: score(raw, overlaps=True), repeats),
        "files": least_seconds(lambda: score(load(), overlaps=False), repeats),
    }
    return {**score(raw, overlaps=False), "seconds": seconds}


def least_seconds(work: Callable[[], object], repeats: int) -> float:
    """The least of some runs' seconds; a busy machine only adds."""
    seconds = []
    for _ in range(repeats):
        start = perf_counter()
        work()
        seconds.append(perf_counter() - start)
    return min(seconds)


def plain(value: object) -> object:
    """numpy's numbers and arrays for JSON."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)


if __name__ == "__main__":
    with open(os.devnull, "w") as quiet, contextlib.redirect_stdout(quiet):
        main(sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4])
