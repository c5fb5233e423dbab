"""What is wrong with a matrix: in words, so that the doors that refuse it can say so."""

import math

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

# Largest entry of R R' - 1 that passes for a rotation of float32 or printed with a few digits.
ROTATION_TOLERANCE = 1e-3
# Of the last row, which nobody computes.
LAST_ROW_TOLERANCE = 1e-6
# Share of the largest entry or eigenvalue by which a covariance may be off through rounding.
COVARIANCE_TOLERANCE = 1e-6

# Pixels; below this a focal length is in other units (millimetres, image widths).
MIN_FOCAL_LENGTH = 5.0
# Share of the largest entry of K by which what must be 0 may be off through rounding.
ZERO_TOLERANCE = 1e-6


def rigid_fault(T: Float[Array, "4 4"]) -> str | None:
    """Why T is no rigid transform [R t; 0 1], and what it seems to be; None where it is one."""
    a, b, c, last = T.tolist()
    gram = [_dot(a, a), _dot(b, b), _dot(c, c), _dot(a, b), _dot(b, c), _dot(a, c)]
    off = max(abs(gram[0] - 1.0), abs(gram[1] - 1.0), abs(gram[2] - 1.0), *map(abs, gram[3:]))
    det = (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
    is_last = abs(last[0]) + abs(last[1]) + abs(last[2]) + abs(last[3] - 1.0) <= LAST_ROW_TOLERANCE
    is_finite = math.isfinite(a[3] + b[3] + c[3])
    if off <= ROTATION_TOLERANCE and det > 0.0 and is_last and is_finite:
        return None
    if not np.isfinite(T).all():
        row, column = np.argwhere(~np.isfinite(T))[0].tolist()
        return f"entry [{row}, {column}] is {T[row, column]}: not finite"
    if not is_last:
        if a[3] == b[3] == c[3] == 0.0 and last[3] == 1.0:
            return "transposed: the translation stands in the last row, not in the last column"
        return f"its last row is {', '.join(f'{x:g}' for x in last)}, which must be 0, 0, 0, 1"
    if off <= ROTATION_TOLERANCE:
        return "its determinant is -1: mirrored; one of its axes is reversed"
    return _stretched(gram, det)


def _dot(u: list[float], v: list[float]) -> float:
    """Of the first three numbers of two rows."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def _stretched(gram: list[float], det: float) -> str:
    """What a 3x3 block is whose rows are no orthonormal basis; gram: their products."""
    largest, smallest = max(gram[:3]), min(gram[:3])
    if largest == 0.0:
        return "its rotation is all zeros"
    if max(largest - smallest, *map(abs, gram[3:])) <= ROTATION_TOLERANCE * largest:
        mirrored = " and mirrored" if det < 0.0 else ""
        return f"its rotation is scaled by {math.sqrt(largest):.6g}{mirrored}"
    lengths = ", ".join(f"{math.sqrt(square):.6g}" for square in gram[:3])
    return (
        f"its rotation is not orthonormal: rows of lengths {lengths}, with products up to "
        f"{max(map(abs, gram[3:])):.3g}, determinant {det:.6g}"
    )


def covariance_fault(cov: Float[Array, "k k"]) -> str | None:
    """Why this is no covariance; None where it is symmetric and has no negative eigenvalue."""
    largest = float(np.abs(cov).max(initial=0.0))
    if not math.isfinite(largest):
        row, column = np.argwhere(~np.isfinite(cov))[0].tolist()
        return f"entry [{row}, {column}] is {cov[row, column]}: not finite"
    slack = COVARIANCE_TOLERANCE * largest
    skew = np.abs(cov - cov.T)
    if skew.max(initial=0.0) > slack:
        row, column = np.unravel_index(int(skew.argmax()), cov.shape)
        pair = f"[{row}, {column}] is {cov[row, column]:g}, [{column}, {row}] {cov[column, row]:g}"
        return f"not symmetric: entry {pair}"
    lowest = float(np.linalg.eigvalsh(cov)[0]) if len(cov) else 0.0
    return f"it has the negative eigenvalue {lowest:.3g}" if lowest < -slack else None


def intrinsics_fault(K: Float[Array, "..."]) -> str | None:
    """What this is instead of K = [f_x s c_x; 0 f_y c_y; 0 0 1]; None where it is one."""
    if K.shape != (3, 3):
        is_projection = K.shape == (3, 4)
        what = "a projection matrix P? Give P[:, :3]" if is_projection else "give 3x3"
        return f"of shape {K.shape}: {what}"
    (fx, skew, cx), (low, fy, cy), (left, right, one) = K.tolist()
    zero = ZERO_TOLERANCE * float(np.abs(K).max())
    below, across = max(abs(left), abs(right)), max(abs(cx), abs(cy))
    faults = (
        (not np.isfinite(K).all(), "not finite"),
        (
            below > zero >= across,
            "transposed: the principal point stands in the last row, not in the last column",
        ),
        (max(abs(low), below) > zero, "not upper triangular: is it K R, or another matrix?"),
        (min(abs(fx), abs(fy), abs(one)) <= 1e-9, "singular: a 0 stands on its diagonal"),
        (abs(one - 1.0) > ZERO_TOLERANCE, f"scaled: K[2, 2] must be 1 and is {one:g}"),
        (
            min(fx, fy) < 0.0,
            "mirrored: a focal length is negative; axes are x right, y down, z forward",
        ),
        (
            min(fx, fy) < MIN_FOCAL_LENGTH,
            "normalised or in millimetres? Focal lengths are in pixels",
        ),
        (abs(skew) > fx, "skewed by more than the focal length"),
    )
    return next((fault for is_so, fault in faults if is_so), None)
