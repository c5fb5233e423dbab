"""Ratios of a benchmark beside those that were kept: what became slower, whatever the machine.

A ratio is a cost over that of a yardstick of the same run, so more is slower. Those that are kept
lie in benchmarks/baseline.json, which `--update-baseline` of a benchmark writes its own rows of.
"""

import argparse
import json
from pathlib import Path

from mot_sim.files.writing import write_lines

FILE = Path(__file__).with_name("baseline.json")
Kept = dict[str, dict[str, float]]


class Ratios:
    """The ratios that a benchmark measures, row by row."""

    def __init__(self, benchmark: str) -> None:
        self.benchmark = benchmark
        self.measured: dict[str, float] = {}

    @staticmethod
    def add_option(parser: argparse.ArgumentParser) -> None:
        """`--update-baseline` for the parser of a benchmark."""
        parser.add_argument(
            "--update-baseline", action="store_true", help="keep the ratios of this run"
        )

    def add(self, row: str, cost: float, yardstick: float) -> float:
        """Note a cost, in whatever unit that of the yardstick has; gives their ratio."""
        self.measured[row] = cost / yardstick
        return self.measured[row]

    def tell(self, update: bool, file: Path = FILE) -> None:
        """Print each ratio beside the one that is kept, and keep it where that is wanted."""
        kept: Kept = json.loads(file.read_text()) if file.exists() else {}
        before = kept.get(self.benchmark, {})
        width = max(map(len, self.measured), default=0)
        print(f"\n{'ratio to the yardstick':{max(width, 22)}}     kept      now   times")
        for row, ratio in self.measured.items():
            old = before.get(row)
            beside = "        -" if old is None else f"{old:9.3f}"
            times = "      -" if old is None else f"{ratio / old:7.2f}"
            print(f"{row:{max(width, 22)}}{beside}{ratio:9.3f} {times}")
        if update:
            rows = {row: float(f"{ratio:.4g}") for row, ratio in self.measured.items()}
            kept[self.benchmark] = before | rows
            write_lines(file, [json.dumps(kept, indent=1, sort_keys=True)])
            print(f"kept in {file.name}")
