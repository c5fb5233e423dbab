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
    OUT_U8_3,
    U8_1,
    U8_2,
    U8_3,
)
from mot_sim.simulation.kernels.leaves import (
    LEAF_METRES,
    TUFT,
    axes_in_row,
    cell_bits,
    leaf_side,
    mixed_bits,
)
from mot_sim.simulation.kernels.shading import unit_normal
from tracker.kernels.compiling import F2, F3, FLOAT, OUT2, OUT_B1, inlined, kernel

TEXELS = 512  # along a side of the finest level of a pattern
LEVELS = 6
TEXELS_A_METRE = 40.0
MEAN = 1 << 20  # of a pattern's brightness
TONE = 13107  # a step of the patterns, of which 80 are the whole brightness
# As in `renderers.view.Material`; what is painted by a pattern comes first, each in its own row.
BLOCKS, LEAF, SHOP = 4, 8, 16
STOREY_FOOT, STOREY = 0.5, 2.9  # metres: the plinth's height, and a storey's


@inlined
def tone_at(pattern, x, y, level):
    """How bright a pattern is at a place, in texels of the finest level."""
    size = TEXELS >> level
    start = (TEXELS * TEXELS - size * size) // 3 * 4
    mask = size - 1
    if level > 0:  # the texels are hardly larger than the pixels
        left, top = np.int64(x + 1048576.0) >> level, np.int64(y + 1048576.0) >> level
        return MEAN + np.int64(pattern[start + (top & mask) * size + (left & mask)]) * TONE
    # (Rounds down to steps of 1 / 256.)
    across, down = np.int64(256.0 * x + 268435456.0), np.int64(256.0 * y + 268435456.0)
    left, top, right, below = across >> 8, down >> 8, across & 255, down & 255
    column, beside = left & mask, (left + 1) & mask
    upper, lower = (top & mask) * size, ((top + 1) & mask) * size
    one = np.int64(pattern[upper + column]) * (256 - right)
    one += np.int64(pattern[upper + beside]) * right
    two = np.int64(pattern[lower + column]) * (256 - right)
    two += np.int64(pattern[lower + beside]) * right
    return MEAN + ((one * (256 - below) + two * below) * TONE >> 16)


@inlined
def cut_to_one(value):
    """A number cut to 0 to 1."""
    return min(max(value, 0.0), 1.0)


@inlined
def chance(x, y, salt):
    """A random number from 0 to 1 of a cell of a plane."""
    return (mixed_bits(np.int64(x), np.int64(y), salt) & 0xFFFF) * (1.0 / 65535.0)


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
def lay_axes(corners, R, A, eye, wall):
    """Write how pixels lead to metres along a face and up, and how it faces them.

    wall (11): along and upward, (4) each, for (u, v, 1) times depth, and 1; facing (3), for
    (u, v, 1): the cosine between ray and normal times the ray's length.
    """
    out = unit_normal(corners)
    x = R[0, 0] * out[0] + R[0, 1] * out[1] + R[0, 2] * out[2]
    y = R[1, 0] * out[0] + R[1, 1] * out[1] + R[1, 2] * out[2]
    z = R[2, 0] * out[0] + R[2, 1] * out[1] + R[2, 2] * out[2]
    level = sqrt(x * x + z * z)
    right, ahead = 1.0, 0.0  # the level tangent's x and z
    if level > 1e-3:
        right, ahead = -z / level, x / level
    up_x, up_y, up_z = y * ahead, z * right - x * ahead, -y * right
    if up_y > 0.0:
        up_x, up_y, up_z = -up_x, -up_y, -up_z
    for axis in range(3):
        wall[axis] = right * A[0, axis] + ahead * A[2, axis]
        wall[4 + axis] = up_x * A[0, axis] + up_y * A[1, axis] + up_z * A[2, axis]
        wall[8 + axis] = x * A[0, axis] + y * A[1, axis] + z * A[2, axis]
    wall[3] = right * eye[0] + ahead * eye[2]
    wall[7] = up_x * eye[0] + up_y * eye[1] + up_z * eye[2]


@inlined
def slant_at(wall, A, column, row):
    """By how much a pixel is wider on a face than across the ray."""
    x = A[0, 0] * column + A[0, 1] * row + A[0, 2]
    y = A[1, 0] * column + A[1, 1] * row + A[1, 2]
    z = A[2, 0] * column + A[2, 1] * row + A[2, 2]
    facing = wall[8] * column + wall[9] * row + wall[10]
    return 1.0 / max(sqrt(abs(facing) / sqrt(x * x + y * y + z * z)), 0.15)


@inlined
def shop_front(along, up, tone, light, pixel, glyphs):
    """The colour of a shop's front: panes between posts, and a sign with letters above."""
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
        return (
            light * (red + ink * (towards - red)),
            light * (green + ink * (towards - green)),
            light * (blue + ink * (towards - blue)),
        )
    post = np.floor(along / 1.6)
    aside = along - 1.6 * post
    if aside < 0.09 or up > 2.7 or up < 0.72:
        grey = light * (46.0 + 90.0 * own) * tone
        return grey, grey, grey
    # Behind the pane: a dim room or a lit wall, goods at the foot, a poster; the sky mirrored.
    kind, item = chance(post, shop, 13), np.floor(along / 0.4)
    strength, red, blue = 34.0 + 22.0 * (up - 0.7), 0.95, 1.06
    if kind < 0.3 and 1.0 < up < 2.1 and 0.35 < aside < 1.25:
        hue = chance(post, shop, 17)
        strength, red, blue = 120.0 + 60.0 * kind, 0.75 + 0.5 * hue, 1.25 - 0.5 * hue
    elif up < 0.85 + 0.6 * chance(item, shop, 7):
        goods = chance(item, shop, 19)
        strength = 30.0 + 110.0 * goods * goods
        red, blue = 0.85 + 0.35 * chance(item, shop, 20), 0.8 + 0.35 * chance(item, shop, 22)
    elif kind > 0.65:
        strength, red, blue = strength + 45.0 * kind, 1.08, 0.88
    strength *= light * tone
    return strength * red, strength, strength * blue


@inlined
def paint_leaf(bits, own, colour):
    """Write the colour of a leaf: from dark gaps to leaves that face the sun."""
    share = 112 + (bits & 255) + ((bits >> 8) & 63)
    if bits >> 24 < 60:
        share = 40 + (share * 205 >> 10)  # a fifth
    for band in range(3):
        colour[band] = min((np.int64(own[band]) * share) >> 8, 255)


@inlined
def paint_leaves(
    numbers, nearness, row, column, materials, objects, painted, As_cell_ray, pixel, colours
):
    """Paint all leaves from a column on; gives the column after them."""
    triangle, thing, side = numbers[column] - 1, -1, LEAF_METRES
    axes = axes_in_row(As_cell_ray[objects[triangle]], row)
    while triangle >= 0 and materials[triangle] in (LEAF, TUFT):
        if objects[triangle] != thing:
            thing = objects[triangle]
            axes = axes_in_row(As_cell_ray[thing], row)
        depth = 1.0 / np.float64(nearness[column])
        side = leaf_side(side, pixel * depth)
        bits = cell_bits(axes, float(column), depth, side)
        paint_leaf(bits, painted[triangle], colours[column])
        column += 1
        triangle = numbers[column] - 1 if column < len(numbers) else -1
    return column


@inlined
def paint_wall(
    numbers, nearness, row, column, kind, own, light, wall, wide, pattern, glyphs, colours
):
    """Paint a row's pixels of a face with a pattern, from a column on; gives the one after them.

    wide: a pixel's width at 1 m.
    """
    number = numbers[column]
    red, green, blue = np.int64(own[0]), np.int64(own[1]), np.int64(own[2])
    x_step, x_begun, x_eye = wall[0], wall[1] * row + wall[2], wall[3]
    y_step, y_begun, y_eye = wall[4], wall[5] * row + wall[6], wall[7]
    level, side = 0, 1.0 / TEXELS_A_METRE
    has_storeys, is_shop = kind >= SHOP or kind <= BLOCKS, kind >= SHOP
    while column < len(numbers) and numbers[column] == number:
        depth = 1.0 / np.float64(nearness[column])
        x = depth * (x_step * column + x_begun) + x_eye
        y = depth * (y_step * column + y_begun) + y_eye
        across = wide * depth
        while across > side and level < LEVELS - 1:
            side, level = 2.0 * side, level + 1
        while level > 0 and across <= 0.5 * side:
            side, level = 0.5 * side, level - 1
        tone = tone_at(pattern, TEXELS_A_METRE * x, TEXELS_A_METRE * y, level)
        if is_shop and STOREY_FOOT < y < STOREY_FOOT + STOREY - 0.06:
            colour = shop_front(x, y, tone * (1.0 / MEAN), light, across, glyphs)
            for band in range(3):
                colours[column, band] = np.uint8(min(max(colour[band], 0.0), 255.0))
        else:
            if has_storeys:
                tone = np.int64(tone * height_tone(y))
            colours[column, 0] = min((red * tone) >> 20, 255)
            colours[column, 1] = min((green * tone) >> 20, 255)
            colours[column, 2] = min((blue * tone) >> 20, 255)
        column += 1
    return column


@kernel(
    I32_2, F32_2, F3, U8_2, U8_2, U8_1, I32_1, I32_1, F3, F3, F2, F3, FLOAT, I8_2, U8_3,
    OUT2, OUT_B1, OUT_U8_3, allocates=False,
)  # fmt: skip
def paint_faces(
    numbers, nearness, corners, codes, painted, materials, slots, objects, Rs_object_cam,
    As_object_ray, eyes, As_cell_ray, pixel, patterns, glyphs, walls, laid, image,
):  # fmt: skip
    """Paint what is seen of the faces, with what they are made of; not those with a skin.

    codes: their own colours (t, 4); painted: lit; materials (t,): see `renderers.view.Material`.
    slots (t,): of the skins. pixel: a pixel's width at a depth of 1 m. patterns: see
    `renderers.materials.patterns`. walls (t, 11): room for `lay_axes`, laid (t,): so far False.
    """
    width = numbers.shape[1]
    for row in range(len(numbers)):
        column, found, near, colours = 0, numbers[row], nearness[row], image[row]
        while column < width:
            triangle = found[column] - 1
            if triangle < 0 or slots[triangle] >= 0:
                column += 1
                continue
            kind, own, thing = np.int64(materials[triangle]), painted[triangle], objects[triangle]
            if kind == 0:
                for band in range(3):
                    colours[column, band] = own[band]
                column += 1
            elif kind in (LEAF, TUFT):
                column = paint_leaves(
                    found, near, row, column, materials, objects, painted, As_cell_ray, pixel,
                    colours,
                )  # fmt: skip
            else:
                A, wall = As_object_ray[thing], walls[triangle]
                if not laid[triangle]:
                    laid[triangle] = True
                    lay_axes(corners[triangle], Rs_object_cam[thing], A, eyes[thing], wall)
                light = lit_share(codes[triangle], own) if kind >= SHOP else 1.0
                wide = pixel * slant_at(wall, A, column, row)
                column = paint_wall(
                    found, near, row, column, kind, own, light, wall, wide, patterns[kind % SHOP],
                    glyphs, colours,
                )  # fmt: skip
