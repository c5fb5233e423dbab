"""Surfaces lit pixel by pixel: bodywork and glass between the normals of their corners."""

from math import sqrt

import numpy as np

from mot_sim.simulation.kernels.compiling import (
    F32_2,
    I32_1,
    I32_2,
    OUT_F32_2,
    OUT_I32_1,
    OUT_I32_2,
    OUT_U8_3,
    U8_2,
    U8_3,
)
from mot_sim.simulation.kernels.meshes import placed
from mot_sim.simulation.kernels.shading import dot3
from tracker.kernels.compiling import F1, F2, F3, FLOAT, I1, I2, INT, OUT2, OUT_B1, inlined, kernel

ROUNDING = 1e-3  # so that 99.99999 is 100
TINY_VOLUME = 1e-9  # m^3: the eye lies in the plane of a face


@inlined
def cross3(a, b):
    """The cross product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def turned_normal(T, normals, face, corner):
    """The normal at a face's corner, turned by T."""
    x, y, z = normals[face, corner, 0], normals[face, corner, 1], normals[face, corner, 2]
    return (
        T[0, 0] * x + T[0, 1] * y + T[0, 2] * z,
        T[1, 0] * x + T[1, 1] * y + T[1, 2] * z,
        T[2, 0] * x + T[2, 1] * y + T[2, 2] * z,
    )


@kernel(
    F2, I2, F3, F2, U8_2, I1, F2, F2, INT, I1, OUT_B1, OUT_I32_1, OUT2, allocates=False
)  # fmt: skip
def prepare_skins(
    vertices, faces, normals, openness, codes, patterns, T_cam_object, K_inverse, start, rows, seen,
    slots, skins,
):  # fmt: skip
    """Write what each seen face of an object needs to be lit pixel by pixel, from a slot on.

    normals (f, 3, 3) and openness (f, 3): of the faces' corners. rows (t,): the faces that may be
    in the image; seen (t,): which are; slots (t,): where their skins are. A skin (17): nine
    numbers that give the normal's direction at (u, v, 1), three that give the openness over the
    depth, the colour, the semantic id, the pattern. Gives the slot after the last.
    """
    T, slot = T_cam_object, start
    for each in range(len(rows)):
        if not seen[each]:
            continue
        face, skin = rows[each], skins[slot]
        a, b = placed(T, vertices, faces[face, 0]), placed(T, vertices, faces[face, 1])
        c = placed(T, vertices, faces[face, 2])
        # The rows of the inverse are the cross products of the others.
        of_a, of_b, of_c = cross3(b, c), cross3(c, a), cross3(a, b)
        volume = dot3(of_a, a)
        at_a, at_b, at_c = (
            turned_normal(T, normals, face, 0),
            turned_normal(T, normals, face, 1),
            turned_normal(T, normals, face, 2),
        )
        for column in range(3):
            pixel = K_inverse[0, column], K_inverse[1, column], K_inverse[2, column]
            one, two, three = dot3(of_a, pixel), dot3(of_b, pixel), dot3(of_c, pixel)
            one, two, three = one / volume, two / volume, three / volume
            is_edge_on = abs(volume) < TINY_VOLUME
            if is_edge_on:
                one = two = three = 1.0 if column == 2 else 0.0
            skin[column] = one * at_a[0] + two * at_b[0] + three * at_c[0]
            skin[3 + column] = one * at_a[1] + two * at_b[1] + three * at_c[1]
            skin[6 + column] = one * at_a[2] + two * at_b[2] + three * at_c[2]
            if is_edge_on:
                one, two, three = one / (3.0 * a[2]), two / (3.0 * b[2]), three / (3.0 * c[2])
            skin[9 + column] = (
                one * openness[face, 0] + two * openness[face, 1] + three * openness[face, 2]
            )
        for band in range(4):
            skin[12 + band] = codes[face, band]
        skin[16] = patterns[face]
        slots[each] = slot
        slot += 1
    return slot


@inlined
def wheel_tone(along, up, sharp):
    """The grey level of a wheel at a place in radii from its hub; sharp: 0 from far, 1 from near.

    Five spokes before dark holes, a bright edge of the rim, the tyre.
    """
    square = along * along + up * up
    if square > 0.40:
        return 19.0 + (14.0 if square < 0.46 and sharp > 0.5 else 0.0)
    if square > 0.34:
        return 118.0
    if square < 0.018:
        return 84.0
    radius = sqrt(square)
    c = along / radius
    turn = c * (5.0 + c * c * (16.0 * c * c - 20.0))  # the cosine of five times the angle
    spoke = min(max(3.0 * (turn + 0.1), 0.0), 1.0)
    return 62.0 + sharp * (16.0 + 106.0 * spoke - 62.0)


@inlined
def plate_cell(across, down):
    """Which character of a number plate lies at a place between 0 and 1, and where in it.

    -1: none, but the white around; -2: the rim; -3: the blue end.
    """
    if across < 0.075:
        return -3, 0.0, 0.0
    if down < 0.05 or down > 0.95 or across > 0.985:
        return -2, 0.0, 0.0
    cell = (across - 0.10) * (1.0 / 0.096)
    number = int(cell)
    v, u = (down - 0.16) * (1.0 / 0.68), (cell - number - 0.06) * (1.0 / 0.88)
    if cell < 0.0 or number >= 9 or not (0.0 <= v < 1.0 and 0.0 <= u < 1.0):
        return -1, 0.0, 0.0
    return number, u, v


@inlined
def pattern_colour(skin, place, glyphs, a, b, depth):
    """The colour of a wheel or a number plate at a depth along the ray (a, b, 1)."""
    dx, dy, dz = a * depth - place[3], b * depth - place[7], depth - place[11]
    ox = place[0] * dx + place[4] * dy + place[8] * dz
    oy = place[1] * dx + place[5] * dy + place[9] * dz
    oz = place[2] * dx + place[6] * dy + place[10] * dz
    if skin[16] == 1.0:
        hub = place[12] if ox > 0.0 else place[13]
        sharp = min(max(40.0 / depth - 1.0, 0.0), 1.0)
        tone = wheel_tone((ox - hub) / place[14], oy / place[15] + 1.0, sharp)
        return tone, tone, tone
    is_front = ox > 0.0
    middle, half = place[16] if is_front else place[17], place[18]
    across = 0.5 + 0.5 * (oz if is_front else -oz) / half
    sharp = min(max(30.0 / depth - 1.0, 0.0), 1.0)
    number, at_u, at_v = plate_cell(across, (oy - middle) / place[19] + 0.5)
    if number == -3:
        return 20.0, 44.0, 130.0
    tone = 0.2 if number == -2 else 1.0
    if number >= 0 and place[20 + number] >= 0.0:
        glyph = int(place[20 + number])
        v_ink, u_ink = int(at_v * glyphs.shape[1]), int(at_u * glyphs.shape[2])
        ink = glyphs[glyph, v_ink, u_ink] / 255.0
        tone = 1.0 - 0.88 * (sharp * ink + (1.0 - sharp) * 0.42)
    return skin[12] * tone, skin[13] * tone, skin[14] * tone


@inlined
def collect_row(
    found, near, row, scale, shift, most, slots, skins, objects, places, light, gloss, glyphs,
    columns, room,
):  # fmt: skip
    """Write the columns of a row's pixels with a skin, and what light is reckoned from.

    Gives how many there are. most: no higher number has a skin. room: see `light_row`.
    """
    v = scale * row + shift
    b, begun_a = light[9] * v + light[10], light[7] * v + light[8]
    count, column = 0, 0
    while column < len(found):
        number = found[column]
        if not 0 < number <= most or slots[number - 1] < 0:
            column += 1
            continue
        skin, begun, u = skins[slots[number - 1]], count, scale * column + shift
        x, y, z, opened = (
            np.float32(skin[0] * u + (skin[1] * v + skin[2])),
            np.float32(skin[3] * u + (skin[4] * v + skin[5])),
            np.float32(skin[6] * u + (skin[7] * v + skin[8])),
            np.float32(skin[9] * u + (skin[10] * v + skin[11])),
        )
        step_x, step_y, step_z, step_opened = (
            np.float32(scale * skin[0]), np.float32(scale * skin[3]), np.float32(scale * skin[6]),
            np.float32(scale * skin[9]),
        )  # fmt: skip
        red, green, blue = np.float32(skin[12]), np.float32(skin[13]), np.float32(skin[14])
        kind = int(skin[15])
        straight, flat, narrow = (
            np.float32(gloss[kind, 0]), np.float32(gloss[kind, 1]), np.float32(gloss[kind, 2])
        )  # fmt: skip
        while column < len(found) and found[column] == number:
            step = np.float32(count - begun)
            columns[count], room[4, count] = column, near[column]
            room[0, count], room[1, count] = x + step * step_x, y + step * step_y
            room[2, count], room[3, count] = z + step * step_z, opened + step * step_opened
            room[5, count], room[6, count], room[7, count] = red, green, blue
            room[8, count], room[9, count], room[10, count] = straight, flat, narrow
            count += 1
            column += 1
        if skin[16] > 0.0:
            place = places[objects[number - 1]]
            for each in range(begun, count):
                a = light[6] * (scale * columns[each] + shift) + begun_a
                red, green, blue = pattern_colour(
                    skin, place, glyphs, a, b, 1.0 / np.float64(room[4, each])
                )
                room[5, each], room[6, each], room[7, each] = (
                    np.float32(red), np.float32(green), np.float32(blue)
                )  # fmt: skip
    for each in range(count):
        room[4, each] = np.float32(1.0) / room[4, each]
        u = np.float32(scale) * np.float32(columns[each]) + np.float32(shift)
        room[11, each] = np.float32(light[6]) * u + np.float32(begun_a)
    return count


@inlined
def shade_row(count, b, light, cover, room, texels):
    """Write how much of the sun comes to each pixel, 0 to 1, by the picture of shadows.

    room: see `light_row`, of which three rows and texels (w) are room here.
    """
    depths, rays, lits, rights, downs, insides = (
        room[4], room[11], room[12], room[13], room[14], room[15]
    )  # fmt: skip
    none, one, byte = np.float32(0.0), np.float32(1.0), np.int32(255)
    if not light[12] > 0.0:
        lits[:count] = one
        return
    step_u, begun_u, eye_u = (
        np.float32(light[13]), np.float32(light[14] * b + light[15]), np.float32(light[16])
    )  # fmt: skip
    step_v, begun_v, eye_v = (
        np.float32(light[17]), np.float32(light[18] * b + light[19]), np.float32(light[20])
    )  # fmt: skip
    pitch, wide, high = (
        np.int32(cover.shape[1]), np.float32(cover.shape[1] - 1.0), np.float32(cover.shape[0] - 1.0)
    )  # fmt: skip
    for each in range(count):
        across = (step_u * rays[each] + begun_u) * depths[each] + eye_u
        along = (step_v * rays[each] + begun_v) * depths[each] + eye_v
        is_inside = (none <= across) & (across < wide) & (none <= along) & (along < high)
        across, along = across if is_inside else none, along if is_inside else none
        left, top = np.int32(across), np.int32(along)
        texels[each] = np.int32(np.int32(top * pitch) + left)
        rights[each], downs[each] = across - np.float32(left), along - np.float32(top)
        insides[each] = np.float32(1.0 / 255.0) if is_inside else none
    flat, beneath = cover.reshape(cover.size), np.uint32(cover.shape[1])
    for each in range(count):
        one_texel = np.uint32(texels[each])
        other = one_texel + beneath
        upper = np.int32(flat[one_texel]) | np.int32(flat[one_texel + np.uint32(1)]) << 8
        lower = np.int32(flat[other]) | np.int32(flat[other + np.uint32(1)]) << 8
        texels[each] = np.int32(upper | lower << 16)
    for each in range(count):
        word, right, down = texels[each], rights[each], downs[each]
        upper, lower = np.float32(word & byte), np.float32((word >> np.int32(16)) & byte)
        upper = (one - right) * upper + right * np.float32((word >> np.int32(8)) & byte)
        lower = (one - right) * lower + right * np.float32((word >> np.int32(24)) & byte)
        lits[each] = one - ((one - down) * upper + down * lower) * insides[each]


@inlined
def light_row(count, b, light, diffuse, room, steps):
    """Write how collected pixels are lit to the last three rows of room, what they mirror to steps.

    room (16, w): the normal's direction, x, y, z; the openness over the depth; the depth; red,
    green, blue; the shares mirrored straight on and more at flat angles, and how narrow the sun's
    image is; the ray's x; how much of the sun there is; the share mirrored, the strength of the
    light on the colour, the sun's image. (Loops over views from 0 on are done for several pixels
    at once.)
    """
    xs, ys, zs, opens, depths, rays, lits = (
        room[0], room[1], room[2], room[3], room[4], room[11], room[12]
    )  # fmt: skip
    straights, flats, narrows = room[8], room[9], room[10]
    shares, strengths, glints = room[13], room[14], room[15]
    none, one, b = np.float32(0.0), np.float32(1.0), np.float32(b)
    up_x, up_y, up_z = np.float32(light[0]), np.float32(light[1]), np.float32(light[2])
    sun_x, sun_y, sun_z = np.float32(light[3]), np.float32(light[4]), np.float32(light[5])
    axis_x, axis_y, axis_z = np.float32(light[21]), np.float32(light[22]), np.float32(light[23])
    constant, of_zenith, of_sun = (
        np.float32(diffuse[0]), np.float32(diffuse[1]), np.float32(diffuse[2])
    )  # fmt: skip
    sun_levels, rounding = np.float32(light[11]), np.float32(ROUNDING)
    for each in range(count):
        x, y, z, a = xs[each], ys[each], zs[each], rays[each]
        length = np.sqrt(x * x + y * y + z * z)
        unit = one / length if length > none else one
        x, y, z = x * unit, y * unit, z * unit
        nearer = one / np.sqrt(a * a + b * b + one)
        opened = min(max(opens[each] * depths[each], none), one)
        to_zenith, to_light = x * up_x + y * up_y + z * up_z, x * sun_x + y * sun_y + z * sun_z
        direct = of_sun * lits[each]
        strength = (constant + of_zenith * to_zenith) * opened + direct * max(to_light, none)
        # What is mirrored comes from 2 (n . v) n - v, with v = -ray / distance to the eye.
        towards = min(max(-(x * a + y * b + z) * nearer, none), one)
        twice = towards + towards
        to_up = twice * to_zenith + (a * up_x + b * up_y + up_z) * nearer
        to_sun = twice * to_light + (a * sun_x + b * sun_y + sun_z) * nearer
        to_sun = max(to_sun, np.float32(1e-3))
        to_axis = twice * (x * axis_x + y * axis_y + z * axis_z)
        to_axis += (a * axis_x + b * axis_y + axis_z) * nearer
        # Roofs and crowns stand unevenly high around.
        wave = to_axis * (np.float32(4.0) * to_axis * to_axis - np.float32(3.0))
        level = to_up - np.float32(0.05) * wave * (one + wave)
        level = min(max(np.float32(127.5) * (level + one), none), np.float32(255.0))
        steps[each] = np.int32(level)
        narrow, past = narrows[each], one - towards
        square = past * past
        broad = to_sun * to_sun
        broad *= broad
        broad *= broad
        sharp = broad * broad  # the 16th power
        sharp = sharp * sharp if narrow > np.float32(16.0) else sharp
        sharp = sharp * sharp if narrow > np.float32(32.0) else sharp
        sharp = sharp * sharp if narrow > np.float32(64.0) else sharp
        glossy = one if narrow > none else none
        shares[each] = glossy * (straights[each] + flats[each] * square * square * past) * opened
        strengths[each] = strength + glossy * np.float32(0.22) * direct * broad
        glints[each] = glossy * sun_levels * lits[each] * sharp + rounding


@inlined
def mirror_row(count, mirror, room, steps):
    """Write the colours of lit pixels over rows 0 to 2 of room; steps: rows of mirror."""
    xs, ys, zs, shares, strengths, glints = (
        room[0], room[1], room[2], room[13], room[14], room[15]
    )  # fmt: skip
    for each in range(count):
        step = np.uint32(steps[each])
        xs[each], ys[each], zs[each] = mirror[step, 0], mirror[step, 1], mirror[step, 2]
    reds, greens, blues, most = room[5], room[6], room[7], np.float32(255.0)
    for each in range(count):
        share, strength, glint = shares[each], strengths[each], glints[each]
        red, green, blue = reds[each] * strength, greens[each] * strength, blues[each] * strength
        # Light adds up, and grey levels are about its root.
        xs[each] = min(np.sqrt(red * red + share * xs[each]) + glint, most)
        ys[each] = min(np.sqrt(green * green + share * ys[each]) + glint, most)
        zs[each] = min(np.sqrt(blue * blue + share * zs[each]) + glint, most)


@kernel(
    I32_2, F32_2, FLOAT, FLOAT, I32_1, F2, I32_1, F2, F1, F1, F2, F32_2, U8_2, U8_3, OUT_F32_2,
    OUT_I32_2, OUT_U8_3, allocates=False,
)  # fmt: skip
def light_skins(
    numbers, nearness, scale, shift, slots, skins, objects, places, light, diffuse, gloss, mirror,
    cover, glyphs, room, steps, image,
):  # fmt: skip
    """Write the colours of triangles with a skin, by their numbers, into an image.

    scale, shift: from its rows and columns to pixels. slots, skins: see `prepare_skins`. objects
    (t,): rows of places (n, 30), which hold T_cam_object's rows, where wheels and plates are, and
    the plate's characters. light (24): up and sun in the camera's frame, K's inverse, grey levels
    of the sun, whether there is a cover, the way into it, and a level axis. diffuse, gloss, mirror:
    as `renderers.skins` has them. room (16, w), steps (2, w): anything.
    """
    most = np.int32(0)
    for each in range(len(slots)):
        if slots[each] >= 0:
            most = np.int32(each + 1)
    columns = steps[0]
    for row in range(numbers.shape[0]):
        count = collect_row(
            numbers[row], nearness[row], row, scale, shift, most, slots, skins, objects, places,
            light, gloss, glyphs, columns, room,
        )  # fmt: skip
        b = light[9] * (scale * row + shift) + light[10]
        shade_row(count, b, light, cover, room, steps[1])
        light_row(count, b, light, diffuse, room, steps[1])
        mirror_row(count, mirror, room, steps[1])
        colours, reds, greens, blues = image[row], room[0], room[1], room[2]
        for each in range(count):
            column = np.uint32(columns[each])
            colours[column, 0] = np.uint8(np.int32(reds[each]))
            colours[column, 1] = np.uint8(np.int32(greens[each]))
            colours[column, 2] = np.uint8(np.int32(blues[each]))
