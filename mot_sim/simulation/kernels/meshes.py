"""The faces of meshes that look at the camera, in its frame, cut at the near plane."""

import numpy as np

from tracker.kernels.compiling import (
    F1,
    F2,
    F3,
    FLOAT,
    I2,
    INT,
    OUT3,
    OUT_I1,
    inlined,
    kernel,
)


@inlined
def meet_plane(a, b, near, met):
    """Where the edge from a to b meets the near plane; a and b lie on different sides."""
    share = (near - a[2]) / (b[2] - a[2])
    met[0] = a[0] + share * (b[0] - a[0])
    met[1] = a[1] + share * (b[1] - a[1])
    met[2] = near


@inlined
def cut_odd(a, b, c, near, corners, row):
    """Write the part of a triangle from the near plane on; a is alone behind it, or alone before.

    Gives the row after the last that is written.
    """
    if a[2] < near:  # a quadrilateral is left, that is two triangles
        meet_plane(a, b, near, corners[row, 0])
        meet_plane(a, c, near, corners[row + 1, 2])
        for axis in range(3):
            corners[row, 1, axis], corners[row, 2, axis] = b[axis], c[axis]
            corners[row + 1, 0, axis], corners[row + 1, 1, axis] = corners[row, 0, axis], c[axis]
        return row + 2
    for axis in range(3):
        corners[row, 0, axis] = a[axis]
    meet_plane(a, b, near, corners[row, 1])
    meet_plane(a, c, near, corners[row, 2])
    return row + 1


@inlined
def write_part(a, b, c, near, corners, row):
    """Write the part of a triangle from the near plane on; the row after the last of it.

    The odd corner comes first where it is cut; its sense of rotation stays.
    """
    behind_a, behind_b, behind_c = a[2] < near, b[2] < near, c[2] < near
    if not (behind_a or behind_b or behind_c):
        for axis in range(3):
            corners[row, 0, axis] = a[axis]
            corners[row, 1, axis] = b[axis]
            corners[row, 2, axis] = c[axis]
        return row + 1
    if behind_a and behind_b and behind_c:
        return row
    if behind_b == behind_c:
        return cut_odd(a, b, c, near, corners, row)
    if behind_a == behind_c:
        return cut_odd(b, c, a, near, corners, row)
    return cut_odd(c, a, b, near, corners, row)


@kernel(F3, FLOAT, OUT3, OUT_I1)
def cut_triangles(triangles, near, corners, numbers):
    """Write the parts (2 t, 3, 3) of triangles (t, 3, 3) from the near plane on, and their rows.

    Gives how many parts there are.
    """
    row = 0
    for triangle in range(len(triangles)):
        a, b, c = triangles[triangle, 0], triangles[triangle, 1], triangles[triangle, 2]
        after = write_part(a, b, c, near, corners, row)
        for each in range(row, after):
            numbers[each] = triangle
        row = after
    return row


@kernel(F2, I2, F2, F1, F2, FLOAT, INT, OUT3, OUT_I1)
def place_faces(vertices, faces, normals, offsets, T_cam_object, near, row, corners, numbers):
    """Write the faces of a mesh that look at the camera, and their numbers, from a row on.

    Gives the row after the last. A face that the near plane cuts in two takes two rows.
    """
    placed, eye = np.empty((len(vertices), 3)), np.zeros(3)  # eye: the camera, seen by the object
    for axis in range(3):
        for each in range(3):
            eye[axis] -= T_cam_object[each, axis] * T_cam_object[each, 3]
    for vertex in range(len(vertices)):
        x, y, z = vertices[vertex, 0], vertices[vertex, 1], vertices[vertex, 2]
        for axis in range(3):
            placed[vertex, axis] = (
                T_cam_object[axis, 0] * x + T_cam_object[axis, 1] * y
                + T_cam_object[axis, 2] * z + T_cam_object[axis, 3]
            )  # fmt: skip
    for face in range(len(faces)):
        towards = normals[face, 0] * eye[0] + normals[face, 1] * eye[1] + normals[face, 2] * eye[2]
        if towards > offsets[face]:
            a, b, c = placed[faces[face, 0]], placed[faces[face, 1]], placed[faces[face, 2]]
            after = write_part(a, b, c, near, corners, row)
            for each in range(row, after):
                numbers[each] = face
            row = after
    return row
