"""How large the report is, and how long it takes to write and to open.

    python -m benchmarks.report [FOLDER...] [--clips 4] [--runs 5]

Without folders: a made-up sweep of 7 axes x 5 levels x 4 trackers x 9 scores, a stress test of 11
suites, a comparison of 12 trackers, and clips of H.264. Each run opens the page in a fresh profile
of headless Chromium: until it is loaded (text, tables and still charts stand there), and until
the first chart can be used. CPU seconds are those of the page's main thread; they hang less on
who else is on the machine.
"""

import argparse
import os
import shutil
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np

from mot_sim.experiments.result_file import Made, Result, made_here, write_result
from mot_sim.experiments.sweep.summary import METRICS
from mot_sim.plotting import write_video
from mot_sim.report.page import MAX_PAGE_BYTES, write_report
from mot_sim.tables import Table

AXES, LEVELS, TRACKERS = 7, 5, ("default", "paper", "greedy", "window")
CLIP = (375, 1242)  # height and width of KITTI's images
MOST_SECONDS = 2.0  # to open


def made_sweep(made: Made) -> Result:
    """One axis at a time; scores that fall."""
    rng = np.random.default_rng(0)
    axes = [f"detector.noise_{number}" for number in range(AXES)]
    ends = [f"{name}{end}" for name in METRICS for end in ("", " low", " high")]
    rows = []
    for number in range(AXES):
        for level in range(LEVELS):
            for tracker in TRACKERS:
                means = rng.uniform(0.5, 0.9, len(METRICS)) - 0.05 * level
                spread = [value for mean in means for value in (mean, mean - 0.02, mean + 0.02)]
                at = [float(level) if place == number else None for place in range(AXES)]
                rows.append((*at, tracker, *map(float, spread), 20, 0))
    columns = (*axes, "tracker", *ends, "seeds", "failed")
    return Result("sweep", "a sweep", made, (Table.of("means", "Scores", columns, tuple(rows)),))


def made_stress(made: Made) -> Result:
    """Eleven suites with four bounds."""
    columns = (
        "suite", "tracker", "metric", "must be", "bound", "reached", "reached low",
        "reached high", "seeds", "verdict", "failed", "error",
    )  # fmt: skip
    rows = tuple(
        (f"suite {number}", tracker, metric, "at least", 0.6, 0.7, 0.68, 0.72, 8, "pass", 0, None)
        for number in range(11)
        for tracker in TRACKERS
        for metric in ("HOTA", "IDF1", "MOTA", "IDSW")
    )
    return Result("stress", "suites", made, (Table.of("verdicts", "Bounds", columns, rows),))


def made_peers(made: Made) -> Result:
    """Twelve trackers."""
    columns = ("tracker", "MOTA", "HOTA", "AssA", "IDF1", "IDSW", "frames / CPU s")
    rows = tuple((f"tracker {k}", *(0.9 - 0.01 * k,) * 4, 3 + k, 800.0) for k in range(12))
    return Result("compare", "peers", made, (Table.of("scores", "All", columns, rows),))


def write_inputs(home: Path, clips: int) -> list[Path]:
    """Folders of all of these; the clips, of 30 frames, belong to the stress test."""
    made = made_here()
    names = tuple(f"moment-{number}.mp4" for number in range(clips))
    stress = made_stress(made)
    results = (
        made_sweep(made),
        Result(stress.kind, stress.title, made, stress.tables, names),
        made_peers(made),
    )
    for result in results:
        write_result(home / result.kind, result)
    rng = np.random.default_rng(1)
    still = rng.integers(60, 200, (CLIP[0] // 8, CLIP[1] // 8 + 1, 3)).repeat(8, 0).repeat(8, 1)
    still = still[: CLIP[0] - 1, : CLIP[1]].astype(np.uint8)
    for name in names:
        write_video(home / "stress" / name, [np.roll(still, 6 * k, 1) for k in range(30)], 10.0)
    return [home / result.kind for result in results]


def open_page(path: Path, runs: int) -> list[tuple[float, float, float, float]]:
    """Wall and CPU seconds until it is loaded, and until a chart is there, of each run."""
    from playwright.sync_api import sync_playwright

    program = os.environ.get("MOT_SIM_CHROMIUM") or shutil.which("chromium")
    found = []
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=program, args=["--no-sandbox"])
        print(f"Chromium {browser.version}")
        for _ in range(runs):
            context = browser.new_context(viewport={"width": 1280, "height": 900})
            page = context.new_page()
            session = context.new_cdp_session(page)
            session.send("Performance.enable", {"timeDomain": "threadTicks"})
            start = perf_counter()
            page.goto(path.as_uri())
            loaded, loaded_cpu = perf_counter() - start, cpu_of(session)
            page.wait_for_selector(".js-plotly-plot .main-svg")
            found.append((loaded, loaded_cpu, perf_counter() - start, cpu_of(session)))
            context.close()
        browser.close()
    return found


def cpu_of(session) -> float:
    """CPU seconds of the main thread so far."""
    metrics = session.send("Performance.getMetrics")["metrics"]
    return next(each["value"] for each in metrics if each["name"] == "TaskDuration")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--clips", type=int, default=4)
    parser.add_argument("--runs", type=int, default=5)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        home = Path(place)
        folders = given.folders or write_inputs(home, given.clips)
        start, cpu = perf_counter(), process_time()
        report = write_report(folders, home / "report.html")
        wall, cpu = perf_counter() - start, process_time() - cpu
        clips = sum(name.endswith(".mp4") for each in report.sources for name in each.result.files)
        print(
            f"{len(report.sources)} results, {clips} clips: {report.size / 1e6:.2f} MB of "
            f"{MAX_PAGE_BYTES / 1e6:.0f}, {len(report.left_out)} files left out"
        )
        print(f"written in {wall:.1f} s of wall time, {cpu:.1f} CPU s")
        seconds = open_page(report.path, given.runs)
    for number, (what, limit) in enumerate((("loaded", MOST_SECONDS), ("first chart", None))):
        walls = [each[2 * number] for each in seconds]
        cpus = [each[2 * number + 1] for each in seconds]
        told = "" if limit is None else f" (asked: below {limit:g} s)"
        print(
            f"{what:12s} median {median(walls):.2f} s, worst {max(walls):.2f} s of {len(walls)}"
            f"{told}; median {median(cpus):.2f} CPU s"
        )


if __name__ == "__main__":
    main()
