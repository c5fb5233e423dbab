"""Surfaces lit pixel by pixel: bodywork and glass between the normals of their corners."""

from math import sqrt

import numpy as np

from mot_sim.simulation.kernels.compiling import (
    F32_2,
    I32_1,
    I32_2,
    OUT_I32_1,
    OUT_U8_3,
    U8_2,
    U8_3,
)
from tracker.kernels.compiling import F1, F2, F3, FLOAT, I1, I2, INT, OUT2, OUT_B1, inlined, kernel

ROUNDING = 1e-3  # so that 99.99999 is 100
TINY_VOLUME = 1e-9  # m^3: the eye lies in the plane of a face


@kernel(F2, I2, F3, F2, U8_2, I1, F2, F2, INT, I1, OUT_B1, OUT_I32_1, OUT2)
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
    R, corners, slot = T_cam_object[:3, :3], np.empty((3, 3)), start
    inverse, turned = np.empty((3, 3)), np.empty((3, 3))
    for each in range(len(rows)):
        if not seen[each]:
            continue
        face = rows[each]
        for corner in range(3):
            vertex = vertices[faces[face, corner]]
            for axis in range(3):
                corners[corner, axis] = (
                    R[axis, 0] * vertex[0] + R[axis, 1] * vertex[1] + R[axis, 2] * vertex[2]
                    + T_cam_object[axis, 3]
                )  # fmt: skip
        volume = 0.0
        for corner in range(3):  # the rows of the inverse are the cross products of the others
            a, b = corners[(corner + 1) % 3], corners[(corner + 2) % 3]
            for axis in range(3):
                one, two = (axis + 1) % 3, (axis + 2) % 3
                inverse[corner, axis] = a[one] * b[two] - a[two] * b[one]
            if corner == 0:
                volume = (
                    inverse[0, 0] * corners[0, 0] + inverse[0, 1] * corners[0, 1]
                    + inverse[0, 2] * corners[0, 2]
                )  # fmt: skip
        skin, is_edge_on = skins[slot], abs(volume) < TINY_VOLUME
        for corner in range(3):
            for axis in range(3):
                turned[corner, axis] = (
                    R[axis, 0] * normals[face, corner, 0] + R[axis, 1] * normals[face, corner, 1]
                    + R[axis, 2] * normals[face, corner, 2]
                )  # fmt: skip
        for column in range(3):
            skin[9 + column] = 0.0
            for axis in range(3):
                skin[3 * axis + column] = 0.0
            for corner in range(3):
                if is_edge_on:
                    share = 1.0 if column == 2 else 0.0
                else:
                    share = (
                        inverse[corner, 0] * K_inverse[0, column]
                        + inverse[corner, 1] * K_inverse[1, column]
                        + inverse[corner, 2] * K_inverse[2, column]
                    ) / volume
                for axis in range(3):
                    skin[3 * axis + column] += share * turned[corner, axis]
                if is_edge_on:
                    share /= 3.0 * corners[corner, 2]
                skin[9 + column] += share * openness[face, corner]
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


@kernel(
    I32_2, F32_2, FLOAT, FLOAT, I32_1, F2, I32_1, F2, F1, F2, F2, F2, U8_2, U8_3, OUT_U8_3,
    allocates=False,
)  # fmt: skip
def light_skins(  # noqa: PLR0915 (see its last line)
    numbers, nearness, scale, shift, slots, skins, objects, places, light, diffuse, gloss, mirror,
    cover, glyphs, image,
):  # fmt: skip
    """Write the colours of triangles with a skin, by their numbers, into an image.

    scale, shift: from its rows and columns to pixels. slots, skins: see `prepare_skins`. objects
    (t,): rows of places (n, 30), which hold T_cam_object's rows, where wheels and plates are, and
    the plate's characters. light (24): up and sun in the camera's frame, K's inverse, grey levels
    of the sun, whether there is a cover, the way into it, and a level axis. diffuse, gloss, mirror:
    as `renderers.skins` has them. (One function: a call with many arrays takes 0.2 us.)
    """
    for row in range(numbers.shape[0]):
        for column in range(numbers.shape[1]):
            triangle = numbers[row, column] - 1
            if triangle < 0 or slots[triangle] < 0:
                continue
            slot, place = slots[triangle], objects[triangle]
            u, v = scale * column + shift, scale * row + shift
            depth = 1.0 / np.float64(nearness[row, column])
            x, y, z = (
                skins[slot, 0] * u + skins[slot, 1] * v + skins[slot, 2],
                skins[slot, 3] * u + skins[slot, 4] * v + skins[slot, 5],
                skins[slot, 6] * u + skins[slot, 7] * v + skins[slot, 8],
            )
            length = sqrt(x * x + y * y + z * z)
            if length > 0.0:
                unit = 1.0 / length
                x, y, z = x * unit, y * unit, z * unit
            a, b = light[6] * u + light[7] * v + light[8], light[9] * v + light[10]
            distance = sqrt(a * a + b * b + 1.0)
            opened = min(
                max((skins[slot, 9] * u + skins[slot, 10] * v + skins[slot, 11]) * depth, 0.0), 1.0
            )
            to_zenith = x * light[0] + y * light[1] + z * light[2]
            to_light = x * light[3] + y * light[4] + z * light[5]
            lit = 1.0
            if light[12] > 0.0:
                across = (light[13] * a + light[14] * b + light[15]) * depth + light[16]
                along = (light[17] * a + light[18] * b + light[19]) * depth + light[20]
                if 0.0 <= across < cover.shape[1] - 1.0 and 0.0 <= along < cover.shape[0] - 1.0:
                    left, top = int(across), int(along)
                    right, down = across - left, along - top
                    upper = (1.0 - right) * cover[top, left] + right * cover[top, left + 1]
                    lower = (1.0 - right) * cover[top + 1, left] + right * cover[top + 1, left + 1]
                    lit = 1.0 - ((1.0 - down) * upper + down * lower) * (1.0 / 255.0)
            kind, pattern = int(skins[slot, 15]), skins[slot, 16]
            base = diffuse[kind, 0] + diffuse[kind, 1] * to_zenith
            direct = diffuse[kind, 2] * lit
            strength = base * opened + direct * max(to_light, 0.0)
            red, green, blue = skins[slot, 12], skins[slot, 13], skins[slot, 14]
            if pattern > 0.0:
                dx, dy, dz = (
                    a * depth - places[place, 3],
                    b * depth - places[place, 7],
                    depth - places[place, 11],
                )
                ox = places[place, 0] * dx + places[place, 4] * dy + places[place, 8] * dz
                oy = places[place, 1] * dx + places[place, 5] * dy + places[place, 9] * dz
                oz = places[place, 2] * dx + places[place, 6] * dy + places[place, 10] * dz
                if pattern == 1.0:
                    hub = places[place, 12] if ox > 0.0 else places[place, 13]
                    sharp = min(max(40.0 / depth - 1.0, 0.0), 1.0)
                    red = green = blue = wheel_tone(
                        (ox - hub) / places[place, 14], oy / places[place, 15] + 1.0, sharp
                    )
                else:
                    is_front = ox > 0.0
                    middle, half = (
                        places[place, 16] if is_front else places[place, 17],
                        places[place, 18],
                    )
                    down = (oy - middle) / places[place, 19] + 0.5
                    across = 0.5 + 0.5 * (oz if is_front else -oz) / half
                    sharp = min(max(30.0 / depth - 1.0, 0.0), 1.0)
                    number, at_u, at_v = plate_cell(across, down)
                    tone = 0.2 if number == -2 else 1.0
                    if number >= 0 and places[place, 20 + number] >= 0.0:
                        glyph = int(places[place, 20 + number])
                        v_ink, u_ink = int(at_v * glyphs.shape[1]), int(at_u * glyphs.shape[2])
                        ink = glyphs[glyph, v_ink, u_ink] / 255.0
                        tone = 1.0 - 0.88 * (sharp * ink + (1.0 - sharp) * 0.42)
                    if number == -3:
                        red, green, blue = 20.0, 44.0, 130.0
                    else:
                        red, green, blue = red * tone, green * tone, blue * tone
            straight, flat, narrow = gloss[kind, 0], gloss[kind, 1], gloss[kind, 2]
            if not narrow > 0.0:
                image[row, column, 0] = np.uint8(min(red * strength + ROUNDING, 255.0))
                image[row, column, 1] = np.uint8(min(green * strength + ROUNDING, 255.0))
                image[row, column, 2] = np.uint8(min(blue * strength + ROUNDING, 255.0))
                continue
            nearer = 1.0 / distance
            towards = min(max(-(x * a + y * b + z) * nearer, 0.0), 1.0)
            # What is mirrored comes from 2 (n . v) n - v, with v = -ray / distance to the eye.
            along_up = (a * light[0] + b * light[1] + light[2]) * nearer
            along_sun = (a * light[3] + b * light[4] + light[5]) * nearer
            along_axis = (a * light[21] + b * light[22] + light[23]) * nearer
            to_up = 2.0 * towards * to_zenith + along_up
            to_sun = max(2.0 * towards * to_light + along_sun, 1e-3)
            to_axis = 2.0 * towards * (x * light[21] + y * light[22] + z * light[23]) + along_axis
            # Roofs and crowns stand unevenly high around.
            wave = to_axis * (4.0 * to_axis * to_axis - 3.0)
            level = to_up - 0.05 * wave * (1.0 + wave)
            seen = int(min(max(127.5 * (level + 1.0), 0.0), 255.0))
            past, broad = (1.0 - towards) * (1.0 - towards), to_sun * to_sun
            share = (straight + flat * past * past * (1.0 - towards)) * opened
            broad *= broad
            broad *= broad
            strength += 0.22 * direct * broad
            sharp = broad * broad  # the 16th power
            while narrow > 16.0:
                sharp *= sharp
                narrow *= 0.5
            glint = light[11] * lit * sharp
            red, green, blue = red * strength, green * strength, blue * strength
            # Light adds up, and grey levels are about its root.
            value = sqrt(red * red + share * mirror[seen, 0]) + glint + ROUNDING
            image[row, column, 0] = np.uint8(min(value, 255.0))
            value = sqrt(green * green + share * mirror[seen, 1]) + glint + ROUNDING
            image[row, column, 1] = np.uint8(min(value, 255.0))
            value = sqrt(blue * blue + share * mirror[seen, 2]) + glint + ROUNDING
            image[row, column, 2] = np.uint8(min(value, 255.0))
