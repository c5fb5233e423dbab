"""Small worlds to score, made from seeds: the metrics' tests and the comparison share them."""

from dataclasses import dataclass

import numpy as np

from tracker.types import Tracks

RANDOM_CASES = 200
BLANKS = {0: "output", 1: "truth", 2: "both", 3: "cars"}  # what a seed modulo 20 leaves out


@dataclass(frozen=True, eq=False)
class Case:
    """One sequence to score."""

    name: str
    truth: Tracks
    output: Tracks
    frame_count: int


def all_cases() -> list[Case]:
    """Every random case, then every edge case."""
    return [random_case(seed) for seed in range(RANDOM_CASES)] + edge_cases()


def tracks(rows: list[tuple]) -> Tracks:
    """Tracks of rows (frame, id, box[, kind[, truncation, occlusion]]); a car unless told."""
    whole = [(*row, *("Car", 0, 0)[len(row) - 3 :]) for row in rows]
    columns = list(zip(*whole, strict=True)) or [()] * 6
    frames, ids, boxes, kinds, truncation, occlusion = columns
    return Tracks(
        np.array(frames, dtype=np.int64),
        np.array(ids, dtype=np.int64),
        np.array(boxes, dtype=float).reshape(-1, 4),
        kinds=np.array(kinds, dtype="U12"),
        truncation=np.array(truncation, dtype=np.int64),
        occlusion=np.array(occlusion, dtype=np.int64),
    )


def random_case(seed: int) -> Case:
    """A street with gaps, swapped and new ids, false alarms, twins and neutral labels.

    One third of the cases have whole pixels only, so that ties occur. Some leave out labels or
    output as a whole.
    """
    rng = np.random.default_rng(seed)
    frame_count = int(rng.integers(1, 40))
    crowd = rng.uniform(0.1, 1.0)  # small: all cars in one corner
    labels = moving_cars(rng, frame_count, crowd) + dont_care(rng, frame_count, crowd)
    output = seen_cars(rng, labels) + false_alarms(rng, frame_count, crowd)
    blank_truth, blank_output = (set(rng.integers(0, frame_count, 3).tolist()) for _ in range(2))
    labels = [row for row in labels if row[0] not in blank_truth]
    output = [row for row in output if row[0] not in blank_output]
    gone = BLANKS.get(seed % 20, "")
    if gone in ("truth", "both"):
        labels = []
    if gone in ("output", "both"):
        output = []
    if gone == "cars":
        labels = [row for row in labels if row[3] != "Car"]
    digits = int(rng.integers(0, 3))
    for rows in (labels, output):
        rng.shuffle(rows)
        rows[:] = [(*row[:2], tuple(np.round(row[2], digits).tolist()), *row[3:]) for row in rows]
    return Case(f"random-{seed:03d}", tracks(labels), tracks(output), frame_count)


def moving_cars(rng: np.random.Generator, frame_count: int, crowd: float) -> list[tuple]:
    """Label rows of objects that drift, most of them cars, some neutral in some frames."""
    rows = []
    for name in rng.permutation(30)[: rng.integers(1, 9)].tolist():
        kind = str(rng.choice(["Car", "Van", "Pedestrian", "Truck"], p=[0.78, 0.12, 0.06, 0.04]))
        size = rng.uniform([20, 15], [160, 120])
        corner = rng.uniform([0, 0], [900, 250]) * crowd
        speed = rng.normal(0, 4, 2)
        first, last = np.sort(rng.integers(0, frame_count + 1, 2)).tolist()
        for frame in range(first, last):
            if rng.random() < 0.05:
                continue
            here = corner + speed * (frame - first)
            truncation = int(rng.choice([0, 1, 2], p=[0.9, 0.07, 0.03]))
            occlusion = int(rng.choice([0, 1, 2, 3], p=[0.6, 0.2, 0.12, 0.08]))
            rows.append((frame, name, (*here, *(here + size)), kind, truncation, occlusion))
    return rows


def dont_care(rng: np.random.Generator, frame_count: int, crowd: float) -> list[tuple]:
    """Rows of regions that stay in place for a while."""
    rows = []
    for _ in range(rng.integers(0, 3)):
        corner = rng.uniform([0, 0], [900, 250]) * crowd
        box = (*corner, *(corner + rng.uniform(40, 300, 2)))
        stay = range(frame_count // 2, frame_count)
        rows += [(frame, -1, box, "DontCare", -1, -1) for frame in stay]
    return rows


def seen_cars(rng: np.random.Generator, labels: list[tuple]) -> list[tuple]:
    """Output rows near the labels: some missing, some with a twin, with ids that wander."""
    objects = [row for row in labels if row[3] != "DontCare"]
    ids = {row[1]: 100 + row[1] for row in objects}
    found, noise = rng.uniform(0.5, 1.0), rng.choice([0.0, 1.0, 4.0, 12.0])
    fresh, rows = 200, []
    for frame, name, box, *_ in sorted(objects, key=lambda row: row[0]):
        if rng.random() < 0.04:
            ids[name] = fresh = fresh + 1
        if rng.random() < 0.04 and not any(row[0] == frame for row in rows):
            other = int(rng.choice(list(ids)))
            ids[name], ids[other] = ids[other], ids[name]
        if rng.random() > found:
            continue
        seen = tuple(np.asarray(box) + rng.normal(0, noise, 4))
        rows.append((frame, ids[name], seen))
        if rng.random() < 0.06:
            fresh += 1
            rows.append((frame, fresh, seen))
    return rows


def false_alarms(rng: np.random.Generator, frame_count: int, crowd: float) -> list[tuple]:
    """Output rows of boxes where nothing is, low ones among them, that stand still for a while."""
    rows = []
    for name in range(900, 900 + int(rng.integers(0, 5))):
        corner = rng.uniform([0, 0], [900, 250]) * crowd
        box = (*corner, *(corner + rng.uniform([20, 15], [120, 60])))
        first, last = np.sort(rng.integers(0, frame_count + 1, 2)).tolist()
        rows += [(frame, name, box) for frame in range(first, last)]
    return rows


def edge_cases() -> list[Case]:
    """The worlds of `EDGES`."""
    return [Case(name, tracks(rows[0]), tracks(rows[1]), 6) for name, rows in EDGES.items()]


def shuffled(table: Tracks, rng: np.random.Generator) -> Tracks:
    """The same rows in another order."""
    return table.select(rng.permutation(len(table)))


def shifted(box: tuple[float, ...], right: float) -> tuple[float, ...]:
    """The box moved to the right."""
    return (box[0] + right, box[1], box[2] + right, box[3])


BOX, LOW, FLAT = (0.0, 0.0, 40.0, 30.0), (0.0, 0.0, 40.0, 25.0), (5.0, 5.0, 5.0, 50.0)
HALF, AWAY = (0.0, 0.0, 40.0, 60.0), (500.0, 0.0, 540.0, 40.0)
BESIDE = (20.0, 0.0, 60.0, 30.0)
WALK = [(frame, 1, shifted(BOX, 3.0 * frame)) for frame in range(6)]
# Thresholds met exactly, ties, and nothing on one side or both: labels, then output.
EDGES: dict[str, tuple[list[tuple], list[tuple]]] = {
    "nothing": ([], []),
    "labels-only": (WALK, []),
    "output-only": ([], WALK),
    "vans-only": ([(*row, "Van") for row in WALK], WALK),
    "neutral-and-alarm": ([(*row, "Van") for row in WALK], [*WALK, (2, 9, AWAY)]),
    "dont-care-only": ([(1, -1, BOX, "DontCare", -1, -1)], [(1, 5, BOX), (2, 5, BOX)]),
    "ignored-only": (WALK, [(1, 5, shifted(LOW, 600.0))]),
    "perfect": (WALK, WALK),
    "half-overlap": ([(0, 1, BOX), (1, 1, HALF)], [(0, 5, HALF), (1, 5, BOX)]),
    "height-25": ([(0, 1, AWAY)], [(0, 5, LOW), (1, 5, LOW), (2, 5, BOX)]),
    "half-in-dont-care": (
        [(0, 1, AWAY), (0, -1, (20.0, 0.0, 99.0, 99.0), "DontCare"), (1, 1, AWAY)],
        [(0, 5, BOX), (1, 5, BOX)],
    ),
    "more-in-dont-care": (
        [(0, 1, AWAY), (0, -1, (19.0, 0.0, 99.0, 99.0), "DontCare"), (1, 1, AWAY)],
        [(0, 5, BOX), (1, 5, BOX)],
    ),
    "twins": (WALK, [*WALK, *((frame, 2, where) for frame, _, where in WALK)]),
    "label-twins": ([*WALK, *((frame, 2, where) for frame, _, where in WALK)], WALK),
    "between-two": ([(0, 1, BOX), (0, 2, BESIDE)], [(0, 5, shifted(BOX, 10.0))]),
    "keeps-its-name": (
        [(frame, 1, BOX) for frame in range(3)],
        [(0, 5, BOX), (1, 5, shifted(BOX, 6.0)), (1, 6, BOX), (2, 5, BOX)],
    ),
    "empty-frame-between": (
        [(frame, 1, BOX) for frame in range(5)],
        [(0, 5, BOX), (1, 5, BOX), (3, 6, BOX), (4, 5, shifted(BOX, 6.0)), (4, 6, BOX)],
    ),
    "no-area": ([(0, 1, FLAT), (1, 1, BOX)], [(0, 5, FLAT), (1, 5, BOX)]),
    "negative-ids": ([(0, -1, BOX), (0, 1, AWAY)], [(0, -1, BOX), (0, 5, AWAY)]),
    "levels": (
        [(0, 1, BOX, "Car", 1, 0), (1, 1, BOX, "Car", 0, 3), (2, 1, BOX, "Car", -1, 2)],
        [(frame, 5, BOX) for frame in range(3)],
    ),
}
