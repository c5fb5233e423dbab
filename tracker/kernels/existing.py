"""Whether tracks exist, by their hits and misses, and what those tell of the detector."""

from math import exp, isnan

import numpy as np

from tracker.kernels.compiling import (
    A1,
    A2,
    A_I1,
    F1,
    F2,
    FLOAT,
    I1,
    OUT1,
    OUT_B1,
    OUT_I1,
    OUT_I2,
    inlined,
    kernel,
)  # fmt: skip


@inlined
def share_covered(box, others):
    """The largest share of a box that one of the others, ending lower (nearer), covers."""
    most = 0.0
    area = max(box[2] - box[0], 0.0) * max(box[3] - box[1], 0.0)
    for row in range(len(others)):
        if others[row, 3] > box[3]:
            wide = max(min(box[2], others[row, 2]) - max(box[0], others[row, 0]), 0.0)
            high = max(min(box[3], others[row, 3]) - max(box[1], others[row, 1]), 0.0)
            most = max(most, wide * high / max(area, 1e-6))
    return min(most, 1.0)


@inlined
def learn_detector(seen, lost, covered, before, one_step, limits, right, learned):
    """Count what hits and misses tell: hits, tries, confirmed and newborns.

    seen, lost: hits and seconds unseen of tracks; of those lost the boxes, too.
    """
    hits = misses = confirmed = vanished = 0
    seen_hits, seen_since = seen
    for row in range(len(seen_hits)):
        hits += int(seen_hits[row] >= limits[0])
        confirmed += int(seen_hits[row] == 1 and seen_since[row] <= one_step)
    lost_hits, lost_since, boxes = lost
    for row in range(len(lost_hits)):
        is_plain = lost_since[row] <= one_step and covered[row] < limits[1]
        if is_plain and boxes[row, 0] >= limits[2] and boxes[row, 2] <= right:
            misses += int(lost_hits[row] >= limits[0])
            vanished += int(lost_hits[row] == 1)
    learned[0], learned[1] = before[0] + hits, before[1] + hits + misses
    learned[2], learned[3] = before[2] + confirmed, before[3] + confirmed + vanished


@kernel(
    F1, I1, F1, F1, F1, I1, F1, F2, F1, A2, I1, F1, FLOAT, F1, FLOAT, OUT1, OUT1, OUT1, OUT_I1
)  # fmt: skip
def judge_existence(
    existence, hits, since, scores, lost_existence, lost_hits, lost_since, lost_boxes, born, boxes,
    before, settings, one_step, limits, right, hit, missed, fresh, learned,
):  # fmt: skip
    """Probabilities of tracks that were detected, of others, of newborns; what was learned.

    settings: of `ExistenceFilter`, in its order. one_step: seconds that a track skipped no frame
    in. limits: hits of a known track, most covered share, margin of the border, largest
    probability. right: where that margin begins, px.
    """
    for row in range(len(lost_boxes)):
        missed[row] = share_covered(lost_boxes[row], boxes)  # for now
    seen, lost = (hits, since), (lost_hits, lost_since, lost_boxes)
    learn_detector(seen, lost, missed, before, one_step, limits, right, learned)
    detected = (learned[0] + settings[0] * settings[1]) / (learned[1] + settings[1])
    confirmed = learned[2] + settings[2] * settings[3]
    worth = min(1.0, confirmed / (learned[3] + settings[3]) / max(detected, 0.5))
    for row in range(len(hit)):
        score = max(scores[row], 0.0)
        odds = existence[row] / (1.0 - existence[row]) * (settings[4] * score)
        hit[row] = min(max(odds / (1.0 + odds), min(score * worth, limits[3])), limits[3])
    for row in range(len(missed)):
        not_found, before_miss = 1.0 - detected * (1.0 - missed[row]), lost_existence[row]
        missed[row] = before_miss * not_found / (1.0 - before_miss * (1.0 - not_found))
    for row in range(len(fresh)):
        fresh[row] = min(max(born[row], 0.0) * worth, limits[3])


@kernel(
    F1, I1, F1, F2, A_I1, A_I1, A_I1, A1, A_I1, A2, I1, F1, FLOAT, F1, FLOAT, OUT1, OUT1, OUT_I1
)  # fmt: skip
def judge_rows(
    existence, hits, since, expected, rows, columns, missed, scores, born, boxes, before, settings,
    one_step, limits, right, after, fresh, learned,
):  # fmt: skip
    """`judge_existence` of tracks by their rows: `after` (n,) of all, `fresh` of newborns.

    expected: predicted boxes (n, 4). rows, columns: who was detected by which detection; missed:
    who was not. scores, boxes: of all detections; born: those that begin tracks.
    """
    k, lost, begun = len(rows), len(missed), len(born)
    seen, gone = np.empty((4, k)), np.empty((3, lost))
    seen_hits, gone_hits = np.empty(k, np.int64), np.empty(lost, np.int64)
    gone_boxes, born_scores = np.empty((lost, 4)), np.empty(begun)
    for at in range(k):
        row, seen[2, at] = rows[at], scores[columns[at]]
        seen[0, at], seen[1, at], seen_hits[at] = existence[row], since[row], hits[row]
    for at in range(lost):
        row = missed[at]
        gone[0, at], gone[1, at], gone_hits[at] = existence[row], since[row], hits[row]
        for side in range(4):
            gone_boxes[at, side] = expected[row, side]
    for at in range(begun):
        born_scores[at] = scores[born[at]]
    judge_existence(
        seen[0], seen_hits, seen[1], seen[2], gone[0], gone_hits, gone[1], gone_boxes, born_scores,
        boxes, before, settings, one_step, limits, right, seen[3], gone[2], fresh, learned,
    )  # fmt: skip
    for row in range(len(after)):
        after[row] = existence[row]
    for at in range(k):
        after[rows[at]] = seen[3, at]
    for at in range(lost):
        after[missed[at]] = gone[2, at]


@kernel(
    F1, I1, F1, F1, I1, F1, I1, F1, F2, I1, F1, I1, F2, I1, F1, F1, F1, FLOAT, OUT1, OUT1, OUT1,
    OUT_I2,
)  # fmt: skip
def judge_each(
    existence, hits, since, scores, starts, lost_existence, lost_hits, lost_since, lost_boxes,
    lost_starts, born, born_starts, boxes, box_starts, settings, one_steps, limits, right, hit,
    missed, fresh, learned,
):  # fmt: skip
    """`judge_existence` of every drive; one_steps, learned: of drives, the latter renewed."""
    for drive in range(len(starts) - 1):
        a, b = starts[drive], starts[drive + 1]
        c, d = lost_starts[drive], lost_starts[drive + 1]
        e, f = born_starts[drive], born_starts[drive + 1]
        beside = boxes[box_starts[drive] : box_starts[drive + 1]]
        judge_existence(
            existence[a:b], hits[a:b], since[a:b], scores[a:b], lost_existence[c:d],
            lost_hits[c:d], lost_since[c:d], lost_boxes[c:d], born[e:f], beside, learned[drive],
            settings, one_steps[drive], limits, right, hit[a:b], missed[c:d], fresh[e:f],
            learned[drive],
        )  # fmt: skip


@inlined
def is_likely(track, lifetime, threshold, since_look):
    """Whether a track is put out: its probability of existence, hits and seconds unseen."""
    existence, hits, since = track
    is_established = hits > 1 or since <= since_look
    return existence * exp(since * (-1.0 / lifetime)) >= threshold and is_established


@kernel(F1, I1, F1, FLOAT, FLOAT, FLOAT, OUT_B1)
def choose_written(existence, hits, since, lifetime, threshold, since_look, written):
    """Which tracks are put out, see `ExistenceFilter.written`."""
    for row in range(len(written)):
        track = existence[row], hits[row], since[row]
        written[row] = is_likely(track, lifetime, threshold, since_look)


@inlined
def is_in_view(place, box, depth_of, far, min_depth):
    """Whether a box lies in the image, and its place before the camera."""
    depth = place[0] * depth_of[0] + place[1] * depth_of[1] + place[2] * depth_of[2] + depth_of[3]
    across = box[2] > 0.0 and box[0] < far[0]
    return across and box[3] > 0.0 and box[1] < far[1] and depth > min_depth


@kernel(A2, A2, A1, F1, FLOAT, OUT_B1)
def see_beliefs(base, boxes, depth_of, far, min_depth, seen):
    """Which beliefs lie in view, see `in_view`."""
    for row in range(len(base)):
        seen[row] = is_in_view(base[row], boxes[row], depth_of, far, min_depth)


@kernel(A2, A2, A1, F1, FLOAT, F1, F1, FLOAT, OUT_B1)
def keep_living(base, boxes, depth_of, far, min_depth, since, scores, max_gap, alive):
    """Which tracks live on: those with a score, or unseen for `max_gap` s at most and in view."""
    for row in range(len(base)):
        is_recent = since[row] <= max_gap
        is_recent = is_recent and is_in_view(base[row], boxes[row], depth_of, far, min_depth)
        alive[row] = is_recent or not isnan(scores[row])
