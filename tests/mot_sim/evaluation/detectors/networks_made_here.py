"""Tiny networks that find red squares: a box a cell of 16 pixels, its score how red it is."""

from pathlib import Path

import numpy as np
import onnx
from numpy import ndarray as Array
from onnx import TensorProto, helper, numpy_helper

CELL, WIDTH, HEIGHT = 16, 160, 96
CELLS = (HEIGHT // CELL) * (WIDTH // CELL)
# Types and shapes of outputs by their names, and by the family.
SHAPES = {
    ("out", "v8"): (TensorProto.FLOAT, [1, 5, CELLS]),
    ("out", "v5"): (TensorProto.FLOAT, [1, CELLS, 6]),
    ("out", "rows"): (TensorProto.FLOAT, [1, CELLS, 6]),
    ("boxes", "ssd"): (TensorProto.FLOAT, [1, CELLS, 4]),
    ("scores", "ssd"): (TensorProto.FLOAT, [1, CELLS, 2]),
    ("boxes", "torchvision"): (TensorProto.FLOAT, [1, CELLS, 4]),
    ("scores", "torchvision"): (TensorProto.FLOAT, [1, CELLS]),
    ("labels", "torchvision"): (TensorProto.INT64, [1, CELLS]),
}


def cells() -> Array:
    """x_min, y_min, x_max, y_max of every cell, px."""
    rows, columns = np.mgrid[: HEIGHT // CELL, : WIDTH // CELL]
    low = np.stack((columns.ravel(), rows.ravel()), axis=1) * CELL
    return np.concatenate((low, low + CELL), axis=1).astype(np.float32)


def write_network(
    path: Path, family: str, names: dict[int, str] | None = None, scale: float = 1.0
) -> Path:
    """A network of a family: v8, v5, rows, ssd (a score a class) or torchvision (three outputs).

    scale: what its pixels are divided by before they count.
    """
    boxes = cells()
    red = np.array([1.0, -1.0, 0.0], np.float32).reshape(1, 3, 1, 1) / np.float32(scale)
    constants, nodes = {"red": red}, []

    def node(kind: str, inputs: list[str], output: str, **settings: object) -> None:
        nodes.append(helper.make_node(kind, inputs, [output], **settings))

    def constant(name: str, values: Array) -> str:
        constants[name] = np.asarray(values)
        return name

    node("Conv", ["image", "red"], "redness")
    node("Relu", ["redness"], "positive")
    shape = [CELL, CELL]
    node("AveragePool", ["positive"], "pooled", kernel_shape=shape, strides=shape)
    one = np.ones((1, CELLS, 1), np.float32)
    node("Reshape", ["pooled", constant("column", np.array([1, CELLS, 1]))], "score")
    centres = np.concatenate(((boxes[:, :2] + boxes[:, 2:]) / 2, boxes[:, 2:] - boxes[:, :2]), 1)
    outputs = ["out"]
    if family == "v8":
        node("Concat", [constant("boxes", centres[None]), "score"], "rows", axis=2)
        node("Transpose", ["rows"], "out", perm=[0, 2, 1])
    elif family == "v5":
        node(
            "Concat",
            [constant("boxes", centres[None]), "score", constant("one", one)],
            "out",
            axis=2,
        )
    elif family == "rows":
        parts = [constant("boxes", boxes[None]), "score", constant("label", 0.0 * one)]
        node("Concat", parts, "out", axis=2)
    else:
        outputs = ["boxes", "scores"]
        shares = boxes / np.float32([WIDTH, HEIGHT, WIDTH, HEIGHT])
        zero = constant("zero", np.zeros((1, CELLS, 4), np.float32))
        node("Add", [zero, constant("shares", shares[None])], "boxes")
        if family == "ssd":
            node("Concat", [constant("none", 0.0 * one), "score"], "scores", axis=2)
        else:
            node("Reshape", ["score", constant("row", np.array([1, CELLS]))], "scores")
            outputs.append("labels")
            node(
                "Add",
                [constant("three", np.full((1, CELLS), 2)), constant("more", np.int64([[1]]))],
                "labels",
            )
    graph = helper.make_graph(
        nodes,
        "red squares",
        [helper.make_tensor_value_info("image", TensorProto.FLOAT, [1, 3, HEIGHT, WIDTH])],
        [helper.make_tensor_value_info(name, *SHAPES[name, family]) for name in outputs],
        [numpy_helper.from_array(values, name) for name, values in constants.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    if names is not None:
        helper.set_model_props(model, {"names": repr(names)})
    onnx.save(model, path)
    return path


def image_with(squares: list[tuple[int, int]], size: tuple[int, int] = (WIDTH, HEIGHT)) -> Array:
    """A grey RGB image with red squares of a cell in these columns and rows of cells."""
    image = np.full((size[1], size[0], 3), 90, np.uint8)
    for column, row in squares:
        at = row * CELL, column * CELL
        image[at[0] : at[0] + CELL, at[1] : at[1] + CELL] = 230, 20, 90
    return image
