"""Which rows MOTChallenge counts (Milan et al., arXiv 1603.00831), as TrackEval 1.3.0 applies it.

Labels of a class count where their column `conf` is not 0. Output that matches a distractor
leaves; nothing else is ignored: neither small boxes nor occluded ones. MOTChallenge scores
pedestrians; other classes of MOT16's list go by the same rules.
"""

import numpy as np
from jaxtyping import Bool, Int
from numpy import ndarray as Array

from mot_sim.metrics.clear import clear_scores
from mot_sim.metrics.evaluation import Scores
from mot_sim.metrics.hota import hota_scores
from mot_sim.metrics.identity import identity_scores
from mot_sim.metrics.matching import EPSILON, Overlaps, bare_rows, match
from mot_sim.metrics.preprocessing import MIN_OVERLAP, checked_columns, kind_is
from tracker.errors import BadTracks, UnknownName
from tracker.types import MOT_CLASSES, TRACKED_KINDS, Tracks

# Persons on vehicles, persons who do not move, distractors, reflections.
MOT_DISTRACTORS = (2, 7, 8, 12)


def motchallenge_scores(
    truth: Tracks,
    classes: Int[Array, " n"],
    counted: Bool[Array, " n"],
    output: Tracks,
    frame_count: int,
    kind: str = "Pedestrian",
) -> Scores:
    """CLEAR, HOTA and Identity of one sequence by MOTChallenge's rules.

    truth: all labels. classes: MOT16's number of each; all 1 (MOT15) for labels without. counted:
    which labels are marked to be considered (`conf` not 0). output: all rows without kinds, or of
    this kind, count. kind: of TRACKED_KINDS. Frames count from 0. Raises UnknownName for the kind,
    BadTracks for columns of other lengths, and as `evaluate_sequence`.
    """
    if kind not in TRACKED_KINDS:
        raise UnknownName.of("class", kind, TRACKED_KINDS)
    if not len(truth) == len(classes) == len(counted):
        raise BadTracks(
            f"{len(truth)} labels, {len(classes)} classes and {len(counted)} marks: one each"
        )
    truth, output = checked_columns(truth, "truth"), checked_columns(output, "output")
    output = output.select(kind_is(output, kind, True))
    order = np.argsort(truth.frames, kind="stable")
    number = MOT_CLASSES[kind]
    overlaps = Overlaps.between(
        bare_rows(truth, np.ones(len(truth), bool), frame_count, "truth"),
        bare_rows(output, np.ones(len(output), bool), frame_count, "output"),
    )
    distractor = np.isin(classes[order], [other for other in MOT_DISTRACTORS if other != number])
    kept = np.ones(len(output), dtype=bool)
    near = np.flatnonzero(overlaps.iou >= MIN_OVERLAP - EPSILON)
    matched = match(overlaps, near, overlaps.iou[near])
    kept[overlaps.columns[matched]] = ~distractor[overlaps.rows[matched]]
    scored = overlaps.keep(counted[order] & (classes[order] == number), kept)
    return Scores(
        clear=clear_scores(scored, frame_count),
        hota=hota_scores(scored),
        identity=identity_scores(scored),
    )
