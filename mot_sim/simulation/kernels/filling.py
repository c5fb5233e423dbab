"""Filling triangles: at each pixel's centre the nearest one, and the inverse of its depth."""

from math import inf

import numpy as np

from mot_sim.simulation.kernels.compiling import OUT_F32_2, OUT_I32_2
from tracker.kernels.compiling import B1, F2, F3, inlined, kernel

TINY_AREA = 1e-9  # pixels^2, twice a triangle's: what is smaller is taken for a line


@inlined
def fill_triangle(corners, K, left, top, nearness, numbers, number):
    """Fill a triangle of the camera's frame into a crop of the image that begins at left, top.

    Where it is nearer than what is there, nearness (r, c), 1 / m, becomes its own, and numbers,
    if there are any, `number`; of equal depths the first that was filled counts. Centres on its
    edges belong to it, so that no gap is between two triangles: an edge's sums begin at its upper
    end in both.
    """
    wa, wb, wc = 1.0 / corners[0, 2], 1.0 / corners[1, 2], 1.0 / corners[2, 2]
    va = (K[1, 0] * corners[0, 0] + K[1, 1] * corners[0, 1]) * wa + K[1, 2]
    vb = (K[1, 0] * corners[1, 0] + K[1, 1] * corners[1, 1]) * wb + K[1, 2]
    vc = (K[1, 0] * corners[2, 0] + K[1, 1] * corners[2, 1]) * wc + K[1, 2]
    rows, columns = nearness.shape
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
        # (Loops over views from 0 on are done for several pixels at once.)
        near = nearness[row - top, begin:stop]
        if numbers is None:
            for each in range(len(near)):
                value = np.float32(begun + (float(each + int(start)) - ua) * across)
                near[each] = value if value > near[each] else near[each]
        else:
            found = numbers[row - top, begin:stop]
            for each in range(len(near)):
                value = np.float32(begun + (float(each + int(start)) - ua) * across)
                is_nearer = value > near[each]
                near[each] = value if is_nearer else near[each]
                found[each] = number if is_nearer else found[each]


@kernel(F3, F2, B1, OUT_F32_2, OUT_I32_2, OUT_F32_2, OUT_I32_2, allocates=False)
def fill_triangles(corners, K, leaves, nearness, numbers, nearness_leaves, numbers_leaves):
    """Fill all triangles into an image; numbers become 1 + their rows, the first of equal ones'.

    Those that are leaves into an image of their own.
    """
    for triangle in range(len(corners)):
        near, found = nearness, numbers
        if leaves[triangle]:
            near, found = nearness_leaves, numbers_leaves
        fill_triangle(corners[triangle], K, 0, 0, near, found, np.int32(triangle + 1))
