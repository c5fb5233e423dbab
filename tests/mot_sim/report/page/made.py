"""Results made up for the tests of the report, one of every kind."""

from pathlib import Path

from mot_sim.experiments.result_file import Made, Result, write_result
from mot_sim.tables import Cell, Table

EVIL = "<script>alert('x')</script> & \"quotes\""
MADE = Made("mot-sim sweep --axis 'a b'", {"python": "3.11.9", "numpy": "2.1"}, "ab12" * 8)


def score(mean: float, half: float = 0.02) -> tuple[float, float, float]:
    """A mean and the ends of its interval."""
    return mean, mean - half, mean + half


def sweep_result(name: str = "default", made: Made = MADE, files: tuple[str, ...] = ()) -> Result:
    """Two axes one at a time, two trackers, two metrics."""
    levels: list[tuple[Cell, Cell]] = [(0.0, None), (1.0, None), (2.0, None), (None, 0), (None, 3)]
    rows = tuple(
        (*level, tracker, *score(0.9 - 0.1 * place - less), *score(2.0 + place, 0.5), 4, 0)
        for place, level in enumerate(levels)
        for tracker, less in ((name, 0.0), ("paper", 0.05))
    )
    columns = (
        "detector.jitter", "tracker.lifecycle.max_gap", "tracker", "HOTA", "HOTA low", "HOTA high",
        "IDSW", "IDSW low", "IDSW high", "seeds", "failed",
    )  # fmt: skip
    less = tuple((*level, "paper", *score(-0.05, 0.01), 4) for level in levels)
    design = Table.of("design", "What was run", ("setting", "value"), (("scene", "crossing"),))
    return Result(
        "sweep", f"crossing: {name}", made,
        (
            Table.of("means", "Scores", columns, rows),
            Table.of(
                "differences", "Differences to the first", (*columns[:6], "seeds"), less
            ),
            Table.of(
                "failures", "Trials that failed", ("tracker", "trials", "error"),
                ((name, 2, f"frame 3: {name} broke"),),
            ),
            design,
        ),
        files,
    )  # fmt: skip


def stress_result() -> Result:
    """Two suites; one bound is not kept, and one score is worse than the baseline."""
    columns = (
        "suite", "tracker", "metric", "must be", "bound", "reached", "reached low",
        "reached high", "seeds", "verdict", "failed", "error",
    )  # fmt: skip
    rows = (
        ("fog", "default", "HOTA", "at least", 0.68, *score(0.71), 8, "pass", 0, None),
        ("fog", "default", "IDSW", "at most", 1.8, *score(2.4, 1.0), 8, "FAIL", 0, None),
        ("night", "default", "HOTA", "at least", 0.7, *score(0.72), 8, "pass", 0, None),
    )
    beside = (
        "suite", "tracker", "metric", "baseline", "baseline low", "baseline high", "reached",
        "reached low", "reached high", "worse by", "verdict",
    )  # fmt: skip
    drifts = (
        ("fog", "default", "HOTA", *score(0.72), *score(0.71), 0.01, "as good"),
        ("fog", "default", "IDSW", *score(1.2, 0.8), *score(2.4, 1.0), 1.2, "WORSE"),
    )
    tables = (
        Table.of("verdicts", "", columns, rows),
        Table.of("drifts", "Beside the baseline", beside, drifts),
    )
    return Result("stress", "stress: fog, night", MADE, tables)


def break_result() -> Result:
    """One tracker breaks, the other does not."""
    about = (
        "tracker", "HOTA", "HOTA low", "HOTA high", "level", "level low", "level high",
        "farthest tried", "levels", "seeds", "failed", "error",
    )  # fmt: skip
    points = (
        ("default", *score(0.9), 2.3, 2.1, 2.7, 4.0, 6, 8, 0, None),
        ("paper", *score(0.8), None, 3.5, None, 4.0, 6, 8, 0, None),
    )
    curve = tuple(
        (level, tracker, *score(0.9 - 0.03 * level), *score(0.03 * level), 8)
        for tracker in ("default", "paper")
        for level in (0.0, 2.0, 4.0)
    )
    columns = (
        "detector.jitter", "tracker", "HOTA", "HOTA low", "HOTA high", "fall", "fall low",
        "fall high", "seeds",
    )  # fmt: skip
    return Result(
        "breaking-point", "crossing: where HOTA breaks", MADE,
        (
            Table.of("points", "Levels that cost 5 points of HOTA", about, points),
            Table.of("curves", "HOTA over jitter", columns, curve),
        ),
    )  # fmt: skip


def compare_result() -> Result:
    """Three trackers, one of which failed."""
    scores = (("default", 0.9, 0.88, 3, 800.0), ("iou", 0.8, 0.7, 9, None), ("mine", *[None] * 4))
    drives = (("0000", "default", 0.9, 3), ("0000", "iou", 0.8, 9))
    return Result(
        "compare", "rrc boxes", MADE,
        (
            Table.of("scores", "", ("tracker", "MOTA", "HOTA", "IDSW", "frames/s"), scores),
            Table.of(
                "failures", "Trackers that failed", ("tracker", "reason", "stderr"),
                (("mine", "exit code 3", "Traceback\n  line 2"),),
            ),
            Table.of("drives", "Drive by drive", ("drive", "tracker", "MOTA", "IDSW"), drives),
        ),
    )  # fmt: skip


def tables_result() -> Result:
    """A table of the paper, with a row that is quoted."""
    rows = (
        ("all", *score(0.9), 3),
        ("3D-2D", *score(0.85), 9),
        ("* the paper", 0.914, None, None, 232),
    )
    columns = ("row", "MOTA", "MOTA low", "MOTA high", "IDSW")
    return Result("tables", "Tables: III", MADE, (Table.of("III.1", "Table III", columns, rows),))


def tune_result() -> Result:
    """Weights of two costs."""
    weights = (("volume", 0.6, 0.05), ("reprojection", 0.4, 0.05))
    worth = (("the mean weights", 0.91),)
    return Result(
        "tune", "Weights", MADE,
        (
            Table.of("weights", "Weights of the costs", ("cost", "weight", "std"), weights),
            Table.of("worth", "", ("weights", "HOTA"), worth),
        ),
    )  # fmt: skip


def diagnosis_result() -> Result:
    """Switches by event, and what they hang on."""
    rate = ("switches per event", "switches per event low", "switches per event high")
    events = (("occlusion", 40, 7, *score(0.175, 0.05)), ("crossing", 30, 3, *score(0.1, 0.05)),
              ("all", None, 10, None, None, None))  # fmt: skip
    causes = (("misses", 6, *score(0.6, 0.1)), ("unexplained: none", 4, *score(0.4, 0.1)),
              ("all", 10, None, None, None))  # fmt: skip
    return Result(
        "diagnosis", "Why intersection broke", MADE,
        (
            Table.of("events", "By event", ("around", "events", "switches", *rate), events),
            Table.of(
                "causes", "What they hang on",
                ("hangs on", "switches", "share", "share low", "share high"), causes,
            ),
        ),
    )  # fmt: skip


EVERY = (
    sweep_result(), stress_result(), break_result(), compare_result(), tables_result(),
    tune_result(), diagnosis_result(),
)  # fmt: skip


def write_every(home: Path) -> list[Path]:
    """A folder with a result of every kind."""
    for result in EVERY:
        write_result(home / result.kind, result)
    return [home / result.kind for result in EVERY]
