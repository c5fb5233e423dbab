"""A folder of results: `SSSS.txt` a finished sequence, and `run.json`, how they were made."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.boxes import RUN_FILE
from mot_sim.datasets.estimate_files import estimates_path
from mot_sim.datasets.kitti.labels import write_results
from mot_sim.files.resumable_folder import TextPartsFolder
from tracker.errors import BadFile
from tracker.types import Tracks

MAX_NAME_LETTERS = 100  # letters of a sequence; file systems take 255 bytes


@dataclass(frozen=True)
class SequenceStatistics:
    """What went through a tracker in one sequence."""

    frames: int
    """Frames tracked."""
    detections: int
    """Boxes that the tracker was given."""
    rows: int
    """Rows that the tracker gave."""
    ids: int
    """Different ids in them."""
    seconds: float
    """Wall time, s, reading included."""
    pairs: int = 0
    """Pairs of an expected track and a detection."""
    compared: int = 0
    """Pairs whose costs were computed; the search areas spared the others."""
    unmeasured: int = 0
    """Costs of single cues that were NaN: the cue was missing."""
    stages: Mapping[str, float] = field(default_factory=dict)
    """Seconds of `seconds` spent on cues in images, by the names of `tracker.front_end.STAGES`."""
    contradiction: str | None = None
    """What the boxes contradict in the given motion or calibration; None: nothing."""
    ego_scale: Mapping[str, float] = field(default_factory=dict)
    """`factor`, metres per unit of the odometry at the end of the drive, and `low` and `high` of
    its 95 % interval; empty: not estimated, or not found out."""


@dataclass(eq=False)
class RunFolder(TextPartsFolder):
    """Results that appear sequence by sequence, each file as a whole; see `ResumableFolder`."""

    FILE = RUN_FILE
    PARTS = "sequences"
    STRANGE = "no run of ours"
    DAMAGED = "not a run of ours"
    STANDS = "holds a run already; --resume does its rest, --overwrite replaces it"

    finished: dict[str, SequenceStatistics] = field(default_factory=dict)
    """The sequences whose results are in the folder, by name."""

    @classmethod
    def parse(cls, told: Any, file: Path) -> dict[str, SequenceStatistics]:
        """The finished sequences that a `run.json` names."""
        parts = {name: _counts(part) for name, part in told.items()}
        for name in parts:
            if Path(name).name != name or not name.isprintable() or len(name) > MAX_NAME_LETTERS:
                what = f"a sequence is named like a path: {name!r:.80}"
                raise BadFile(f"{file}: {what}; choose another folder")
        return parts

    def add(
        self,
        name: str,
        tracks: Tracks,
        counts: SequenceStatistics,
        T_road_label: Float[Array, "4 4"] | None = None,
    ) -> None:
        """Keep a finished sequence: both files appear as a whole, the results last."""
        self.finished[name] = counts
        try:
            self.write()
            write_results(tracks, self.result(name), T_road_label)
        except BaseException:
            del self.finished[name]
            estimates_path(self.result(name)).unlink(missing_ok=True)
            raise

    def remove(self, name: str) -> None:
        """Remove the results of a sequence."""
        super().remove(name)
        estimates_path(self.result(name)).unlink(missing_ok=True)

    def describe(self) -> tuple[bool, dict[str, Any]]:
        """Whether all sequences are finished, and what is known of each."""
        sequences = {name: asdict(counts) for name, counts in self.finished.items()}
        return set(self.wanted) <= sequences.keys(), dict(sorted(sequences.items()))


def root_of_run(folder: Path) -> Path | None:
    """The tree that a folder of results was made from, as its `run.json` says; None: unknown."""
    try:
        return Path(json.loads((folder / RUN_FILE).read_text())["settings"]["root"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _counts(told: Any) -> SequenceStatistics:
    """The counts that a JSON file tells. Raises ValueError and TypeError for what are none."""
    numbers = {**told, **told.get("stages", {}), **told.get("ego_scale", {})}
    numbers.pop("stages", None)
    numbers.pop("ego_scale", None)
    words = numbers.pop("contradiction", None)
    if not isinstance(words, str | None):
        raise TypeError(f"contradiction is {words!r:.80}")
    for name, value in numbers.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 2**53:
            raise ValueError(f"{name} is {value!r:.80}")
    wholes = [each.name for each in fields(SequenceStatistics) if each.type is int]
    return SequenceStatistics(
        **{**told, **{name: int(told[name]) for name in wholes if name in told}}
    )
