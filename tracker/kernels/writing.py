"""The rows that are put out for the tracks of a frame."""

from math import isfinite, isnan, nan

from tracker.kernels.compiling import A1, B1, F1, FLOAT, I1, INT, OUT1, OUT_B1, OUT_I1, kernel
from tracker.kernels.existing import is_in_view, is_likely
from tracker.kernels.tables import belief_columns, moment_columns

# What decides whether a track is put out: the caller, `is_likely`, or that it was detected.
GIVEN, LIKELY, DETECTED = 0, 1, 2


@kernel(
    F1, I1, INT, FLOAT, INT, FLOAT, FLOAT, B1, F1, B1, A1, F1, FLOAT, INT, F1, OUT_B1, OUT1,
    OUT_I1, allocates=False,
)  # fmt: skip
def write_rows(
    floats, ints, n, since_look, rule, lifetime, threshold, unseen, likely, chosen, depth_of, far,
    min_depth, frame, cuboids, written, numbers, whole,
):  # fmt: skip
    """The rows that packed tracks are put out with; how many. written: which tracks have one.

    rule: 0 those that are `written`, 1 as `ExistenceFilter.written`, 2 those detected. Of the
    tracks that are `unseen`, if these are told, others decided: their scores are `likely`, those
    `chosen` are written. A predicted box is clipped to the image; its score, unless so told, is
    that the track exists (NaN without a filter of existence). cuboids: packed, as rows state them.
    numbers: boxes, scores, packed cuboids. whole: frames, ids.
    """
    beliefs, (since, existence, _, scores) = belief_columns(floats, n), moment_columns(floats, n)
    base, boxes, told, count = beliefs[0], beliefs[5], 0, 0
    for row in range(n):
        if len(unseen) and unseen[row]:
            written[row] = chosen[told]
            told += 1
        elif rule == LIKELY:
            of_track = existence[row], ints[n + row], since[row]
            written[row] = is_likely(of_track, lifetime, threshold, since_look)
        elif rule == DETECTED:
            is_seen = since[row] <= since_look if since_look > 0.0 else not isnan(scores[row])
            written[row] = is_seen
        if since_look > 0.0 and written[row]:
            written[row] = is_in_view(base[row], boxes[row], depth_of, far, min_depth)
        count += written[row]
    out_boxes, out_scores = numbers[: 4 * count].reshape((count, 4)), numbers[4 * count :]
    out_cuboids, at, told = numbers[5 * count :], 0, 0
    for row in range(n):
        is_told, is_missed = len(unseen) > 0 and unseen[row], isnan(scores[row])
        if written[row]:
            for side in range(4):
                edge = boxes[row, side]
                out_boxes[at, side] = min(max(edge, 0.0), far[side]) if is_missed else edge
            by_filter = existence[row] if is_missed and rule != DETECTED else scores[row]
            out_scores[at] = likely[told] if is_told else by_filter
            for axis in range(3):
                out_cuboids[3 * at + axis] = cuboids[3 * row + axis]
                out_cuboids[4 * count + 3 * at + axis] = cuboids[4 * n + 3 * row + axis]
            out_cuboids[3 * count + at] = cuboids[3 * n + row]
            whole[at], whole[count + at] = frame, ints[row]
            at += 1
        told += is_told
    return count


@kernel(F1, INT, F1, A1, OUT1, allocates=False)
def keep_measured(beliefs, n, mean_size, yaws, cuboids):
    """Packed cuboids of packed beliefs; NaN for sizes and headings that nothing measured.

    mean_size: what is assumed. yaws: as measured, or none.
    """
    for number in range(7 * n):
        cuboids[number] = beliefs[number]
    for row in range(n):
        is_assumed, size = True, 4 * n + 3 * row
        for axis in range(3):
            is_assumed = is_assumed and beliefs[size + axis] == mean_size[axis]
        if is_assumed:
            for axis in range(3):
                cuboids[size + axis] = nan
            if not (len(yaws) and isfinite(yaws[row])):
                cuboids[3 * n + row] = nan
