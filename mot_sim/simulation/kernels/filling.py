"""Filling triangles: at each pixel's centre the nearest one, and the inverse of its depth."""

from math import inf

import numpy as np

from mot_sim.simulation.kernels.compiling import OUT_F32_1, OUT_I32_1
from tracker.kernels.compiling import B1, F2, F3, INT, inlined, kernel

PIXELS = 16  # of a row that are filled at once; an image has so many more at its end
TINY_AREA = 1e-9  # pixels^2, twice a triangle's: what is smaller is taken for a line


@inlined
def fill_triangle(corners, K, box, base, nearness, numbers, number):
    """Fill a triangle of the camera's frame into a crop of the image.

    box: the crop's first column and row, last ones plus one. Where the triangle is nearer than what
    is there, nearness, 1 / m, becomes its own, and numbers, if there are any, `number`; of equal
    depths the first that was filled counts. Both hold the crop's rows one after the other from
    `base` on. Centres on its edges belong to it, so that no gap is between two triangles: an
    edge's sums begin at its upper end in both.
    """
    left, top, columns, rows = box[0], box[1], box[2] - box[0], box[3] - box[1]
    wa, wb, wc = 1.0 / corners[0, 2], 1.0 / corners[1, 2], 1.0 / corners[2, 2]
    va = (K[1, 0] * corners[0, 0] + K[1, 1] * corners[0, 1]) * wa + K[1, 2]
    vb = (K[1, 0] * corners[1, 0] + K[1, 1] * corners[1, 1]) * wb + K[1, 2]
    vc = (K[1, 0] * corners[2, 0] + K[1, 1] * corners[2, 1]) * wc + K[1, 2]
    first = max(np.ceil(min(va, vb, vc)), top)
    last = min(np.floor(max(va, vb, vc)), top + rows - 1.0)
    if not first <= last:
        return
    ua = (K[0, 0] * corners[0, 0] + K[0, 1] * corners[0, 1]) * wa + K[0, 2]
    ub = (K[0, 0] * corners[1, 0] + K[0, 1] * corners[1, 1]) * wb + K[0, 2]
    uc = (K[0, 0] * corners[2, 0] + K[0, 1] * corners[2, 1]) * wc + K[0, 2]
    farthest = left + columns - 1.0
    if not max(np.ceil(min(ua, ub, uc)), left) <= min(np.floor(max(ua, ub, uc)), farthest):
        return
    # From the uppermost corner to the lowest.
    if vb < va:
        ua, va, wa, ub, vb, wb = ub, vb, wb, ua, va, wa
    if vc < vb:
        ub, vb, wb, uc, vc, wc = uc, vc, wc, ub, vb, wb
        if vb < va:
            ua, va, wa, ub, vb, wb = ub, vb, wb, ua, va, wa
    area = (ub - ua) * (vc - va) - (uc - ua) * (vb - va)
    if not TINY_AREA <= abs(area) < inf:
        return
    across = ((wb - wa) * (vc - va) - (wc - wa) * (vb - va)) / area
    down = ((ub - ua) * (wc - wa) - (uc - ua) * (wb - wa)) / area
    whole = (uc - ua) / (vc - va)
    upper = (ub - ua) / (vb - va) if vb > va else 0.0
    lower = (uc - ub) / (vc - vb) if vc > vb else 0.0
    for row in range(int(first), int(last) + 1):
        one = ua + (row - va) * whole
        other = ua + (row - va) * upper if row < vb else ub + (row - vb) * lower
        start = max(np.ceil(min(one, other)), left)
        end = min(np.floor(max(one, other)), farthest)
        if not start <= end:
            continue
        begun, begin, stop = wa + (row - va) * down, int(start) - left, int(end) - left + 1
        place = base + (row - top) * columns + begin
        # (So many pixels at once, whatever is left, cost less than a loop over few.)
        while begin < stop:
            near, left_over, column = nearness[place : place + PIXELS], stop - begin, begin + left
            if numbers is None:
                for each in range(PIXELS):
                    value = np.float32(begun + (float(each + column) - ua) * across)
                    is_nearer = (value > near[each]) & (each < left_over)
                    near[each] = value if is_nearer else near[each]
            else:
                found = numbers[place : place + PIXELS]
                for each in range(PIXELS):
                    value = np.float32(begun + (float(each + column) - ua) * across)
                    is_nearer = (value > near[each]) & (each < left_over)
                    near[each] = value if is_nearer else near[each]
                    found[each] = number if is_nearer else found[each]
            begin, place = begin + PIXELS, place + PIXELS


@kernel(
    F3, F2, B1, INT, INT, OUT_F32_1, OUT_I32_1, OUT_F32_1, OUT_I32_1, allocates=False
)  # fmt: skip
def fill_triangles(
    corners, K, leaves, width, height, nearness, numbers, nearness_leaves, numbers_leaves
):  # fmt: skip
    """Fill all triangles into an image; numbers become 1 + their rows, the first of equal ones'.

    Those that are leaves into an image of their own. Rows stand one after the other, PIXELS more
    at the end.
    """
    image = 0, 0, width, height
    for triangle in range(len(corners)):
        near, found = nearness, numbers
        if leaves[triangle]:
            near, found = nearness_leaves, numbers_leaves
        fill_triangle(corners[triangle], K, image, 0, near, found, np.int32(triangle + 1))
