"""The lit colours of the triangles that are seen, and the smooth edges between objects."""

from math import sqrt

import numpy as np

from mot_sim.simulation.kernels.compiling import (
    I32_1,
    I32_2,
    OUT_I32_2,
    OUT_U8_2,
    OUT_U8_3,
    U8_2,
    U8_3,
)
from tracker.kernels.compiling import B1, F1, F2, F3, FLOAT, OUT_B1, inlined, kernel

VEGETATION = 10  # as in `renderers.view.Semantic`


@inlined
def whole_power(base, exponent):
    """A number >= 0 to a whole power, by products alone: the same bits everywhere."""
    found, left = 1.0, int(exponent)
    while left > 0:
        if left % 2:
            found *= base
        base *= base
        left //= 2
    return found


@inlined
def unit_normal(corners):
    """The unit normal away from the object; zero of a triangle without area."""
    x1, y1, z1 = (
        corners[1, 0] - corners[0, 0], corners[1, 1] - corners[0, 1], corners[1, 2] - corners[0, 2]
    )  # fmt: skip
    x2, y2, z2 = (
        corners[2, 0] - corners[0, 0], corners[2, 1] - corners[0, 1], corners[2, 2] - corners[0, 2]
    )  # fmt: skip
    x, y, z = y1 * z2 - y2 * z1, z1 * x2 - z2 * x1, x1 * y2 - x2 * y1
    length = sqrt(x * x + y * y + z * z)
    if length > 0.0:
        x, y, z = x / length, y / length, z / length
    return x, y, z


@inlined
def dot3(a, b):
    """The product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(F3, U8_2, B1, F1, F1, F1, F2, F1, FLOAT, FLOAT, FLOAT, OUT_U8_2, allocates=False)
def paint_triangles(
    corners,
    codes,
    seen,
    up,
    sun,
    diffuse,
    shine,
    sky_colour,
    ground_share,
    glint,
    rounding,
    painted,
):
    """Write the lit colours and semantic ids (t, 4) of the triangles that are seen.

    codes: their own colours and ids. up and sun: unit vectors in the camera's frame. diffuse (3):
    light without direction, light by the cosine to the zenith and to the sun. shine: by semantic
    id, as `raster.SHINE`. sky_colour: what is mirrored; ground_share: of it below the horizon;
    glint: grey levels of the sun. rounding: so that 99.99999 is 100.
    """
    constant, of_zenith, of_sun = diffuse[0], diffuse[1], diffuse[2]
    for row in range(len(corners)):
        if not seen[row]:
            continue
        normal = unit_normal(corners[row])
        kind = codes[row, 3]
        to_zenith, to_light = dot3(normal, up), dot3(normal, sun)
        # Light goes through leaves, and from leaf to leaf.
        direct = 0.4 + 0.35 * to_light if kind == VEGETATION else max(to_light, 0.0)
        strength = constant + of_zenith * to_zenith + of_sun * direct
        straight, flat, narrow = shine[kind]
        share, mirrored = 0.0, 0.0
        if narrow > 0.0:
            point = corners[row, 0]
            distance = sqrt(dot3(point, point))
            towards = min(max(-dot3(normal, point) / distance, 0.0), 1.0)
            # What is mirrored comes from 2 (n . v) n - v, with v = -point / distance to the eye.
            to_up = 2.0 * towards * to_zenith + dot3(point, up) / distance
            to_sun = 2.0 * towards * to_light + dot3(point, sun) / distance
            sky = ground_share + (1.0 - ground_share) * min(max(2.0 * to_up + 0.35, 0.0), 1.0)
            share = (straight + flat * whole_power(1.0 - towards, 4)) * sky
            mirrored = glint * whole_power(max(to_sun, 1e-3), narrow)
        for band in range(3):
            colour = codes[row, band] * strength + (share * sky_colour[band] + mirrored)
            painted[row, band] = np.uint8(max(min(colour + rounding, 255.0), 0.0))
        painted[row, 3] = kind


@kernel(I32_2, I32_1, OUT_B1, OUT_I32_2, allocates=False)
def keep_edges(numbers, objects, seen, kept):
    """Write the numbers of four samples a pixel where they show different objects, else 0.

    numbers (2 h, 2 w): the nearest triangles at the samples; objects (t,): whose they are. seen
    (t,): becomes True of the triangles that are kept.
    """
    for row in range(len(numbers) // 2):
        upper, lower, to_upper, to_lower = (
            numbers[2 * row], numbers[2 * row + 1], kept[2 * row], kept[2 * row + 1]
        )  # fmt: skip
        for column in range(0, len(upper), 2):
            a, b, c, d = upper[column], upper[column + 1], lower[column], lower[column + 1]
            is_edge = False
            if not a == b == c == d:
                one = objects[a - 1] if a > 0 else -1
                two = objects[b - 1] if b > 0 else -1
                three = objects[c - 1] if c > 0 else -1
                four = objects[d - 1] if d > 0 else -1
                is_edge = not one == two == three == four
            if is_edge:
                for number in (a, b, c, d):
                    if number > 0:
                        seen[number - 1] = True
            to_upper[column], to_upper[column + 1] = (a, b) if is_edge else (0, 0)
            to_lower[column], to_lower[column + 1] = (c, d) if is_edge else (0, 0)


@kernel(I32_2, U8_2, I32_1, U8_3, U8_3, OUT_U8_3, allocates=False)
def smooth_edges(numbers, painted, slots, lit, behind, image):
    """Mix the colours of four samples where they show different objects, in place.

    numbers (2 h, 2 w): the nearest triangles at the samples, four a pixel, of these pixels alone;
    0 elsewhere. lit (2 h, 2 w, 3): colours of those with a slot. behind: the backdrop, which
    samples without a triangle show.
    """
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            down, right = 2 * row, 2 * column
            either = numbers[down, right] | numbers[down, right + 1]
            if either | numbers[down + 1, right] | numbers[down + 1, right + 1] == 0:
                continue
            for band in range(3):
                total = 2  # rounds to the nearest
                for sample in range(4):
                    down, right = 2 * row + sample // 2, 2 * column + sample % 2
                    each = numbers[down, right]
                    if each > 0 and slots[each - 1] >= 0:
                        total += np.int64(lit[down, right, band])
                    else:
                        total += np.int64(
                            painted[each - 1, band] if each > 0 else behind[row, column, band]
                        )
                image[row, column, band] = total // 4
