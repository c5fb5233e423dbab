"""Cars as files: a user's own OBJ or GLB comes in, a car of the fleet goes out as GLB."""

import logging
from pathlib import Path

import numpy as np
import trimesh
from jaxtyping import Float
from numpy import ndarray as Array
from trimesh.exchange.gltf import export_glb
from trimesh.resolvers import FilePathResolver

from mot_sim.simulation.cars.carshape import PART_COLOURS, CarShape, Paint, paint_colour
from mot_sim.simulation.cars.fleet import Fleet, load_fleet
from mot_sim.simulation.cars.topology import PARTS
from tracker.errors import BadConfig, BadFile, BadOutput, UnknownName

logger = logging.getLogger(__name__)

FORMATS = (".glb", ".gltf", ".obj", ".off", ".ply", ".stl")
AXES = {
    f"{sign}{name}": scale * np.eye(3)[axis]
    for sign, scale in (("+", 1.0), ("-", -1.0))
    for axis, name in enumerate("xyz")
}
# Metres, if the file is in metres: no car is thinner, or has a corner farther out.
MIN_EXTENT_METRES = 1e-6
MAX_COORDINATE_METRES = 1e9
# From our axes (forward, down, left) to glTF's: x left, y up, z forward.
R_GLTF_OBJECT = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])


class Beside(FilePathResolver):
    """Finds the files that a mesh file names (materials, textures, buffers): beside it, or below.

    trimesh's own follows any path that the file spells.
    """

    def get(self, name: str) -> bytes:
        """The bytes of a file. Raises BadFile for one in another folder."""
        home = Path(self.parent).resolve()
        found = (home / name.strip()).resolve()
        if not found.is_relative_to(home):
            raise BadFile(f"{self.file_path}: it names {name}, outside its folder; put it beside")
        return found.read_bytes()

    def namespaced(self, namespace: str) -> "Beside":
        """Itself: a mesh file has one folder."""
        return self


def load_car(
    path: str | Path, forward: str = "+z", up: str = "+y", length: float | None = None
) -> CarShape:
    """A car from a mesh file, in the `object` frame, its tight box standing on the origin.

    forward, up: axes of the file along which the car drives and stands (glTF's unless told).
    length: metres; the whole car is scaled to it, evenly. None: the file is in metres.
    Any shape may be given; a mesh that is not watertight is taken, and the log says so. The car
    is of paint all over and has no keypoints. Raises BadFile for a file that holds no mesh,
    UnknownName for an axis, BadConfig for axes that are not square or a length that is none.
    """
    R_object_file = _axes(forward, up)
    if length is not None and not 0.0 < length < np.inf:
        raise BadConfig(f"a car {length:g} m long: give a length > 0, or none")
    mesh = _read(Path(path))
    if not (np.abs(mesh.vertices) <= MAX_COORDINATE_METRES).all():
        raise BadFile(
            f"{path}: a corner that is not within {MAX_COORDINATE_METRES:g} of the origin"
        )
    vertices = np.asarray(mesh.vertices, dtype=float) @ R_object_file.T
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    if not (high - low > MIN_EXTENT_METRES).all():
        raise BadFile(f"{path}: a flat mesh, {(high - low).tolist()} long, high and wide")
    middle = 0.5 * (low + high)
    vertices = vertices - np.array([middle[0], high[1], middle[2]])
    if length is not None:
        vertices = vertices * (length / (high - low)[0])
    if not mesh.is_watertight:
        logger.warning("%s is not watertight: its volume and its inside mean little", path)
    faces = np.asarray(mesh.faces, dtype=np.int64)
    none = np.zeros(len(faces), dtype=np.int64)
    return CarShape(vertices, faces, none, none)


def export_car(
    coefficients: Float[Array, " b"],
    path: str | Path,
    paint: Paint = "silver",
    fleet: Fleet | None = None,
) -> Path:
    """Write the car of these coefficients as GLB, a mesh a part, in glTF's axes; gives the path.

    Raises BadConfig for coefficients outside the population, UnknownName for a paint, BadOutput
    for a path that is no `.glb` or cannot be written.
    """
    target = Path(path)
    if target.suffix.lower() != ".glb":
        raise BadOutput(f"{target}: cars are written as GLB; end the name in .glb")
    fleet = load_fleet(len(coefficients)) if fleet is None else fleet
    car = fleet.car(coefficients)
    colours = {"paint": paint_colour(paint), **PART_COLOURS}
    vertices = car.vertices @ R_GLTF_OBJECT.T
    scene = trimesh.Scene()
    for number, part in enumerate(PARTS):
        used, faces = np.unique(car.faces[car.parts == number], return_inverse=True)
        colour = np.tile(np.array((*colours[part], 255), dtype=np.uint8), (len(used), 1))
        mesh = trimesh.Trimesh(
            vertices[used], faces.reshape(-1, 3), vertex_colors=colour, process=False
        )
        scene.add_geometry(mesh, node_name=part, geom_name=part)
    content: bytes = export_glb(scene)  # type: ignore[no-untyped-call]
    try:
        target.write_bytes(content)
    except OSError as error:
        raise BadOutput(f"{target}: {error.strerror}") from error
    return target


def _axes(forward: str, up: str) -> Float[Array, "3 3"]:
    """The rotation from the file's axes to forward, down, left."""
    for axis in (forward, up):
        if axis not in AXES:
            raise UnknownName.of("axis", axis, AXES)
    if forward[1] == up[1]:
        raise BadConfig(f"forward {forward} and up {up} are one axis: give two")
    return np.stack((AXES[forward], -AXES[up], np.cross(AXES[up], AXES[forward])))


def _read(path: Path) -> trimesh.Trimesh:
    """One mesh of everything in a file."""
    if not path.is_file():
        raise BadFile(f"no mesh file {path}")
    if path.suffix.lower() not in FORMATS:
        raise BadFile(f"{path}: not a format of meshes known here: {', '.join(FORMATS)}")
    try:
        with path.open("rb") as file:
            resolver = Beside(str(path))
            mesh = trimesh.load_mesh(file, file_type=path.suffix[1:].lower(), resolver=resolver)
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
    except Exception as error:  # trimesh's readers let through whatever a broken file causes
        raise BadFile(f"{path} is no {path.suffix[1:]} mesh: {error or type(error)}") from error
    if not isinstance(mesh, trimesh.Trimesh) or mesh.is_empty or not len(mesh.faces):
        raise BadFile(f"{path} holds no faces")
    if np.shape(mesh.vertices)[1:] != (3,) or np.shape(mesh.faces)[1:] != (3,):
        raise BadFile(f"{path}: corners or faces without three numbers")
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise BadFile(f"{path}: a face names a corner that is not there")
    return mesh
