"""The faces of meshes that look at the camera, in its frame, cut at the near plane."""

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
def meet_plane(a, b, near):
    """Where the edge from a to b meets the near plane; a and b lie on different sides."""
    share = (near - a[2]) / (b[2] - a[2])
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), near


@inlined
def write_triangle(a, b, c, corners, row):
    """Write three corners, x, y, z each, to a row."""
    corners[row, 0, 0], corners[row, 0, 1], corners[row, 0, 2] = a
    corners[row, 1, 0], corners[row, 1, 1], corners[row, 1, 2] = b
    corners[row, 2, 0], corners[row, 2, 1], corners[row, 2, 2] = c


@inlined
def cut_odd(a, b, c, near, corners, row):
    """Write the part of a triangle from the near plane on; a is alone behind it, or alone before.

    Gives the row after the last that is written.
    """
    ab, ac = meet_plane(a, b, near), meet_plane(a, c, near)
    if a[2] < near:  # a quadrilateral is left, that is two triangles
        write_triangle(ab, b, c, corners, row)
        write_triangle(ab, c, ac, corners, row + 1)
        return row + 2
    write_triangle(a, ab, ac, corners, row)
    return row + 1


@inlined
def write_part(a, b, c, near, corners, row):
    """Write the part of a triangle from the near plane on; the row after the last of it.

    a, b, c: x, y, z of the corners. The odd one comes first where it is cut; the sense of rotation
    stays.
    """
    behind_a, behind_b, behind_c = a[2] < near, b[2] < near, c[2] < near
    if not (behind_a or behind_b or behind_c):
        write_triangle(a, b, c, corners, row)
        return row + 1
    if behind_a and behind_b and behind_c:
        return row
    if behind_b == behind_c:
        return cut_odd(a, b, c, near, corners, row)
    if behind_a == behind_c:
        return cut_odd(b, c, a, near, corners, row)
    return cut_odd(c, a, b, near, corners, row)


@inlined
def corner_of(triangles, row, corner):
    """x, y, z of a triangle's corner."""
    return triangles[row, corner, 0], triangles[row, corner, 1], triangles[row, corner, 2]


@kernel(F3, FLOAT, OUT3, OUT_I1, allocates=False)
def cut_triangles(triangles, near, corners, numbers):
    """Write the parts (2 t, 3, 3) of triangles (t, 3, 3) from the near plane on, and their rows.

    Gives how many parts there are.
    """
    row = 0
    for triangle in range(len(triangles)):
        a, b = corner_of(triangles, triangle, 0), corner_of(triangles, triangle, 1)
        after = write_part(a, b, corner_of(triangles, triangle, 2), near, corners, row)
        for each in range(row, after):
            numbers[each] = triangle
        row = after
    return row


@inlined
def placed(T, vertices, vertex):
    """A vertex (x, y, z), moved by T (4, 4)."""
    x, y, z = vertices[vertex, 0], vertices[vertex, 1], vertices[vertex, 2]
    return (
        T[0, 0] * x + T[0, 1] * y + T[0, 2] * z + T[0, 3],
        T[1, 0] * x + T[1, 1] * y + T[1, 2] * z + T[1, 3],
        T[2, 0] * x + T[2, 1] * y + T[2, 2] * z + T[2, 3],
    )


@kernel(F2, I2, F2, F1, F2, FLOAT, INT, OUT3, OUT_I1, allocates=False)
def place_faces(vertices, faces, normals, offsets, T_cam_object, near, row, corners, numbers):
    """Write the faces of a mesh that look at the camera, and their numbers, from a row on.

    Gives the row after the last. A face that the near plane cuts in two takes two rows. (To move
    the corners of each face costs less than to move all vertices first: most faces are not seen.)
    """
    T, x, y, z = T_cam_object, 0.0, 0.0, 0.0  # x, y, z: the camera, seen by the object
    for each in range(3):
        x -= T[each, 0] * T[each, 3]
        y -= T[each, 1] * T[each, 3]
        z -= T[each, 2] * T[each, 3]
    for face in range(len(faces)):
        if normals[face, 0] * x + normals[face, 1] * y + normals[face, 2] * z > offsets[face]:
            a, b = placed(T, vertices, faces[face, 0]), placed(T, vertices, faces[face, 1])
            c = placed(T, vertices, faces[face, 2])
            after = write_part(a, b, c, near, corners, row)
            for each in range(row, after):
                numbers[each] = face
            row = after
    return row
