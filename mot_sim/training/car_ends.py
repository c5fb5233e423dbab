"""Fronts and rears painted anew, as those of real cars: lamps, bumpers, plates, seams, windows.

The fleet has one rear and one front. A real van's rear has small lamps low at its corners or tall
ones on its pillars, a window like a windscreen, a plate anywhere; what all have in common is that
red lamps are behind and clear ones ahead. Painted on the planes that the keypoints span: no
keypoint moves.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers import Semantic
from mot_sim.training.keypoint_crops import ANY_CAR_MARK, OWN_CAR_MARK
from tracker.shape import KEYPOINTS_36

OWN = ANY_CAR_MARK | OWN_CAR_MARK
SUBPIXEL_BITS = 4
MIN_END_PIXELS = 30.0  # of area: less of an end is not painted
MAX_DRAWN_RED = 170.0  # of lamps in full light
KEPT_LAMPS_SHARE = 0.25  # of ends that keep the lamps that were drawn
BLACK_BUMPER_SHARE, BODY_BUMPER_SHARE = 0.4, 0.35
MOVED_PLATE_SHARE = 0.6
PILLAR_LAMPS_SHARE = 0.35
MIN_UPRIGHT = 0.8  # height of the rear window over that of what is below it: lamps fit beside it
INSET_WINDOW_SHARE = 0.45  # of rear windows, with painted metal around
SEEN_THROUGH_SHARE = 0.35  # of windows, which show what is behind or mirrored
Colour = Float[Array, "3"]


def _rows(*names: str) -> list[int]:
    """Rows of keypoints, left before right."""
    return [KEYPOINTS_36.index(f"{side}_{name}") for name in names for side in ("left", "right")]


REAR = _rows("rear_bumper", "taillight", "rear_window_foot", "roof_rear")
FRONT = _rows("front_bumper", "headlight", "windscreen_foot", "roof_front")


@dataclass(eq=False)
class CarEnd:
    """The front or the rear of the car of a crop while it is painted, in place."""

    image: Float32[Array, "s s 3"]
    """BGR, grey levels."""
    parts: UInt8[Array, "s s"]
    """What each pixel shows; see `Crops.parts`."""
    own: Bool[Array, "s s"]
    """The car's own pixels."""
    H_image_end: Float[Array, "3 3"]
    """From the end's plane: from -1 at the car's left corner to 1 at its right, and from 0 at the
    bumper's lower edge up to 1 at the lamps; to pixels."""
    H_image_window: Float[Array, "3 3"]
    """From the window's plane: -1 to 1 across, 0 at its foot, 1 at the roof; to pixels."""
    body: Colour
    """Colour of the paint around."""
    light: float
    """How bright it is, 1 = full light."""
    upright: float
    """Height of the window over that of what lies below it."""

    def polygon(self, corners: Array, window: bool = False) -> Float32[Array, "s s 1"]:
        """How much of each pixel a convex polygon of the plane covers, on the car alone."""
        H = self.H_image_window if window else self.H_image_end
        mapped = np.column_stack((corners, np.ones(len(corners)))) @ H.T
        pixels = mapped[:, :2] / mapped[:, 2:]
        mask = np.zeros(self.parts.shape, np.uint8)
        if np.isfinite(pixels).all() and np.abs(pixels).max() < 1e4:
            scaled = np.round(pixels * (1 << SUBPIXEL_BITS)).astype(np.int32)
            cv2.fillConvexPoly(mask, scaled, 255, cv2.LINE_AA, SUBPIXEL_BITS)
        mask[~self.own] = 0
        return (mask.astype(np.float32) / 255.0)[:, :, None]

    def paint(self, share: Float32[Array, "s s 1"], colour: Colour, part: Semantic) -> None:
        """Lay a colour over a share of each pixel."""
        self.image += share * (colour.astype(np.float32) - self.image)
        self.parts[share[:, :, 0] > 0.5] = part | OWN

    def box(
        self, x: tuple[float, float], y: tuple[float, float], colour: Colour, part: Semantic,
        window: bool = False,
    ) -> None:  # fmt: skip
        """Paint an upright rectangle of the plane."""
        self.paint(self.polygon(_corners(x, y), window), colour, part)

    def both(self, x: tuple[float, float], y: tuple[float, float], colour: Colour) -> None:
        """Paint a rectangle on the right and its mirror image on the left, as lamps."""
        self.box(x, y, colour, Semantic.LIGHT)
        self.box((-x[1], -x[0]), y, colour, Semantic.LIGHT)


def _corners(x: tuple[float, float], y: tuple[float, float]) -> Float[Array, "4 2"]:
    return np.array([(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])])


def repaint_ends(
    image: UInt8[Array, "s s 3"],
    parts: UInt8[Array, "s s"],
    keypoints: Float[Array, "36 2"],
    other: UInt8[Array, "s s 3"],
    rng: np.random.Generator,
) -> tuple[UInt8[Array, "s s 3"], UInt8[Array, "s s"]]:
    """A crop whose car has another front or rear, whichever is seen; image and parts.

    keypoints: shares of the crop's sides. other: another crop, seen through windows.
    """
    canvas, marked = image.astype(np.float32), parts.copy()
    own, pixels = parts >= OWN_CAR_MARK, keypoints * image.shape[0] - 0.5
    for rows, is_front in ((REAR, False), (FRONT, True)):
        end = _end_of(canvas, marked, own, pixels[rows], is_front)
        if end is None:
            continue
        if rng.uniform() < SEEN_THROUGH_SHARE:
            _see_through(end, other, rng)
        _window(end, is_front, rng)
        if rng.uniform() >= KEPT_LAMPS_SHARE:
            _erase(end, Semantic.LIGHT)
            (_front if is_front else _rear)(end, rng)
        _plate(end, is_front, rng)
    return np.clip(canvas, 0.0, 255.0).astype(np.uint8), marked


def _end_of(
    image: Float32[Array, "s s 3"],
    parts: UInt8[Array, "s s"],
    own: Bool[Array, "s s"],
    points: Float[Array, "8 2"],
    is_front: bool,
) -> CarEnd | None:
    """An end that looks at the camera; None: it does not, or is tiny."""
    if not np.isfinite(points).all() or np.abs(points).max() > 1e3:
        return None
    outline = points[[0, 1, 3, 2]]  # bumper left, right, lamp right, left
    after = np.roll(outline, -1, axis=0)
    area = 0.5 * (outline[:, 0] * after[:, 1] - outline[:, 1] * after[:, 0]).sum()
    # v points down: seen from behind, this outline runs against the clock.
    if (area if is_front else -area) < MIN_END_PIXELS:
        return None
    near = np.zeros(parts.shape, np.uint8)
    middle = outline.mean(axis=0)
    around = np.round(middle + 1.3 * (outline - middle)).astype(np.int32)
    cv2.fillConvexPoly(near, around, 1)
    paint = own & (near > 0) & (parts == (Semantic.CAR | OWN))
    paint = paint if paint.sum() > 4 else own & (parts == (Semantic.CAR | OWN))
    if not paint.any():
        return None
    body = np.median(image[paint], axis=0).astype(float)
    lamps = own & (near > 0) & (parts == (Semantic.LIGHT | OWN))
    bright = image[lamps].max(axis=1).mean() / MAX_DRAWN_RED if lamps.any() else body.max() / 150.0
    low, high = (float(np.linalg.norm(points[b] - points[a])) for a, b in ((0, 2), (4, 6)))
    return CarEnd(
        image, parts, own,
        _plane(points[[0, 1, 3, 2]]), _plane(points[[4, 5, 7, 6]]),
        body, float(np.clip(bright, 0.12, 1.3)), high / max(low, 1e-6),
    )  # fmt: skip


def _plane(corners: Float[Array, "4 2"]) -> Float[Array, "3 3"]:
    """The homography of the plane whose lower left and right, upper right and left are given."""
    square = np.array([(-1, 0), (1, 0), (1, 1), (-1, 1)], np.float32)
    H: Float[Array, "3 3"] = cv2.getPerspectiveTransform(square, corners.astype(np.float32))
    return H


def _erase(end: CarEnd, part: Semantic) -> None:
    """Body colour over a part near the end."""
    over = end.polygon(_corners((-1.35, 1.35), (-0.1, 1.35)))[:, :, 0] > 0.5
    over &= end.parts == (part | OWN)
    end.image[over] = end.body
    end.parts[over] = Semantic.CAR | OWN


def _rear(end: CarEnd, rng: np.random.Generator) -> None:
    """Bumper, red lamps, seams, handle, badge."""
    bumper = _bumper(end, rng)
    black = np.full(3, 26.0 * end.light)
    if rng.uniform() < 0.3:  # a recess around the plate
        middle, half = rng.uniform(0.35, 0.7), rng.uniform(0.2, 0.5)
        tone = rng.uniform(0.35, 0.85) * end.body
        end.box((-half, half), (middle - 0.12, middle + 0.14), tone, Semantic.CAR)
    if rng.uniform() < 0.3:  # two doors
        end.box((-0.012, 0.012), (bumper, 1.0), 0.3 * end.body, Semantic.CAR)
    if rng.uniform() < 0.5:  # a tailgate's lower edge
        level = rng.uniform(bumper, bumper + 0.3)
        end.box((-0.85, 0.85), (level - 0.012, level + 0.012), 0.35 * end.body, Semantic.CAR)
    if rng.uniform() < 0.4:
        x, y, wide = rng.uniform(-0.1, 0.1), rng.uniform(0.5, 0.95), rng.uniform(0.06, 0.3)
        end.box((x - wide, x + wide), (y - 0.03, y + 0.03), black, Semantic.TRIM)
    if rng.uniform() < 0.5:
        _badge(end, rng)
    _red_lamps(end, bumper, rng)


def _red_lamps(end: CarEnd, bumper: float, rng: np.random.Generator) -> None:
    """Red lamps at the corners: low, in a band, or tall beside the window; some part clear."""
    bright = end.light * rng.uniform(0.6, 1.35)
    red = bright * np.array([rng.uniform(5, 60), rng.uniform(5, 70), rng.uniform(120, 230)])
    outer = rng.uniform(0.96, 1.04)
    if end.upright > MIN_UPRIGHT and rng.uniform() < PILLAR_LAMPS_SHARE:
        wide, low, high = rng.uniform(0.06, 0.14), rng.uniform(-0.1, 0.3), rng.uniform(0.4, 0.9)
        for side in (-1.0, 1.0):
            corners = np.array(
                [(outer, low), (outer - wide, low), (outer - wide, high), (outer, high)]
            )
            end.paint(end.polygon(corners * (side, 1.0), True), red, Semantic.LIGHT)
        return
    if rng.uniform() < 0.6:
        wide, tall = rng.uniform(0.08, 0.22), rng.uniform(0.2, 0.55)
    else:
        wide, tall = rng.uniform(0.2, 0.5), rng.uniform(0.14, 0.32)
    low = rng.uniform(bumper, max(1.05 - tall, bumper + 0.01))
    end.both((outer - wide, outer), (low, low + tall), red)
    if rng.uniform() < 0.45:
        amber = bright * np.array(
            [rng.uniform(10, 60), rng.uniform(90, 140), rng.uniform(190, 240)]
        )
        at = low + tall * (0.72 if rng.uniform() < 0.6 else rng.uniform(0.0, 0.7))
        end.both((outer - wide, outer), (at, at + 0.28 * tall), amber)
    if rng.uniform() < 0.45:
        clear = np.full(3, bright * rng.uniform(110, 220))
        at = low + tall * rng.uniform(0.1, 0.6)
        end.both((outer - wide, outer - 0.3 * wide), (at, at + 0.25 * tall), clear)


def _front(end: CarEnd, rng: np.random.Generator) -> None:
    """Bumper, clear lamps, grille, badge."""
    bumper = _bumper(end, rng)
    black = np.full(3, rng.uniform(10.0, 45.0) * end.light)
    if rng.uniform() < 0.65:  # the air's way in below
        half, low = rng.uniform(0.3, 0.85), rng.uniform(0.02, 0.25)
        end.box((-half, half), (low, low + rng.uniform(0.08, 0.3)), black, Semantic.TRIM)
    half, low = rng.uniform(0.25, 0.7), rng.uniform(0.45, 0.8)
    high = low + rng.uniform(0.1, 0.4)
    tone = black if rng.uniform() < 0.7 else end.body
    end.box((-half, half), (low, high), tone, Semantic.TRIM if tone is black else Semantic.CAR)
    if tone is black and rng.uniform() < 0.4:
        bar = np.full(3, end.light * rng.uniform(80, 220))
        at = rng.uniform(low, high)
        end.box((-half, half), (at - 0.02, at + 0.02), bar, Semantic.TRIM)
    if rng.uniform() < 0.6:
        _badge(end, rng)
    _clear_lamps(end, bumper, rng)


def _clear_lamps(end: CarEnd, bumper: float, rng: np.random.Generator) -> None:
    """Pale, bright or dark lamps at the corners, some with amber indicators."""
    bright = end.light * rng.uniform(0.6, 1.35)
    grey = rng.uniform(110, 235) if rng.uniform() < 0.75 else rng.uniform(35, 110)
    tone = bright * (grey + rng.normal(0.0, 8.0, 3))
    wide, tall = rng.uniform(0.18, 0.5), rng.uniform(0.16, 0.42)
    outer = rng.uniform(0.9, 1.03)
    low = rng.uniform(max(0.45, bumper), max(1.1 - tall, bumper + 0.05, 0.46))
    slant, inner = rng.uniform(-0.1, 0.15), outer - wide
    for side in (-1.0, 1.0):
        corners = np.array(
            [(outer, low + slant), (inner, low), (inner, low + tall), (outer, low + tall + slant)]
        )
        end.paint(end.polygon(corners * (side, 1.0)), tone, Semantic.LIGHT)
    if rng.uniform() < 0.4:
        at, size = outer - wide * rng.uniform(0.3, 0.7), rng.uniform(0.04, 0.1)
        spot = np.full(3, bright * rng.uniform(180, 260))
        end.both((at - size, at + size), (low + 0.3 * tall, low + 0.7 * tall), spot)
    if rng.uniform() < 0.3:
        amber = bright * np.array(
            [rng.uniform(10, 70), rng.uniform(100, 150), rng.uniform(190, 240)]
        )
        thin = rng.uniform(0.04, 0.1)
        end.both((outer - thin, outer), (low, low + tall), amber)
    if rng.uniform() < 0.25:
        fog = np.full(3, bright * rng.uniform(120, 240))
        end.both((0.6, 0.78), (0.12, 0.26), fog)


def _bumper(end: CarEnd, rng: np.random.Generator) -> float:
    """Black, body-coloured or as it was drawn; how high it reaches."""
    high, kind = rng.uniform(0.18, 0.45), rng.uniform()
    if kind < BLACK_BUMPER_SHARE:
        tone = np.full(3, rng.uniform(14.0, 70.0) * end.light)
        end.box((-1.08, 1.08), (-0.05, high), tone, Semantic.TRIM)
    elif kind < BLACK_BUMPER_SHARE + BODY_BUMPER_SHARE:
        end.box((-1.08, 1.08), (-0.05, 1.0), end.body, Semantic.CAR)
        low = 0.02 + 0.5 * high
        end.box((-1.05, 1.05), (high, high + 0.02), 0.45 * end.body, Semantic.CAR)
        if rng.uniform() < 0.5:
            dark = np.full(3, 30.0 * end.light)
            end.box((-1.0, 1.0), (low - 0.04, low + 0.04), dark, Semantic.TRIM)
    return high


def _badge(end: CarEnd, rng: np.random.Generator) -> None:
    """A maker's sign."""
    tone = np.full(3, end.light * rng.choice((30.0, 190.0)))
    y, half = rng.uniform(0.55, 1.0), rng.uniform(0.03, 0.08)
    end.box((-half, half), (y - 1.6 * half, y + 1.6 * half), tone, Semantic.TRIM)


def _plate(end: CarEnd, is_front: bool, rng: np.random.Generator) -> None:
    """The number plate somewhere else: it is at any height, and not always in the middle."""
    if rng.uniform() >= MOVED_PLATE_SHARE:
        return
    _erase(end, Semantic.PLATE)
    x = 0.0 if rng.uniform() < (0.9 if is_front else 0.75) else rng.uniform(-0.5, 0.5)
    y = rng.uniform(0.1, 0.45 if is_front else 0.75)
    tone = np.full(3, end.light * rng.uniform(150, 240))
    end.box((x - 0.3, x + 0.3), (y - 0.075, y + 0.075), tone, Semantic.PLATE)
    ink = np.full(3, end.light * rng.uniform(40, 110))
    end.box((x - 0.22, x + 0.24), (y - 0.03, y + 0.03), ink, Semantic.PLATE)


def _window(end: CarEnd, is_front: bool, rng: np.random.Generator) -> None:
    """Painted metal around or between the glass of a rear; wipers."""
    inset = not is_front and rng.uniform() < INSET_WINDOW_SHARE
    x, low, high = (rng.uniform(0.68, 0.95), rng.uniform(0.02, 0.3), rng.uniform(0.8, 0.98))
    shade = rng.uniform(0.8, 1.05) * end.body
    if inset:
        hole = end.polygon(_corners((-x, x), (low, high)), True)
        whole = end.polygon(_corners((-1.1, 1.1), (-0.1, 1.05)), True)
        end.paint(whole * (1.0 - hole), shade, Semantic.CAR)
        if rng.uniform() < 0.3:  # two doors
            end.box((-0.07, 0.07), (-0.05, 1.0), shade, Semantic.CAR, True)
    elif not is_front and rng.uniform() < 0.06:  # a panel van
        end.box((-1.0, 1.0), (-0.1, 1.0), shade, Semantic.CAR, True)
    if rng.uniform() < 0.35:
        black = np.full(3, 15.0 * end.light)
        at, reach = rng.uniform(-0.4, 0.2), rng.uniform(0.3, 0.7)
        corners = np.array([(at, 0.02), (at + reach, 0.12), (at + reach, 0.16), (at, 0.06)])
        end.paint(end.polygon(corners, True), black, Semantic.GLASS)


def _see_through(end: CarEnd, other: UInt8[Array, "s s 3"], rng: np.random.Generator) -> None:
    """What lies behind the car, or is mirrored, in its window."""
    glass = end.polygon(_corners((-0.92, 0.92), (0.05, 0.95)), True)
    glass = glass * (end.parts == (Semantic.GLASS | OWN))[:, :, None]
    soft = cv2.GaussianBlur(other, (0, 0), float(rng.uniform(0.8, 3.0))).astype(np.float32)
    share = np.float32(rng.uniform(0.2, 0.9)) * glass
    end.image += share * (soft - end.image)
