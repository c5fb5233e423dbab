"""What faces of scenery are made of, painted pixel by pixel: bricks, plaster, tiles, leaves, signs.

All patterns lie in the space of the things themselves, so that they stay where they are when the
camera moves; what would be finer than a pixel fades into its mean.
"""

from math import sqrt

import numpy as np

from mot_sim.simulation.kernels.compiling import (
    F32_2,
    I8_2,
    I32_1,
    I32_2,
    OUT_F32_2,
    OUT_I32_2,
    OUT_U8_3,
    U8_1,
    U8_2,
    U8_3,
)
from mot_sim.simulation.kernels.shading import mixed_bits, unit_normal
from tracker.kernels.compiling import F2, F3, FLOAT, INT, inlined, kernel

TEXELS = 512  # along a side of the finest level of a pattern
LEVELS = 6
TEXELS_A_METRE = 40.0
TONES = 1.0 / 80.0  # share of brightness of a step of the patterns
# As in `renderers.view.Material`; what is painted by a pattern comes first, each in its own row.
PANE, BLOCKS, LEAF, TUFT, SHOP = 6, 4, 8, 9, 16
STOREY_FOOT, STOREY = 0.5, 2.9  # metres: the plinth's height, and a storey's
LEAF_METRES = 0.085  # of the finest leaves, or tufts of them
LEAF_PIXELS = 2.2  # that leaves are at least wide


@inlined
def tone_at(pattern, x, y, level):
    """How much brighter than its mean a pattern is at a place, in texels of the finest level."""
    size = TEXELS >> level
    start = (TEXELS * TEXELS - size * size) * 4 // 3
    shrink = 1.0 / (1 << level)
    x, y = x * shrink, y * shrink
    left, top = np.int64(x + 1048576.0) - 1048576, np.int64(y + 1048576.0) - 1048576  # rounds down
    if level > 0:  # the texels are hardly larger than the pixels
        return pattern[start + (top & (size - 1)) * size + (left & (size - 1))] * TONES
    right, down = x - left, y - top
    column, beside = left & (size - 1), (left + 1) & (size - 1)
    upper, lower = start + (top & (size - 1)) * size, start + ((top + 1) & (size - 1)) * size
    one = pattern[upper + column] * (1.0 - right) + right * pattern[upper + beside]
    two = pattern[lower + column] * (1.0 - right) + right * pattern[lower + beside]
    return (one + down * (two - one)) * TONES


@inlined
def cut_to_one(value):
    """A number cut to 0 to 1."""
    return min(max(value, 0.0), 1.0)


@inlined
def chance(x, y, salt):
    """A random number from 0 to 1 of a cell of a plane."""
    return (mixed_bits(np.int64(x), np.int64(y), salt) & 0xFFFF) * (1.0 / 65535.0)


@inlined
def leaf_cell(x, y, z, pixel, place):
    """Write the cell of space, aslant to all faces, of the leaf at a point; as large as is seen."""
    side = LEAF_METRES
    while side < LEAF_PIXELS * pixel:
        side *= 2.0
    x, y, z = x / side, y / side, z / side
    place[0] = np.floor(0.36 * x + 0.48 * y - 0.8 * z)
    place[1] = np.floor(-0.8 * x + 0.6 * y)
    place[2] = np.floor(0.48 * x + 0.64 * y + 0.6 * z)


@kernel(I32_2, F32_2, I32_2, F32_2, U8_1, I32_1, F3, F2, FLOAT, INT, OUT_I32_2, OUT_F32_2)
def open_crowns(
    numbers, nearness, behind, nearness_behind, materials, objects, As_object_ray, eyes, pixel,
    share, shown, nearness_shown,
):  # fmt: skip
    """Write which triangles are seen where tufts of leaves have gaps: those behind all tufts.

    numbers, nearness: the nearest triangles, 1 + row, and 1 / m; behind: the nearest that are no
    tufts, known only beneath tufts. As_object_ray (n, 3, 3) and eyes (n, 3) lead from a pixel
    (u, v, 1), times its depth, to the objects' frames. share: of 256 cells, how many are open.
    """
    place = np.empty(3)
    for row in range(numbers.shape[0]):
        last, is_tuft = 0, False
        for column in range(numbers.shape[1]):
            number = numbers[row, column]
            if number != last:
                last, is_tuft = number, number > 0 and materials[number - 1] == TUFT
            if not is_tuft:
                continue
            A, eye = As_object_ray[objects[number - 1]], eyes[objects[number - 1]]
            depth = 1.0 / np.float64(nearness[row, column])
            u, v = column * depth, row * depth
            x = A[0, 0] * u + A[0, 1] * v + A[0, 2] * depth + eye[0]
            y = A[1, 0] * u + A[1, 1] * v + A[1, 2] * depth + eye[1]
            z = A[2, 0] * u + A[2, 1] * v + A[2, 2] * depth + eye[2]
            leaf_cell(x, y, z, pixel * depth, place)
            bits = mixed_bits(np.int64(place[0]), np.int64(place[1]), np.int64(place[2]))
            if (bits >> 16) & 255 < share:
                shown[row, column] = behind[row, column]
                nearness_shown[row, column] = nearness_behind[row, column]


@inlined
def leaf_share(place):
    """Of 256 shares of the colour of a leaf: from dark gaps to leaves that face the sun."""
    bits = mixed_bits(np.int64(place[0]), np.int64(place[1]), np.int64(place[2]))
    share = 112 + (bits & 255) + ((bits >> 8) & 63)
    return 40 + share // 5 if bits >> 24 < 60 else share


@inlined
def lit_share(own, painted):
    """How bright a face is lit, as a share of its own colour."""
    whole, lit = 1.0, 1.0
    for band in range(3):
        whole += np.float64(own[band])
        lit += np.float64(painted[band])
    return lit / whole


@inlined
def height_tone(up):
    """How bright a wall is by the height alone: ledges between storeys, splashes at its foot."""
    storey = (up - STOREY_FOOT) * (1.0 / STOREY)
    if storey > 0.9:
        over = STOREY * (storey - np.int64(storey))
        if over < 0.1:
            return 0.72  # the shade of the ledge
        return 1.18 if over > STOREY - 0.12 else 1.0
    return 1.0 - 0.14 * (1.4 - up) if up < 1.4 else 1.0


@inlined
def lay_axes(face_normal, R, A, eye, column, row, normal, along, upward):
    """Write how pixels lead to metres along a face and up, for (u, v, 1) times depth, and 1.

    Gives by how much a pixel is wider on the face than across the ray.
    """
    for axis in range(3):
        normal[axis] = (
            R[axis, 0] * face_normal[0] + R[axis, 1] * face_normal[1] + R[axis, 2] * face_normal[2]
        )
    level = sqrt(normal[0] * normal[0] + normal[2] * normal[2])
    right, ahead = 1.0, 0.0  # the level tangent's x and z
    if level > 1e-3:
        right, ahead = -normal[2] / level, normal[0] / level
    up_x, up_y = normal[1] * ahead, normal[2] * right - normal[0] * ahead
    up_z = -normal[1] * right
    if up_y > 0.0:
        up_x, up_y, up_z = -up_x, -up_y, -up_z
    facing, length = 0.0, 0.0
    for axis in range(3):
        along[axis] = right * A[0, axis] + ahead * A[2, axis]
        upward[axis] = up_x * A[0, axis] + up_y * A[1, axis] + up_z * A[2, axis]
        ray = A[axis, 0] * column + A[axis, 1] * row + A[axis, 2]
        facing += normal[axis] * ray
        length += ray * ray
    along[3] = right * eye[0] + ahead * eye[2]
    upward[3] = up_x * eye[0] + up_y * eye[1] + up_z * eye[2]
    return 1.0 / max(sqrt(abs(facing) / sqrt(length)), 0.15)


@inlined
def shop_front(along, up, tone, light, pixel, glyphs, colour):
    """Write the colour of a shop's front: panes between posts, and a sign with letters above."""
    shop = np.floor(along / 9.0)
    own = chance(shop, 1, 11)
    if up > 2.78:
        inside, letters = along - 9.0 * shop, 4 + np.int64(5.9 * chance(shop, 2, 11))
        # From white over shades of one colour to black.
        pale, hue = own * 7.0 - np.floor(own * 7.0), own * 29.0 - np.floor(own * 29.0)
        red = 30.0 + 190.0 * max(pale, cut_to_one(1.6 - 4.0 * hue))
        green = 30.0 + 180.0 * max(pale, cut_to_one(0.7 - 3.0 * abs(hue - 0.45)))
        blue = 30.0 + 180.0 * max(pale, cut_to_one(3.2 * hue - 1.9))
        ink, is_pale = 0.0, pale > 0.5
        cell = np.floor((inside - 1.6) / 0.36)
        at_u, at_v = (inside - 1.6) / 0.36 - cell, (3.27 - up) / 0.4
        if 0.0 <= cell < letters and 0.0 <= at_v < 1.0:
            glyph = np.int64(chance(shop * 16 + cell, 4, 11) * 20.99)
            sharp = cut_to_one(0.2 / pixel - 1.0)
            drawn = glyphs[
                glyph, np.int64(at_v * glyphs.shape[1]), np.int64(at_u * glyphs.shape[2])
            ]
            ink = sharp * drawn / 255.0 + (1.0 - sharp) * 0.4
        towards = 24.0 if is_pale else 236.0
        colour[0] = light * (red + ink * (towards - red))
        colour[1] = light * (green + ink * (towards - green))
        colour[2] = light * (blue + ink * (towards - blue))
        return
    post = np.floor(along / 1.6)
    aside = along - 1.6 * post
    if aside < 0.09 or up > 2.7 or up < 0.72:
        for band in range(3):
            colour[band] = light * (46.0 + 90.0 * own) * tone
        return
    # What lies behind the pane: goods on shelves, dim, and the sky mirrored in its upper part.
    shelf, item = np.floor(up / 0.42), np.floor(along / 0.3)
    goods = chance(item, shelf, 7)
    strength = light * (34.0 + 26.0 * (up - 0.7) + 80.0 * goods * goods * goods)
    for band in range(3):
        tint = chance(item, shelf, 20 + band)
        colour[band] = strength * (0.7 + 0.6 * tint) * tone


@kernel(I32_2, F32_2, F3, U8_2, U8_2, U8_1, I32_1, F3, F3, F2, FLOAT, I8_2, U8_3, OUT_U8_3)
def texture_faces(
    numbers, nearness, corners, codes, painted, materials, objects, Rs_object_cam, As_object_ray,
    eyes, pixel, patterns, glyphs, image,
):  # fmt: skip
    """Paint what faces are made of over their lit colours, in place.

    codes: their own colours (t, 4); painted: lit; materials (t,): see `renderers.view.Material`.
    pixel: a pixel's width at a depth of 1 m. patterns: see `renderers.materials.patterns`.
    """
    normal, along, upward = np.empty(3), np.empty(4), np.empty(4)
    place, colour = np.empty(3), np.empty(3)
    for row in range(numbers.shape[0]):
        last, is_leafy, kind, thing = -1, False, 0, 0
        slant = light = 1.0
        for column in range(numbers.shape[1]):
            triangle = numbers[row, column] - 1
            if triangle != last:
                last = triangle
                kind = np.int64(materials[triangle]) if triangle >= 0 else 0
                is_leafy = kind in (LEAF, TUFT)
                if kind != 0:
                    thing = objects[triangle]
                if kind != 0 and not is_leafy:
                    unit_normal(corners[triangle], place)
                    slant = lay_axes(
                        place, Rs_object_cam[thing], As_object_ray[thing], eyes[thing],
                        column, row, normal, along, upward,
                    )  # fmt: skip
                    light = lit_share(codes[triangle], painted[triangle])
            if kind == 0:
                continue
            depth = 1.0 / np.float64(nearness[row, column])
            u, v = column * depth, row * depth
            if is_leafy:
                A, eye = As_object_ray[thing], eyes[thing]
                x = A[0, 0] * u + A[0, 1] * v + A[0, 2] * depth + eye[0]
                y = A[1, 0] * u + A[1, 1] * v + A[1, 2] * depth + eye[1]
                z = A[2, 0] * u + A[2, 1] * v + A[2, 2] * depth + eye[2]
                leaf_cell(x, y, z, pixel * depth, place)
                share = leaf_share(place)
                for band in range(3):
                    image[row, column, band] = min(image[row, column, band] * share // 256, 255)
                continue
            x = along[0] * u + along[1] * v + along[2] * depth + along[3]
            y = upward[0] * u + upward[1] * v + upward[2] * depth + upward[3]
            wide = pixel * depth * slant
            level, side = 0, 1.0 / TEXELS_A_METRE
            while wide > side and level < LEVELS - 1:
                side, level = 2.0 * side, level + 1
            tone = 1.0 + tone_at(
                patterns[kind % SHOP], TEXELS_A_METRE * x, TEXELS_A_METRE * y, level
            )
            if kind >= SHOP and STOREY_FOOT < y < STOREY_FOOT + STOREY - 0.06:
                shop_front(x, y, tone, light, wide, glyphs, colour)
                for band in range(3):
                    image[row, column, band] = np.uint8(min(max(colour[band], 0.0), 255.0))
                continue
            if kind >= SHOP or kind <= BLOCKS:  # walls
                tone *= height_tone(y)
            for band in range(3):
                value = image[row, column, band] * tone
                image[row, column, band] = np.uint8(min(max(value, 0.0), 255.0))
