"""Networks in ONNX files, run by OpenCV or by ONNX Runtime."""

import ast
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import cv2
import numpy as np
from jaxtyping import Shaped
from numpy import ndarray as Array

from tracker.errors import BadConfig, BadWeights, UnknownName

CURE = "pip install 'mot-sim[detect]'"
# What a network gives: its outputs by name, in its order.
Outputs = Mapping[str, Shaped[Array, "..."]]


@runtime_checkable
class OnnxNetwork(Protocol):
    """A network that takes one image and gives arrays."""

    @property
    def input_size(self) -> tuple[int, int] | None:
        """Width and height of the images it takes, px; None: any, or not known."""
        ...

    @property
    def is_byte(self) -> bool:
        """Whether it takes pixels as bytes."""
        ...

    @property
    def rank(self) -> int:
        """Dimensions of its input: 4, or 3 where it takes no batch."""
        ...

    @property
    def channels_last(self) -> bool:
        """Whether colours are the last dimension of its input."""
        ...

    @property
    def class_names(self) -> Mapping[int, str]:
        """Names of its classes as the file states them; empty: it does not."""
        ...

    def run(self, pixels: Shaped[Array, "..."]) -> Outputs:
        """What it gives for its input. Raises BadWeights where it does not take that."""
        ...


@dataclass(frozen=True, eq=False)
class RuntimeNetwork:
    """A network run by ONNX Runtime, which knows what the file says of it."""

    path: Path
    """The ONNX file."""
    session: Any
    """ONNX Runtime's session."""

    @classmethod
    def load(cls, path: Path) -> "RuntimeNetwork":
        """The network of a file. Raises BadWeights for what is none."""
        onnxruntime: Any = import_module("onnxruntime")
        options = onnxruntime.SessionOptions()
        options.log_severity_level = 3
        try:
            session = onnxruntime.InferenceSession(
                str(path), options, providers=["CPUExecutionProvider"]
            )
        except Exception as error:  # noqa: BLE001 - its errors have no common kind
            raise BadWeights(
                f"{path}: no ONNX file that ONNX Runtime reads: {_said(error)}"
            ) from None
        if len(session.get_inputs()) != 1:
            names = ", ".join(each.name for each in session.get_inputs())
            raise BadWeights(f"{path}: a detector takes one image; this network takes {names}")
        return cls(path, session)

    @property
    def _input(self) -> Any:
        return self.session.get_inputs()[0]

    @property
    def input_size(self) -> tuple[int, int] | None:
        """Width and height of the images it takes, px; None: any."""
        shape = self._input.shape[-3:-1] if self.channels_last else self._input.shape[-2:]
        if not all(isinstance(side, int) and side > 0 for side in shape):
            return None
        return int(shape[1]), int(shape[0])

    @property
    def is_byte(self) -> bool:
        """Whether it takes pixels as bytes."""
        return bool(self._input.type == "tensor(uint8)")

    @property
    def rank(self) -> int:
        """Dimensions of its input."""
        return len(self._input.shape)

    @property
    def channels_last(self) -> bool:
        """Whether colours are the last dimension of its input."""
        shape = self._input.shape
        return len(shape) in (3, 4) and shape[-1] == 3 and shape[-3] != 3

    @property
    def class_names(self) -> Mapping[int, str]:
        """Names of its classes as the file states them, as Ultralytics' exports do."""
        stated = self.session.get_modelmeta().custom_metadata_map.get("names", "")
        try:
            names = ast.literal_eval(stated)
        except (ValueError, SyntaxError, MemoryError, RecursionError):
            return {}
        if isinstance(names, Sequence) and not isinstance(names, str):
            names = dict(enumerate(names))
        return (
            {int(key): str(name) for key, name in names.items()} if isinstance(names, dict) else {}
        )

    def run(self, pixels: Shaped[Array, "..."]) -> Outputs:
        """What it gives for its input."""
        try:
            found = self.session.run(None, {self._input.name: pixels})
        except Exception as error:  # noqa: BLE001
            wanted = f"it takes {self._input.type} {self._input.shape}"
            raise BadWeights(
                f"{self.path}: does not take an image as {pixels.dtype} {pixels.shape}; {wanted}: "
                f"{_said(error)}"
            ) from None
        return dict(zip((each.name for each in self.session.get_outputs()), found, strict=True))


@dataclass(frozen=True, eq=False)
class OpenCvNetwork:
    """A network run by OpenCV, which does not tell what the file says of it."""

    path: Path
    """The ONNX file."""
    network: "cv2.dnn.Net"
    """OpenCV's network."""
    input_size: tuple[int, int] | None = None
    """OpenCV does not tell."""
    is_byte: bool = False
    """It takes numbers."""
    rank: int = 4
    """It takes batches."""
    channels_last: bool = False
    """Colours come first."""
    class_names: Mapping[int, str] = field(default_factory=dict)
    """OpenCV does not tell."""

    @classmethod
    def load(cls, path: Path) -> "OpenCvNetwork":
        """The network of a file. Raises BadWeights for what is none."""
        try:
            content = np.frombuffer(path.read_bytes(), np.uint8)
            network = cv2.dnn.readNetFromONNX(content)
        except (cv2.error, ValueError) as error:
            raise BadWeights(
                f"{path}: no ONNX file that OpenCV reads: {_said(error)}; ONNX Runtime reads more: "
                f"{CURE}"
            ) from None
        return cls(path, network)

    def run(self, pixels: Shaped[Array, "..."]) -> Outputs:
        """What it gives for its input."""
        names = list(self.network.getUnconnectedOutLayersNames())
        try:
            self.network.setInput(pixels)
            return dict(zip(names, self.network.forward(names), strict=True))
        except cv2.error as error:
            raise BadWeights(
                f"{self.path}: OpenCV cannot run it on an image of {pixels.shape[3]}x"
                f"{pixels.shape[2]}: {_said(error)}; name another --size, or {CURE}"
            ) from None


BACKENDS: dict[str, Callable[[Path], OnnxNetwork]] = {
    "onnxruntime": RuntimeNetwork.load,
    "opencv": OpenCvNetwork.load,
}


def load_network(path: Path, backend: str | None = None) -> OnnxNetwork:
    """The network of an ONNX file.

    backend: a name of BACKENDS; None: ONNX Runtime where it is installed, else OpenCV. Raises
    UnknownName, BadConfig for ONNX Runtime that is missing, BadWeights for files that are none.
    """
    if backend is not None and backend not in BACKENDS:
        raise UnknownName.of("backend", backend, BACKENDS)
    has_runtime = find_spec("onnxruntime") is not None
    if backend == "onnxruntime" and not has_runtime:
        raise BadConfig(f"ONNX Runtime is not installed: {CURE}, or take --backend opencv")
    if not path.is_file():
        what = "a folder" if path.is_dir() else "no such file"
        raise BadWeights(f"{path}: {what}; give a detector as an ONNX file")
    return BACKENDS[backend or ("onnxruntime" if has_runtime else "opencv")](path)


def _said(error: Exception) -> str:
    """What an error of a library says, on one line."""
    words = " ".join(str(getattr(error, "err", None) or error).split())
    return words[:300] or type(error).__name__
