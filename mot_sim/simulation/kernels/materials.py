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
    OUT_I32_2,
    OUT_U8_3,
    OUT_U32_1,
    U8_1,
    U8_2,
    U8_3,
)
from mot_sim.simulation.kernels.leaves import (
    TUFT,
    axes_in_row,
    cell_bits,
    mixed_bits,
)
from mot_sim.simulation.kernels.shading import unit_normal
from tracker.kernels.compiling import F2, F3, FLOAT, OUT1, OUT2, OUT_B1, inlined, kernel

TEXELS = 512  # along a side of the finest level of a pattern
LEVELS = 6
TEXELS_A_METRE = 40.0
MEAN = 1 << 20  # of a pattern's brightness
TONE = 13107  # a step of the patterns, of which 80 are the whole brightness
# As in `renderers.view.Material`; what is painted by a pattern comes first, each in its own row.
BLOCKS, LEAF, SHOP = 4, 8, 16
STOREY_FOOT, STOREY = 0.5, 2.9  # metres: the plinth's height, and a storey's


@inlined
def tones_of(pattern, level, xs, ys, tones, places):
    """Write how bright a pattern is at places (n,) in metres, MEAN its mean.

    places (3, n): room. (Loops over views from 0 on are done for several pixels at once.)
    """
    size = np.int32(TEXELS >> level)
    start = np.int32((TEXELS * TEXELS - np.int64(size) * size) // 3 * 4)
    mask, shift, texels = np.int32(size - 1), np.int32(level), TEXELS_A_METRE
    texel, rights, belows = places[0], places[1], places[2]
    if level > 0:  # the texels are hardly larger than the pixels
        for each in range(len(xs)):
            left = np.int32(np.int32(texels * xs[each] + 1048576.0) >> shift) & mask
            top = np.int32(np.int32(texels * ys[each] + 1048576.0) >> shift) & mask
            texel[each] = np.int32(start + np.int32(np.int32(top * size) + left))
        for each in range(len(xs)):
            tones[each] = pattern[np.uint32(texel[each])]
        for each in range(len(xs)):
            tones[each] = np.int32(np.int32(MEAN) + np.int32(tones[each] * np.int32(TONE)))
        return
    # (Rounds down to steps of 1 / 256.)
    for each in range(len(xs)):
        across = np.int32(256.0 * texels * xs[each] + 268435456.0)
        down = np.int32(256.0 * texels * ys[each] + 268435456.0)
        rights[each], belows[each] = across & np.int32(255), down & np.int32(255)
        left, top = (across >> np.int32(8)) & mask, (down >> np.int32(8)) & mask
        texel[each] = np.int32(np.int32(top * size) + left)
    for each in range(len(xs)):
        upper = np.uint32(texel[each])
        left, whole = upper & np.uint32(TEXELS - 1), np.uint32(TEXELS * TEXELS - 1)
        beside = (upper - left) + ((left + np.uint32(1)) & np.uint32(TEXELS - 1))
        lower, across = (upper + np.uint32(TEXELS)) & whole, (beside + np.uint32(TEXELS)) & whole
        right, below = rights[each], belows[each]
        one = pattern[upper] * (256 - right) + pattern[beside] * right
        two = pattern[lower] * (256 - right) + pattern[across] * right
        tones[each] = MEAN + ((one * (256 - below) + two * below) * TONE >> 16)


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
def darken_by_height(ys, tones):
    """Change a wall's tones by the height alone: ledges between storeys, splashes at its foot."""
    for each in range(len(ys)):
        up = ys[each]
        storey = (up - STOREY_FOOT) * (1.0 / STOREY)
        over = STOREY * (storey - np.float64(np.int32(storey)))
        # The shade of the ledge, and its edge.
        tone = 0.72 if over < 0.1 else (1.18 if over > STOREY - 0.12 else 1.0)
        low = 1.0 - 0.14 * (1.4 - up) if up < 1.4 else 1.0
        tones[each] = np.int32(np.float64(tones[each]) * (tone if storey > 0.9 else low))


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
def sign_colour(shop, inside, up, light, pixel, draws, glyphs):
    """The colour of a shop's sign: letters on a board."""
    own, letters = draws[1], 4 + np.int64(5.9 * draws[2])
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
        drawn = glyphs[glyph, np.int64(at_v * glyphs.shape[1]), np.int64(at_u * glyphs.shape[2])]
        ink = sharp * drawn / 255.0 + (1.0 - sharp) * 0.4
    towards = 24.0 if is_pale else 236.0
    return (
        light * (red + ink * (towards - red)),
        light * (green + ink * (towards - green)),
        light * (blue + ink * (towards - blue)),
    )


@inlined
def shop_front(along, up, tone, light, pixel, draws, glyphs):
    """The colour of a shop's front: panes between posts, and a sign with letters above.

    draws (11): the shop, the post and the piece of goods that were last seen, and their random
    numbers.
    """
    shop = np.floor(along / 9.0)
    if draws[0] != shop:
        draws[0], draws[1], draws[2] = shop, chance(shop, 1, 11), chance(shop, 2, 11)
        draws[3] = draws[6] = np.inf
    if up > 2.78:
        return sign_colour(shop, along - 9.0 * shop, up, light, pixel, draws, glyphs)
    post = np.floor(along / 1.6)
    aside = along - 1.6 * post
    if aside < 0.09 or up > 2.7 or up < 0.72:
        grey = light * (46.0 + 90.0 * draws[1]) * tone
        return grey, grey, grey
    # Behind the pane: a dim room or a lit wall, goods at the foot, a poster; the sky mirrored.
    item = np.floor(along / 0.4)
    if draws[3] != post:
        draws[3], draws[4], draws[5] = post, chance(post, shop, 13), chance(post, shop, 17)
    if draws[6] != item:
        draws[6], draws[7], draws[8] = item, chance(item, shop, 7), chance(item, shop, 19)
        draws[9], draws[10] = chance(item, shop, 20), chance(item, shop, 22)
    kind, strength, red, blue = draws[4], 34.0 + 22.0 * (up - 0.7), 0.95, 1.06
    if kind < 0.3 and 1.0 < up < 2.1 and 0.35 < aside < 1.25:
        strength = 120.0 + 60.0 * kind
        red, blue = 0.75 + 0.5 * draws[5], 1.25 - 0.5 * draws[5]
    elif up < 0.85 + 0.6 * draws[7]:
        strength = 30.0 + 110.0 * draws[8] * draws[8]
        red, blue = 0.85 + 0.35 * draws[9], 0.8 + 0.35 * draws[10]
    elif kind > 0.65:
        strength, red, blue = strength + 45.0 * kind, 1.08, 0.88
    strength *= light * tone
    return strength * red, strength, strength * blue


@inlined
def paint_leaves(
    numbers, nearness, row, column, materials, objects, painted, As_cell_ray, pixel, metres, bits,
    colours,
):  # fmt: skip
    """Paint the leaves of a thing from a column on; gives the column after them.

    From dark gaps to leaves that face the sun.
    """
    begun, thing = column, objects[numbers[column] - 1]
    while column < len(numbers):
        triangle = numbers[column] - 1
        if triangle < 0 or objects[triangle] != thing or materials[triangle] not in (LEAF, TUFT):
            break
        column += 1
    near, axes = nearness[begun:column], axes_in_row(As_cell_ray[thing], row)
    cell_bits(near, begun, axes, pixel, metres[0], metres[1], bits)
    for each in range(len(near)):
        word = bits[each]
        share = np.uint32(112) + (word & np.uint32(255))
        share = np.uint32(share + ((word >> np.uint32(8)) & np.uint32(63)))
        fifth = np.uint32(np.uint32(40) + np.uint32(np.uint32(share * np.uint32(205)) >> 10))
        bits[each] = fifth if word >> np.uint32(24) < np.uint32(60) else share
    for each in range(len(near)):
        own, share, colour = painted[numbers[begun + each] - 1], bits[each], colours[begun + each]
        for band in range(3):
            value = np.uint32(np.uint32(own[band]) * share) >> np.uint32(8)
            colour[band] = min(value, np.uint32(255))
    return column


@inlined
def level_of(wide, near):
    """The level of a pattern for pixels so many metres wide at 1 m, at an inverse depth."""
    level, side = 0, np.float64(near) * (1.0 / TEXELS_A_METRE)
    while wide > side and level < LEVELS - 1:
        side, level = 2.0 * side, level + 1
    return level


@inlined
def paint_wall(
    numbers, nearness, row, column, kind, own, light, wall, wide, pattern, glyphs, metres, places,
    draws, colours,
):  # fmt: skip
    """Paint a row's pixels of a face with a pattern, from a column on; gives the one after them.

    wide: a pixel's width at 1 m. metres (3, w), places (4, w), draws (11): room.
    """
    number, begun = numbers[column], column
    level = level_of(wide, nearness[column])
    while column < len(numbers) and numbers[column] == number:
        column += 1
    if level_of(wide, nearness[column - 1]) != level:
        column = begun + 1
        while level_of(wide, nearness[column]) == level:
            column += 1
    count, near = column - begun, nearness[begun:column]
    xs, ys, tones = metres[0, :count], metres[1, :count], places[3, :count]
    x_step, x_begun, x_eye = wall[0], wall[1] * row + wall[2], wall[3]
    y_step, y_begun, y_eye = wall[4], wall[5] * row + wall[6], wall[7]
    for each in range(len(near)):
        depth, u = 1.0 / np.float64(near[each]), float(begun + each)
        xs[each] = depth * (x_step * u + x_begun) + x_eye
        ys[each] = depth * (y_step * u + y_begun) + y_eye
    tones_of(pattern, level, xs, ys, tones, places)
    if kind >= SHOP:
        for each in range(count):
            x, y = xs[each], ys[each]
            if STOREY_FOOT < y < STOREY_FOOT + STOREY - 0.06:
                across, tone = wide / np.float64(near[each]), tones[each] * (1.0 / MEAN)
                colour = shop_front(x, y, tone, light, across, draws, glyphs)
                for band in range(3):
                    colours[begun + each, band] = np.uint8(min(max(colour[band], 0.0), 255.0))
                tones[each] = -MEAN  # painted
    if kind >= SHOP or kind <= BLOCKS:
        darken_by_height(ys, tones)
    red, green, blue = np.int32(own[0]), np.int32(own[1]), np.int32(own[2])
    for each in range(count):
        tone, colour = tones[each], colours[begun + each]
        if tone >= 0:
            colour[0] = min(np.int32(red * tone) >> 20, 255)
            colour[1] = min(np.int32(green * tone) >> 20, 255)
            colour[2] = min(np.int32(blue * tone) >> 20, 255)
    return column


@kernel(
    I32_2, F32_2, F3, U8_2, U8_2, U8_1, I32_1, I32_1, F3, F3, F2, F3, FLOAT, I8_2, U8_3,
    OUT2, OUT_B1, OUT2, OUT_I32_2, OUT_U32_1, OUT1, OUT_U8_3, allocates=False,
)  # fmt: skip
def paint_faces(
    numbers, nearness, corners, codes, painted, materials, slots, objects, Rs_object_cam,
    As_object_ray, eyes, As_cell_ray, pixel, patterns, glyphs, walls, laid, metres, places, bits,
    draws, image,
):  # fmt: skip
    """Paint what is seen of the faces, with what they are made of; not those with a skin.

    codes: their own colours (t, 4); painted: lit; materials (t,): see `renderers.view.Material`.
    slots (t,): of the skins. pixel: a pixel's width at a depth of 1 m. patterns: see
    `renderers.materials.patterns`. walls (t, 11): room for `lay_axes`, laid (t,): so far False.
    metres (2, w), places (4, w), bits (w), draws (11): room.
    """
    width = numbers.shape[1]
    draws[0] = np.inf
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
                    metres, bits, colours,
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
                    glyphs, metres, places, draws, colours,
                )  # fmt: skip
