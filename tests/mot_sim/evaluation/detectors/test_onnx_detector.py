"""Detectors in ONNX files: every family of heads, by both libraries; what cannot be."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from mot_sim.evaluation.detectors import BACKENDS, HEADS, OnnxDetector
from mot_sim.evaluation.detectors.heads import boxes_of_outputs
from tests.mot_sim.evaluation.detectors.networks_made_here import (
    HEIGHT,
    WIDTH,
    image_with,
    write_network,
)
from tracker.errors import BadConfig, BadWeights, UnknownName

CAR = {0: "car"}
FAMILIES = {"v8": "yolo", "v5": "yolo", "rows": "rows", "ssd": "ssd", "torchvision": "ssd"}


def named(family: str) -> dict[int, str] | None:
    return {"ssd": {0: "nothing", 1: "car"}, "torchvision": None}.get(family, CAR)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_finds_the_squares_where_they_are(
    tmp_path: Path, family: str, backend: str
) -> None:
    path = write_network(tmp_path / "net.onnx", family)
    size = (WIDTH, HEIGHT) if backend == "opencv" else None
    detector = OnnxDetector.load(path, backend, size, names=named(family))
    assert detector.head == FAMILIES[family]
    found = detector(image_with([(2, 1), (7, 4)]))
    order = np.argsort(found.boxes[:, 0])
    expected = [[32.0, 16.0, 48.0, 32.0], [112.0, 64.0, 128.0, 80.0]]
    np.testing.assert_allclose(found.boxes[order], expected, atol=1e-3)
    np.testing.assert_allclose(found.scores, 210.0 / 255.0, atol=1e-3)
    assert found.kinds is not None
    assert found.kinds.tolist() == ["Car", "Car"]


def test_images_of_another_shape_get_their_own_pixels_back(tmp_path: Path) -> None:
    path = write_network(tmp_path / "net.onnx", "v8", CAR)
    image = cv2.resize(image_with([(3, 2)]), (2 * WIDTH, 2 * HEIGHT), interpolation=0)
    wide = np.pad(image, ((0, 0), (0, 2 * WIDTH), (0, 0)), mode="edge")  # half as high, then
    boxed, stretched = (
        OnnxDetector.load(path, fit=fit)(each)
        for fit, each in (("letterbox", image), ("stretch", wide))
    )
    np.testing.assert_allclose(boxed.boxes, [[96.0, 64.0, 128.0, 96.0]], atol=1e-3)
    assert boxed.scores[0] == pytest.approx(210.0 / 255.0, abs=1e-3)
    assert len(stretched) == 1  # half a cell, half as red
    assert stretched.boxes[0, 0] < 96.0 + 16.0 < stretched.boxes[0, 2]


def test_names_come_from_the_file_or_the_user_and_select_the_classes(tmp_path: Path) -> None:
    both = {0: "person", 1: "car"}
    path = write_network(tmp_path / "net.onnx", "ssd", both)
    image = image_with([(1, 1)])
    assert OnnxDetector.load(path)(image).kinds.tolist() == ["Car"]
    assert len(OnnxDetector.load(path, kinds=("Pedestrian",))(image)) == 0
    with pytest.raises(BadWeights, match=r"no class Cyclist .*\(person, car\).*--names"):
        OnnxDetector.load(path, kinds=("Cyclist",))
    with pytest.raises(BadWeights, match=r"not known.*--names"):
        OnnxDetector.load(write_network(tmp_path / "unnamed.onnx", "v8"))


def test_what_networks_were_trained_on_is_told(tmp_path: Path) -> None:
    path = write_network(tmp_path / "net.onnx", "v8", CAR, scale=255.0)
    image = image_with([(2, 2)])
    assert len(OnnxDetector.load(path)(image)) == 0  # too dark for it
    found = OnnxDetector.load(path, pixels="rgb255")(image)
    assert found.scores[0] == pytest.approx(210.0 / 255.0, abs=1e-3)
    turned = OnnxDetector.load(path, pixels="bgr255")(image)
    assert turned.scores[0] == pytest.approx(70.0 / 255.0, abs=1e-3)  # blue less green
    blue = np.ascontiguousarray(image[:, :, [2, 1, 0]])
    found = OnnxDetector.load(path, pixels="bgr255")(blue)
    assert found.scores[0] == pytest.approx(210.0 / 255.0, abs=1e-3)


def test_twins_are_dropped_and_neighbours_are_not() -> None:
    rows = np.array([
        [50.0, 50.0, 20.0, 20.0, 0.9], [51.0, 50.0, 20.0, 20.0, 0.8], [80.0, 50.0, 20.0, 20.0, 0.7],
        [120.0, 50.0, 20.0, 20.0, 0.05], [90.0, 50.0, 0.0, 20.0, 0.9],
    ], np.float32)  # fmt: skip

    class Network:
        input_size, is_byte, rank, channels_last, class_names = None, False, 4, False, CAR

        def run(self, pixels: np.ndarray) -> dict[str, np.ndarray]:
            return {"out": rows[None]}

    detector = OnnxDetector(Network(), "made", (160, 100))
    found = detector(np.zeros((100, 160, 3), np.uint8))
    np.testing.assert_allclose(found.scores, [0.9, 0.7])
    np.testing.assert_allclose(found.boxes[0], [40.0, 40.0, 60.0, 60.0])
    outside = detector(np.zeros((50, 60, 3), np.uint8))  # scale 2
    assert (outside.boxes[:, 2] <= 59.0).all()


def test_heads_that_others_export_are_told_apart() -> None:
    size, none = (160, 100), {}
    coco = np.zeros((1, 84, 50), np.float32)
    assert boxes_of_outputs({"out": coco}, size, none, None, "v8")[0] == "yolo"
    coco = np.zeros((1, 50, 85), np.float32)
    coco[0, 3] = 0.5
    coco[0, 3, 4:7] = 0.9, 0.1, 0.2
    head, found = boxes_of_outputs({"out": coco}, size, none, None, "v5")
    assert (head, found.names[2], found.scores.max()) == ("yolo", "car", pytest.approx(0.45))
    np.testing.assert_allclose(found.boxes[3], [40.0, 25.0, 120.0, 75.0])  # shares
    caffe = np.array([[0, 7, 0.8, 0.1, 0.2, 0.3, 0.4], [-1, 0, 0, 0, 0, 0, 0]], np.float32)
    head, found = boxes_of_outputs({"out": caffe[None, None]}, size, none, None, "caffe")
    assert (head, found.names[7], len(found.boxes)) == ("rows", "car", 1)
    np.testing.assert_allclose(found.boxes, [[16.0, 20.0, 48.0, 40.0]])
    tensorflow = {
        "detection_boxes": np.array([[[0.2, 0.1, 0.4, 0.3]]], np.float32),
        "detection_classes": np.array([[3.0]], np.float32),
        "detection_scores": np.array([[0.7]], np.float32),
        "num_detections": np.array([1.0], np.float32),
    }
    head, found = boxes_of_outputs(tensorflow, size, none, None, "tensorflow")
    assert (head, found.labels.tolist(), found.scores.tolist()) == (
        "ssd",
        [3],
        [pytest.approx(0.7)],
    )
    np.testing.assert_allclose(found.boxes, [[16.0, 20.0, 48.0, 40.0]])
    nothing = {"boxes": np.zeros((0, 4)), "labels": np.zeros(0, int), "scores": np.zeros(0)}
    assert len(boxes_of_outputs(nothing, size, none, None, "torchvision")[1].boxes) == 0


@pytest.mark.parametrize("backend", BACKENDS)
def test_files_that_are_no_detectors_are_named(tmp_path: Path, backend: str) -> None:
    bad = tmp_path / "bad.onnx"
    bad.write_bytes(b"\x08\x07no network at all")
    for path, words in ((bad, "no ONNX file"), (tmp_path / "none.onnx", "no such file"),
                        (tmp_path, "a folder")):  # fmt: skip
        with pytest.raises(BadWeights, match=words):
            OnnxDetector.load(path, backend)
    path = write_network(tmp_path / "net.onnx", "v8", CAR)
    with pytest.raises(BadWeights, match=r"its outputs \(out \[1, 5, 60\]\).*Known heads: yolo"):
        OnnxDetector.load(path, backend, (WIDTH, HEIGHT), head="ssd")


def test_settings_that_cannot_be_are_refused(tmp_path: Path) -> None:
    path = write_network(tmp_path / "net.onnx", "v8", CAR)
    for wrong in ({"pixels": "gray"}, {"fit": "crop"}, {"head": "detr"}, {"backend": "caffe"}):
        with pytest.raises(UnknownName, match=next(iter(wrong.values()))):
            OnnxDetector.load(path, **wrong)
    for wrong in ({"min_score": 1.5}, {"max_iou": float("nan")}, {"size": (320, 320)}):
        with pytest.raises(BadConfig, match=next(iter(wrong))):
            OnnxDetector.load(path, **wrong)
    assert set(HEADS) == {"yolo", "rows", "ssd"}
