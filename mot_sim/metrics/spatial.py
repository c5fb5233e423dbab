"""All scores in 3D of one sequence, or of several together: by AB3DMOT, by ours, and errors."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.metrics.ab3dmot import Ab3dmot, RecallSweep
from mot_sim.metrics.clear import Number
from mot_sim.metrics.cuboid_errors import CuboidErrors, cuboid_errors
from mot_sim.metrics.cuboid_overlap import Criterion
from mot_sim.metrics.cuboid_preparation import PreparedCuboids, end_to_end, prepare_cuboids
from mot_sim.metrics.devkit2018 import Devkit2018
from mot_sim.metrics.hota import Hota, hota_scores
from tracker.types import Tracks

# AB3DMOT's thresholds, and the distance of nuScenes.
CRITERIA = (
    Criterion("iou", 0.25), Criterion("iou", 0.5), Criterion("iou", 0.7), Criterion("distance", 2.0)
)  # fmt: skip
AB3DMOT_SCORES = (
    "sAMOTA", "AMOTA", "AMOTP", "MOTA", "MOTP", "CLR_Re", "CLR_Pr", "CLR_TP", "CLR_FP", "CLR_FN",
    "IDSW", "Frag", "MTR", "PTR", "MLR",
)  # fmt: skip
HOTA_SCORES_3D = ("HOTA", "DetA", "AssA", "LocA")


@dataclass(frozen=True, eq=False)
class SpatialScores:
    """Scores in 3D; `numbers()` names them: `sAMOTA@0.25`, `MOTA3D@2m`, `HOTA3D`, errors."""

    prepared: PreparedCuboids
    """What is scored; it is swept again when sequences are combined."""
    hota: Hota
    """HOTA over the 3D IoU, of the rows that count in 2D."""
    errors: CuboidErrors
    """What is wrong with the cuboids that meet a label in the image."""
    criteria: tuple[Criterion, ...] = CRITERIA
    """What makes a match, one after the other."""

    @cached_property
    def ab3dmot(self) -> dict[str, Ab3dmot]:
        """AB3DMOT's scores by the criterion's name."""
        return {name: sweep.scores() for name, sweep in self._sweeps.items()}

    @cached_property
    def _sweeps(self) -> dict[str, RecallSweep]:
        """The pairs that may match, by the criterion's name."""
        return {each.name: RecallSweep.of(self.prepared, each) for each in self.criteria}

    @cached_property
    def clear(self) -> dict[str, Devkit2018]:
        """CLEAR of all tracks by the criterion's name.

        Unlike AB3DMOT: what matches a neutral label in the image is no false positive, wherever
        its cuboid stands.
        """
        lenient = self.prepared.lenient()
        return {
            name: replace(sweep, prepared=lenient).level()[0].counts
            for name, sweep in self._sweeps.items()
        }

    @classmethod
    def combine(cls, parts: Sequence["SpatialScores"]) -> "SpatialScores":
        """The scores of all sequences together, as of one data set."""
        return cls(
            end_to_end([part.prepared for part in parts]),
            Hota.combine([part.hota for part in parts]),
            CuboidErrors.concatenate([part.errors for part in parts]),
            parts[0].criteria,
        )

    def numbers(self) -> dict[str, Number]:
        """Every score by its name; NaN for what nothing is known of."""
        found: dict[str, Number] = {}
        for name, scores in self.ab3dmot.items():
            numbers = scores.numbers()
            found |= {f"{score}@{name}": numbers[score] for score in AB3DMOT_SCORES}
            found[f"MOTA3D@{name}"] = self.clear[name].MOTA
        whole = self.hota.numbers()
        return found | {f"{name}3D": whole[name] for name in HOTA_SCORES_3D} | self.errors.numbers()

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers and lists for JSON: AB3DMOT with its levels, and errors by distance."""
        return {
            "ab3dmot": {name: scores.as_dict() for name, scores in self.ab3dmot.items()},
            "clear": {name: counts.numbers() for name, counts in self.clear.items()},
            "hota": {name: self.hota.numbers()[name] for name in HOTA_SCORES_3D},
            "errors": _without_nan(self.errors.numbers()),
            "errors_by_distance": {
                name: _without_nan(errors.numbers()) for name, errors in self.errors.by_distance()
            },
        }


def _without_nan(numbers: dict[str, Number]) -> dict[str, Number | None]:
    """JSON knows no NaN."""
    return {name: None if np.isnan(number) else number for name, number in numbers.items()}


def spatial_scores(
    truth: Tracks,
    output: Tracks,
    frame_count: int,
    Ts_world_road: Float[Array, "m 4 4"] | None = None,
    frame_rate: float = 10.0,
    criteria: Sequence[Criterion] = CRITERIA,
    kind: str = "Car",
) -> SpatialScores:
    """The scores in 3D of one sequence; cuboids of both in the road frame of the row's frame.

    Ts_world_road: for each frame where the road frame stands in a fixed world; without it nobody
    knows which cars move. Raises BadTracks for rows that cannot be scored.
    """
    prepared = prepare_cuboids(truth, output, frame_count, kind)
    by_volume = prepared.scored_in_image(prepared.overlaps(Criterion("iou", 0.5)))
    return SpatialScores(
        prepared,
        hota_scores(by_volume),
        cuboid_errors(truth, output, frame_count, Ts_world_road, frame_rate, kind=kind),
        tuple(criteria),
    )
