"""Shape priors from files: ours, which is shipped, and the text files of the paper's authors."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.errors import BadFile, DatasetNotFound
from tracker.shape.basis import ShapeBasis

MAX_BYTES = 10_000_000  # unpacked; ours has 7 kB
SHIPPED_PRIOR = Path(__file__).with_name("prior.npz")

# The left half of the authors' 36 keypoints in their order; the right half follows, mirrored.
LEFT_POINTS = (
    "rear_wheel", "front_wheel",
    "front_arch_ahead", "front_arch_top_ahead", "front_arch_top_behind", "front_arch_behind",
    "rear_arch_ahead", "rear_arch_top_ahead", "rear_arch_top_behind", "rear_arch_behind",
    "rear_bumper", "taillight", "rear_window_foot", "roof_rear", "roof_front",
    "windscreen_foot", "headlight", "front_bumper",
)  # fmt: skip
# The points of one end that lie about where those of the other end do, on a car turned round.
ENDS = (
    ("rear_wheel", "front_wheel"),
    ("front_arch_ahead", "rear_arch_behind"), ("front_arch_top_ahead", "rear_arch_top_behind"),
    ("front_arch_top_behind", "rear_arch_top_ahead"), ("front_arch_behind", "rear_arch_ahead"),
    ("rear_bumper", "front_bumper"), ("taillight", "headlight"),
    ("rear_window_foot", "windscreen_foot"), ("roof_rear", "roof_front"),
)  # fmt: skip
# The 14 keypoints come in pairs, left first. Their mirrors are not among the 36.
PAIRS_14 = (
    "front_wheel", "rear_wheel", "headlight", "taillight", "mirror", "roof_front", "roof_rear"
)  # fmt: skip
KEYPOINTS_36 = tuple(f"{side}_{name}" for side in ("left", "right") for name in LEFT_POINTS)
KEYPOINTS_14 = tuple(f"{side}_{name}" for name in PAIRS_14 for side in ("left", "right"))
KEYPOINTS = (*KEYPOINTS_36, "left_mirror", "right_mirror")

# Files of a folder of the authors: mean, vectors, variances; names; from their axes to ours.
# The 36 points: x along the car, y up, z right. The 14: x left, y backwards, z up.
LAYOUTS = (
    (("meanShape.txt", "basisVectors.txt", "shapeCoefficientsInitial.txt"), KEYPOINTS_36,
     np.diag([1.0, -1.0, -1.0])),
    (("meanShape14.txt", "vectors14.txt", None), KEYPOINTS_14,
     np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])),
)  # fmt: skip


def turned_points(points: Sequence[str]) -> list[int] | None:
    """For each point, which one of them takes its place when a car turns round, about.

    None where one of them has no counterpart, as the door mirrors.
    """
    other = dict(ENDS) | {behind: ahead for ahead, behind in ENDS}
    sides, rows = {"left": "right", "right": "left"}, {name: row for row, name in enumerate(points)}
    found = []
    for name in points:
        side, _, part = name.partition("_")
        row = rows.get(f"{sides.get(side)}_{other.get(part)}")
        if row is None:
            return None
        found.append(row)
    return found


def load_prior(path: str | Path | None = None, points: Sequence[str] | None = None) -> ShapeBasis:
    """A shape prior: the shipped one, another `.npz` of ours, or a folder of the authors' files.

    Ours is in metres in the `object` frame, origin on the road under the middle of the car; it
    shares its coefficients with the simulator's fleet. The authors' comes in the same axes, but
    centred and in its own scale (36 points: cars of unit diagonal): see `ShapeBasis.scaled`.
    points: which, in which order; KEYPOINTS_36 of ours and all of theirs by default.
    Raises DatasetNotFound for a path without a prior, BadFile for one that cannot be read,
    UnknownName for a point that it does not have.
    """
    source = SHIPPED_PRIOR if path is None else Path(path)
    if source.is_dir():
        basis = _read_authors(source)
    elif source.is_file():
        basis = _read_ours(source)
        points = KEYPOINTS_36 if points is None else points
    else:
        raise DatasetNotFound(f"no shape prior at {source}: give an .npz of ours or a folder")
    return basis if points is None else basis.select(points)


def save_prior(basis: ShapeBasis, path: str | Path) -> None:
    """Write a prior as an `.npz` that `load_prior` reads; it must know its `std`."""
    std = np.full(basis.size, np.nan) if basis.std is None else basis.std
    np.savez_compressed(
        path, points=np.array(basis.points), mean=basis.mean, vectors=basis.vectors, std=std
    )


def _read_ours(path: Path) -> ShapeBasis:
    try:
        with np.load(BytesIO(path.read_bytes()), allow_pickle=False) as file:
            if sum(entry.file_size for entry in file.zip.infolist()) > MAX_BYTES:
                raise BadFile(f"{path}: unpacks to more than {MAX_BYTES:,} bytes")
            arrays = {name: file[name] for name in ("points", "mean", "vectors", "std")}
    except Exception as error:  # NumPy lets through whatever a broken file causes
        raise BadFile(f"{path} is no shape prior: {error}") from error
    mean, vectors, std = (arrays[name] for name in ("mean", "vectors", "std"))
    count = arrays["points"].size
    plain = {mean.dtype.kind, vectors.dtype.kind, std.dtype.kind} == {"f"}
    flat = std.ndim == arrays["points"].ndim == 1
    if not (plain and flat and mean.shape == (count, 3) and vectors.shape == (len(std), count, 3)):
        raise BadFile(
            f"{path}: {count} points, a mean of shape {mean.shape}, vectors of shape "
            f"{vectors.shape} and {std.shape} deviations do not belong together"
        )
    if not (np.isfinite(mean).all() and np.isfinite(vectors).all()):
        raise BadFile(f"{path}: a mean or vectors that are not finite")
    known = None if np.isnan(std).any() else std
    return ShapeBasis(tuple(str(name) for name in arrays["points"]), mean, vectors, known)


def _read_authors(folder: Path) -> ShapeBasis:
    """Mean, vectors and, where there is one, the file of variances."""
    for (mean_name, vectors_name, variances_name), points, R_object_theirs in LAYOUTS:
        if not (folder / mean_name).is_file():
            continue
        mean = _numbers(folder / mean_name, 3)
        if len(mean) != len(points):
            raise BadFile(f"{folder / mean_name}: {len(mean)} points, not {len(points)}")
        vectors = _numbers(folder / vectors_name, 3 * len(points)).reshape(-1, len(points), 3)
        std = None
        if variances_name is not None and (folder / variances_name).is_file():
            variances = _numbers(folder / variances_name, len(vectors))
            std = np.sqrt(np.maximum(variances[0], 0.0))
        return ShapeBasis(points, mean @ R_object_theirs.T, vectors @ R_object_theirs.T, std)
    wanted = " or ".join(names[0] for names, _, _ in LAYOUTS)
    raise DatasetNotFound(f"no shape prior in {folder}: it should hold {wanted}")


def _numbers(path: Path, columns: int) -> Float[Array, "n m"]:
    """The rows of a text file, each with this many finite numbers."""
    if not path.is_file():
        raise DatasetNotFound(f"the shape prior lacks {path}")
    rows = []
    for number, line in enumerate(path.read_text(errors="replace").splitlines(), start=1):
        words = line.split()
        if not words:
            continue
        try:
            row = [float(word) for word in words]
        except ValueError as error:
            raise BadFile(f"{path}:{number}: {error}") from error
        if len(row) != columns or not np.isfinite(row).all():
            raise BadFile(f"{path}:{number}: {len(row)} numbers, not {columns} finite ones")
        rows.append(row)
    if not rows:
        raise BadFile(f"{path} is empty")
    return np.array(rows)
