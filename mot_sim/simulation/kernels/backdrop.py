"""The road below the horizon, with the shadows on it; which picture of it each row shows."""

from math import hypot, inf, sqrt

import numpy as np

from mot_sim.simulation.kernels.compiling import I32_2, OUT_I32_2, OUT_U8_2, OUT_U8_3, U8_2, U8_3
from tracker.kernels.compiling import (
    BOOL,
    F1,
    F2,
    F3,
    FLOAT,
    I1,
    INT,
    OUT_B1,
    OUT_I1,
    inlined,
    kernel,
)


@kernel(
    U8_3, U8_2, U8_2, U8_2, U8_2, INT, INT, INT, INT, BOOL, I32_2, I32_2, OUT_U8_3, OUT_U8_2,
    allocates=False,
)  # fmt: skip
def lay_ground(
    rgba, below, dark, closed, light, first, copied, road, ground, everywhere, numbers, spans,
    image, semantics,
):  # fmt: skip
    """Lay the road (r, w, 4), from row `first` on, over the sky, where the plane is below.

    dark: how much of the sun shadows take at each pixel; closed: how much of the sky what stands
    there hides, 255 = all. light (256, 256): what is left under both, 255 of all. road and ground:
    ids of what is painted, alpha over 127, and of what is around. numbers: over 0 where something
    else is seen, which stays, unless everywhere; ids are written where they are 0. spans (h, 2):
    the columns from where to where the road is given. From row `copied` on the image shows the road
    already.
    """
    for row in range(first, image.shape[0]):
        begin, end = spans[row, 0], max(spans[row, 0], spans[row, 1])
        drawn, colours, kinds = (
            rgba[row - first, begin:end], image[row, begin:end], semantics[row, begin:end]
        )  # fmt: skip
        plane, found = below[row, begin:end], numbers[row, begin:end]
        shadows, shut = dark[row, begin:end], closed[row, begin:end]
        for column in range(len(found)):
            number = found[column]
            if plane[column] == 0 or (number > 0 and not everywhere):
                continue
            if number == 0:
                kinds[column] = road if drawn[column, 3] > 127 else ground
            if shadows[column] | shut[column] > 0:
                left = np.int32(light[shadows[column], shut[column]])
                for band in range(3):
                    # (Rounded to the nearest; two are never equally near.)
                    value = np.int32(drawn[column, band]) * left
                    colours[column, band] = np.uint32(2 * value + 255) // np.uint32(510)
            elif row < copied:
                for band in range(3):
                    colours[column, band] = drawn[column, band]


@inlined
def narrow_span(slope, offset, start, end):
    """A span of columns, cut to where slope * u + offset >= 0."""
    if slope > 0.0:
        return max(start, -offset / slope), end
    if slope < 0.0:
        return start, min(end, -offset / slope)
    return start, start - 1.0 if offset < 0.0 else end


@inlined
def hidden_sky(x, z, half_x, half_z, height, clearance):
    """How much of the sky a box on the road hides at a place on the road, 0 to 1.

    Beside a long wall that is half of it, less by the distance; beneath the box nearly all.
    """
    out_x, out_z = abs(x) - half_x, abs(z) - half_z
    inside = -max(out_x, out_z)
    if inside > 0.0:
        return 0.5 + 0.5 * inside / sqrt(inside * inside + clearance * clearance)
    out_x, out_z = max(out_x, 0.0), max(out_z, 0.0)
    apart = out_x * out_x + out_z * out_z
    return 0.5 * (1.0 - sqrt(apart / (apart + height * height)))


@kernel(F3, F2, FLOAT, FLOAT, INT, I32_2, OUT_U8_2, allocates=False)
def close_sky(As_object_image, sizes, clearance, reach, first, numbers, closed):
    """Write how much of the sky boxes on the road hide at each pixel from row `first` on.

    Only where numbers are not over 0. As_object_image (n, 3, 3) lead from pixels to x and z of the
    boxes' frames; sizes (n, 3): half a box along x and z, and its height, metres. reach: metres
    beside a box. The darkest counts.
    """
    height, width = closed.shape
    for box in range(len(sizes)):
        A, half_x, half_z, high = As_object_image[box], sizes[box, 0], sizes[box, 1], sizes[box, 2]
        least = hidden_sky(half_x + reach, 0.0, half_x, half_z, high, clearance)
        for row in range(first, height):
            v = float(row)
            w0, w1 = A[2, 0], A[2, 1] * v + A[2, 2]
            start, end = narrow_span(w0, w1 - 1e-9, 0.0, width - 1.0)
            for axis in range(2):
                limit = (half_x if axis == 0 else half_z) + reach
                a0, a1 = A[axis, 0], A[axis, 1] * v + A[axis, 2]
                start, end = narrow_span(limit * w0 - a0, limit * w1 - a1, start, end)
                start, end = narrow_span(limit * w0 + a0, limit * w1 + a1, start, end)
            if not start <= end:
                continue
            for column in range(int(np.ceil(start)), int(np.floor(end)) + 1):
                if numbers[row, column] > 0:
                    continue
                w = w0 * column + w1
                x, z = (A[0, 0] * column + A[0, 1] * v + A[0, 2]) / w, 0.0
                z = (A[1, 0] * column + A[1, 1] * v + A[1, 2]) / w
                hidden = hidden_sky(x, z, half_x, half_z, high, clearance) - least
                value = np.uint8(max(255.0 * min(hidden / (1.0 - least), 1.0), 0.0))
                closed[row, column] = max(closed[row, column], value)


@inlined
def texel(A, u, v):
    """Where a pixel lies in a picture."""
    depth = A[2, 0] * u + A[2, 1] * v + A[2, 2]
    return (
        (A[0, 0] * u + A[0, 1] * v + A[0, 2]) / depth,
        (A[1, 0] * u + A[1, 1] * v + A[1, 2]) / depth,
    )


@inlined
def is_inside(point, size):
    """Whether a point lies in a picture, not on its last half texels."""
    return 0.0 <= point[0] <= size[0] - 1.0 and 0.0 <= point[1] <= size[1] - 1.0


@kernel(F3, F2, F1, F1, INT, INT, FLOAT, INT, FLOAT, OUT_I1, OUT_I1)
def choose_pictures(
    As_texture_image, sizes, reaches, deepest, first, width, max_skip, max_finer, enough, chosen,
    finer,
):  # fmt: skip
    """Which picture, from fine to coarse, each row from `first` on shows, and how much higher.

    As_texture_image (k, 3, 3) lead to pictures of sizes (k, 2), shown up to depths `reaches`;
    deepest: the depth of each row. A picture is taken where its pixels are at least `enough`
    texels wide, the last one everywhere; a row is drawn so many times higher, up to max_finer,
    that no more than max_skip texels lie between two.
    """
    rows, last, middle = len(chosen), len(sizes) - 1, 0.5 * width
    sharp = np.zeros(rows, np.bool_)
    for picture in range(last, -1, -1):
        A, steepest = As_texture_image[picture], 1
        for row in range(rows - 1, -1, -1):
            v = float(first + row)
            here, below = texel(A, middle, v), texel(A, middle, v + 1.0)
            beside = texel(A, middle + 1.0, v)
            along = hypot(below[0] - here[0], below[1] - here[1])
            across = hypot(beside[0] - here[0], beside[1] - here[1])
            while steepest < max_finer and along > max_skip * steepest:
                steepest *= 2  # from the bottom up it never falls
            inside = deepest[row] <= reaches[picture] or reaches[picture] == inf
            for u in (-0.5, width - 0.5):
                for each in (v, v + 1.0):
                    inside = inside and is_inside(texel(A, u, each), sizes[picture])
            if picture == last or (inside and not sharp[row]):
                chosen[row], finer[row] = picture, steepest
                sharp[row] = sharp[row] or across >= enough


@kernel(F2, INT, OUT_B1, allocates=False)
def mark_tiles(outline, count, touched):
    """Which of count x count tiles of side 1, row by row, a convex outline (n, 2) touches."""
    low_u, low_v, high_u, high_v, middle_u, middle_v = inf, inf, -inf, -inf, 0.0, 0.0
    for u, v in outline:
        low_u, low_v, high_u, high_v = min(low_u, u), min(low_v, v), max(high_u, u), max(high_v, v)
        middle_u, middle_v = middle_u + u / len(outline), middle_v + v / len(outline)
    for row in range(count):
        for column in range(count):
            inside = column < high_u and column + 1 > low_u and row < high_v and row + 1 > low_v
            for edge in range(len(outline)):
                u, v = outline[edge]
                after_u, after_v = outline[(edge + 1) % len(outline)]
                right, down = after_v - v, u - after_u  # square to the edge, outwards
                turn = right * (u - middle_u) + down * (v - middle_v)
                if turn < 0.0:
                    right, down = -right, -down
                elif turn == 0.0:
                    continue
                # A tile's innermost corner counts.
                inner_u = column + (1.0 if right < 0.0 else 0.0)
                inner_v = row + (1.0 if down < 0.0 else 0.0)
                inside = inside and right * (inner_u - u) + down * (inner_v - v) <= 1e-9
            touched[row * count + column] = inside


@kernel(F2, I1, F2, F2, FLOAT, FLOAT, FLOAT, OUT_I32_2, OUT_B1, allocates=False)
def project_outlines(corners, ends, T_cam_road, K, near, most, scale, fixed, whole):
    """Where corners (k, 2), x and z on the road, are seen: pixels times scale, rounded to fixed.

    ends (n,): rows after the outlines' last corners. Whole are outlines that lie past the near
    plane and within `most` pixels of the first one; what is fixed of others means nothing.
    """
    start = 0
    for outline in range(len(ends)):
        whole[outline] = True
        for row in range(start, ends[outline]):
            x, z = corners[row, 0], corners[row, 1]
            a = T_cam_road[0, 0] * x + T_cam_road[0, 2] * z + T_cam_road[0, 3]
            b = T_cam_road[1, 0] * x + T_cam_road[1, 2] * z + T_cam_road[1, 3]
            depth = T_cam_road[2, 0] * x + T_cam_road[2, 2] * z + T_cam_road[2, 3]
            if not depth >= near:
                whole[outline] = False
                break
            for axis in range(2):
                pixel = (K[axis, 0] * a + K[axis, 1] * b + K[axis, 2] * depth) / depth
                if not abs(pixel) < most:
                    whole[outline] = False
                    break
                fixed[row, axis] = np.int32(np.rint(pixel * scale))
        start = ends[outline]
