"""Which mistake the boxes point to: how much likelier they are by it than by what is given.

Cars move on their own, so each test looks at what they do not do by themselves: all of them nod
with the camera from frame to frame (rotations); many stand or come towards it, few drive away
faster than it follows (translations); all are as high as cars (camera height, pitch).
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.types import Camera

# Nats by which a mistake must fit better than what is given; and, where it is one of rotations,
# better than no rotation at all. On KITTI's 21 sequences, with OXTS and with ORB-SLAM3, nothing
# comes above 14 (python -m benchmarks.motion_checks).
BAR = 30.0
STILL_BAR = 15.0
# For a hundredth, a hundredfold or a vehicle's axes, for which nothing on KITTI ever speaks.
UNITS_BAR = 15.0
# For reversed motion by depths and turns alone: one car that drives away at twice the camera's
# speed speaks for it as long as it is seen.
REVERSED_BAR = 45.0
# Where boxes turn against the rotations given but drive as given: by depths, the other way.
TRANSPOSED_BAR = 6.0
# Reversed motion is either the inverse or in OpenGL's axes, which nodding tells: so long it is
# waited for.
MIN_REVERSED_FRAMES = 60

# --- rotations -------------------------------------------------------------------------------
MIN_CHANGES = 8
MIN_SHIFT_STD = 0.3  # pixels
CLIP = 2.0  # standard deviations, from which on a deviation counts linearly
# Shifts by turning, of which the sign and the size are judged: more pixels than this, so many
# frames, and medians that spread by less than this share.
TURN_PIXELS = 6.0
MIN_TURN_FRAMES = 20
MAX_TURN_SPREAD = 0.15
# Frames of one turn are alike: so many count as one.
TURN_REPEATS = 3.0
# True over given focal length: inside, nothing is said; far outside, it is something else.
FOCAL_FACTORS = (0.7, 1.2)
TURN_FACTORS = (0.7, 1.4)  # by turns, in which cars drive as well
FARTHEST_FACTORS = (0.25, 4.0)
MAX_FOCAL_SHARE = 0.85
MIN_NODS = 80
MAX_FOCAL_MARGIN = 0.14

# --- translations ----------------------------------------------------------------------------
MIN_SPEED, MAX_SPEED = 3.0, 60.0  # m/s
MAX_DEPTH_NOISE = 0.5  # as a share of the camera's way
ONCOMING_SPEED = 25.0  # m/s
FOLLOWING_STD = 3.0  # m/s, of cars that drive along
MAX_RELATIVE_SPEED = 40.0  # m/s
OVERTAKING_SPEED = 20.0  # m/s
# Shares of parked cars, oncoming ones, those that drive along, that drive away, anything else.
SHARES = (0.35, 0.15, 0.3, 0.1, 0.1)
HUNDRED = 100.0

# Standard deviations by which cars of a short drive come nearer to a camera that drives backwards.
SHORT_STDS = 1.5

# --- sizes -----------------------------------------------------------------------------------
MIN_SIZES = 40
MAX_SIZES = 300
# Boxes of one car are alike: so many count as one.
SIZE_REPEATS = 4.0
HEIGHT_FACTORS = (0.7, 1.5)  # given over true camera height; KITTI: 0.78 to 1.33
PITCH_LIMIT = math.radians(2.3)  # KITTI, whose roads are not level: up to 1.7
STDS = 3.0


@dataclass(frozen=True)
class Contradiction:
    """What the boxes say against the given motion or calibration."""

    cause: str
    """The likely mistake, by the names of CAUSES."""
    text: str
    """What was found and what to look at, one sentence."""


CAUSES = {
    "inverse": "the inverse of T_now_before predicts the boxes better: are the poses "
    "world-to-camera where camera-to-world belongs, or their rotations transposed?",
    "transposed": "the camera turns the other way than T_now_before says, but drives as it says: "
    "are the rotations transposed? A line of poses is r11 r12 r13 tx r21 r22 r23 ty ...",
    "opengl": "the boxes move as if the camera's y pointed up and its z backwards: are the poses "
    "in OpenGL's axes? Ours are x right, y down, z forward",
    "reversed": "the camera drives backwards by T_now_before, forwards by the boxes: are the poses "
    "world-to-camera where camera-to-world belongs, or in OpenGL's axes (y up, z backwards)?",
    "vehicle axes": "the camera drives sideways by T_now_before, ahead by the boxes: are the poses "
    "in a vehicle's axes (x forward, z up)? Ours are the camera's: x right, y down, z forward",
    "one frame early": "the motion given one frame before predicts the boxes better: are the "
    "poses shifted by one frame, too early?",
    "one frame late": "the motion given one frame later predicts the boxes better: are the poses "
    "shifted by one frame, too late?",
    "units": "{factor:g} times the translation of T_now_before predicts the boxes better: is it "
    "in metres?",
    "focal length": "the boxes shift {factor:.2f} times as far as this focal length says when the "
    "camera turns or nods: is K that of these images, at their size?",
    "camera height": "what is tracked would be {height:.1f} m high at this camera height: about "
    "{factor:.2f} m fits the boxes",
    "pitch": "what is tracked would grow with its distance: the horizon is {pixels:.0f} pixels "
    "off; about {degrees:.1f} degrees more pitch fit (positive looks up)",
    "leap": "frame {frame}: T_now_before leaps by {metres:.3g} m and {degrees:.3g} degrees more "
    "than in the frames around it, and the boxes do not: did the map or the clock jump?",
}


def contradiction(cause: str, **numbers: int | float) -> Contradiction:
    """The cause with its sentence, filled with the numbers."""
    return Contradiction(cause, CAUSES[cause].format(**numbers))


def judge_rotations(shifts: Float[Array, "t 4"], depths: Float[Array, "k 5"]) -> str | None:
    """The cause that the shifts of boxes point to, if one: lags and reversals."""
    by_depths = scaled_nats(depths, -1.0)
    reversed_nats = by_depths + _turned_nats(shifts)
    nats = _shift_nats(shifts)
    best = max(nats, key=lambda name: nats[name])
    is_sure = nats[best] > BAR and nats[best] > nats["still"] + STILL_BAR
    if is_sure and best in ("one frame early", "one frame late"):
        return best
    if is_sure and best == "inverse" and by_depths < -TRANSPOSED_BAR:
        return "transposed"
    shifts_reversed = is_sure and best in ("inverse", "opengl")
    if not (reversed_nats > -BAR if shifts_reversed else reversed_nats > REVERSED_BAR):
        return None
    by_nodding = nats["opengl"] - nats["inverse"]  # they differ in nothing else
    if abs(by_nodding) > STILL_BAR:
        return "opengl" if by_nodding > 0.0 else "inverse"
    return "reversed" if len(shifts) >= MIN_REVERSED_FRAMES else None


def _shift_nats(shifts: Float[Array, "t 4"]) -> dict[str, float]:
    """Log likelihoods of the changes of shifts, from frame to frame, less that of what is given.

    Changes: a car's own way, and how far the camera drives, hardly differ in two frames.
    """
    names = ("given", "still", "inverse", "opengl", "one frame early", "one frame late")
    nats = np.zeros(len(names))
    changes = np.diff(shifts, axis=0)
    for axis in (0, 1):
        seen, given = changes[1:-1, axis], changes[1:-1, axis + 2]
        before, after = changes[:-2, axis + 2], changes[2:, axis + 2]
        models = np.stack(
            (given, 0.0 * given, -given, given if axis else -given, before, after)
        )  # as named
        errors = np.abs(seen - models)
        errors = errors[:, np.isfinite(errors).all(axis=0)]
        if errors.shape[1] < MIN_CHANGES:
            continue
        std = 1.4826 * float(np.median(errors, axis=1).min())
        deviations = errors / max(std, MIN_SHIFT_STD)
        within = np.minimum(deviations, CLIP)
        losses = (within * (deviations - 0.5 * within)).sum(axis=1)  # linear beyond CLIP
        nats += losses[0] - losses
    return dict(zip(names, nats.tolist(), strict=True))


def _turned_nats(shifts: Float[Array, "t 4"]) -> float:
    """How much likelier the shifts in turns are with the turns reversed."""
    ratios = _turn_ratios(shifts)
    return float(np.log(_turn_density(-ratios) / _turn_density(ratios)).sum()) / TURN_REPEATS


def _turn_ratios(shifts: Float[Array, "t 4"]) -> Float[Array, " n"]:
    """Shifts over predicted ones in the frames in which the camera turns."""
    turns = np.abs(shifts[:, 2]) > TURN_PIXELS  # False for NaN
    return shifts[turns, 0] / shifts[turns, 2]


def _turn_density(ratios: Float[Array, " n"]) -> Float[Array, " n"]:
    """Of cars that stand (1), those that drive along through the turn (0), and others."""
    standing = np.exp(-0.5 * ((ratios - 1.0) / 0.25) ** 2) * 0.48
    along = np.exp(-0.5 * (ratios / 0.4) ** 2) * 0.35
    return standing + along + 0.125 * ((ratios > 1.0) & (ratios < 3.0)) + 0.02


def scaled_nats(depths: Float[Array, "k 5"], scale: float) -> float:
    """How much likelier the cars' depths are with `scale` times the translation."""
    return _depth_nats(depths, scale * depths[:, 1])


def _depth_nats(depths: Float[Array, "k 5"], other: Float[Array, " k"]) -> float:
    """How much likelier the cars' depths are where the camera drove so far ahead, in metres."""
    nearer, ahead, std, seconds, _ = depths.T
    metres = np.abs(other)
    kept = (metres > MIN_SPEED * seconds) & (std < MAX_DEPTH_NOISE * metres)
    kept &= np.abs(nearer) < MAX_RELATIVE_SPEED * seconds  # false where no time goes by
    kept &= (metres < MAX_SPEED * seconds) | (metres == np.abs(ahead))
    nearer, ahead, std, seconds, _ = depths[kept].T
    given = _depth_density(nearer, ahead, std, seconds)
    return float(np.log(_depth_density(nearer, other[kept], std, seconds) / given).sum())


def _depth_density(
    nearer: Float[Array, " k"],
    ahead: Float[Array, " k"],
    std: Float[Array, " k"],
    seconds: Float[Array, " k"],
) -> Float[Array, " k"]:
    """Of how much nearer cars come when the camera drives so far ahead."""
    parked, oncoming, along, overtaking, other = SHARES
    way = np.sign(ahead) * nearer
    beyond, reach = way - np.abs(ahead), ONCOMING_SPEED * seconds
    away = OVERTAKING_SPEED * seconds
    return (
        parked * _normal(nearer - ahead, np.sqrt(std**2 + (0.05 * ahead) ** 2 + 0.04))
        + oncoming * ((beyond > 0.0) & (beyond < reach)) / reach
        + along * _normal(nearer, np.hypot(std, FOLLOWING_STD * seconds))
        + overtaking * ((way < 0.0) & (way > -away)) / away
        + other / (2.0 * MAX_RELATIVE_SPEED * seconds)
    )


def _normal(x: Float[Array, " k"], std: Float[Array, " k"]) -> Float[Array, " k"]:
    return np.exp(-0.5 * (x / std) ** 2) / (std * math.sqrt(2.0 * math.pi))


def judge_translations(depths: Float[Array, "k 5"]) -> Contradiction | None:
    """Whether the camera drives along another axis, a hundredth or a hundredfold as far."""
    if _depth_nats(depths, depths[:, 4]) > UNITS_BAR:
        return contradiction("vehicle axes")
    if scaled_nats(depths, HUNDRED) > UNITS_BAR:
        return contradiction("units", factor=HUNDRED)
    seconds, too_fast = depths[:, 3], np.abs(depths[:, 1]) > MAX_SPEED * depths[:, 3]
    is_fast = np.count_nonzero(too_fast & (seconds > 0.0)) > 0.5 * len(depths)
    if is_fast and scaled_nats(depths, 1.0 / HUNDRED) > UNITS_BAR:
        return contradiction("units", factor=1.0 / HUNDRED)
    return None


def judge_short_drive(depths: Float[Array, "k 5"]) -> Contradiction | None:
    """Whether cars come nearer to a camera that drives backwards and is not passed by any.

    Of a second or two nothing else can be told. A camera that looks back sees this as well, when
    somebody catches up; but few do nothing else.
    """
    nearer, ahead, std, seconds, _ = depths.T
    is_backwards = len(depths) > 0 and bool((ahead < -MIN_SPEED * seconds).all())
    if is_backwards and nearer.sum() > SHORT_STDS * math.sqrt((std**2).sum()):
        return contradiction("reversed")
    return None


def judge_focal_length(shifts: Float[Array, "t 4"]) -> Contradiction | None:
    """Whether boxes shift by another factor than the camera's rotation says."""
    factor = _nod_factor(shifts)
    if factor is None:
        ratios = _turn_ratios(shifts)
        if len(ratios) < MIN_TURN_FRAMES:
            return None
        factor = float(np.median(ratios))
        spread = float(np.median(np.abs(ratios - factor)))
        is_inside = TURN_FACTORS[0] <= factor <= TURN_FACTORS[1]
        if spread > MAX_TURN_SPREAD * factor or is_inside:
            return None
    if not FARTHEST_FACTORS[0] < factor < FARTHEST_FACTORS[1]:
        return None
    return contradiction("focal length", factor=factor)


def _nod_factor(shifts: Float[Array, "t 4"]) -> float | None:
    """Vertical changes of shifts over predicted ones, where that cannot be 1; else None.

    Noise of the given rotations makes the factor of a regression smaller, by no more than their
    squared correlation with what is seen; nothing makes it larger.
    """
    changes = np.diff(shifts, axis=0)
    seen, given = changes[:, 1], changes[:, 3]
    known = np.isfinite(seen) & np.isfinite(given)
    seen, given = seen[known], given[known]
    if len(seen) < MIN_NODS:
        return None
    weights = np.ones(len(seen))
    for _ in range(5):
        power, product = (weights * given**2).sum(), (weights * given * seen).sum()
        if power <= 0.0 or product <= 0.0:
            return None
        factor = float(product / power)
        errors = np.abs(seen - factor * given)
        noise = max(1.4826 * float(np.median(errors)), 0.1)
        weights = 1.0 / np.maximum(errors / (1.5 * noise), 1.0)
    margin = 2.0 * noise / math.sqrt(power)
    agreement = float(product**2 / (power * (weights * seen**2).sum()))
    is_low = factor + margin < min(FOCAL_FACTORS[0], MAX_FOCAL_SHARE * agreement)
    is_high = factor - margin > FOCAL_FACTORS[1]
    return factor if margin < MAX_FOCAL_MARGIN and (is_low or is_high) else None


def judge_sizes(
    sizes: Float[Array, "s 2"], camera: Camera, car_height: float
) -> Contradiction | None:
    """Whether no car has a car's height on this road: camera height, or pitch.

    On the road, a car of that height at any distance stands below the horizon by its height in
    pixels times camera height over car height; the rest is the horizon's error.
    """
    heights, below = sizes.T
    if len(sizes) < MIN_SIZES or np.ptp(heights) < 1.0:
        return None  # of boxes of one size, any height fits with some pitch
    horizon = camera.K[1, 1] * camera.road_normal[2] / camera.road_normal[1]
    below = below + horizon
    A = np.column_stack((heights, np.ones(len(heights))))
    noise, weights = 0.1 * heights + 2.0, np.ones(len(heights))
    for _ in range(5):
        w = weights / noise**2
        information = (A * w[:, None]).T @ A
        fit = np.linalg.solve(information, (A * w[:, None]).T @ below)
        errors = np.abs(below - A @ fit) / noise
        weights = 1.0 / np.maximum(errors / 1.5, 1.0)
    spread = max(1.0, float(1.4826 * np.median(errors)))
    stds = STDS * spread * np.sqrt(np.diag(np.linalg.inv(information)) * SIZE_REPEATS)
    ratio, pixels = fit.tolist()
    pitch = math.atan2(pixels, camera.K[1, 1])
    limit = camera.K[1, 1] * math.tan(PITCH_LIMIT)
    if abs(pixels) - stds[1] > limit:
        return contradiction("pitch", pixels=abs(pixels), degrees=math.degrees(pitch))
    if stds[1] > limit or ratio - stds[0] <= 0.0:
        return None
    factors = [camera.height / (car_height * (ratio + sign * stds[0])) for sign in (1.0, -1.0)]
    if min(factors) > HEIGHT_FACTORS[1] or max(factors) < HEIGHT_FACTORS[0]:
        return contradiction(
            "camera height", height=camera.height / ratio, factor=ratio * car_height
        )
    return None
