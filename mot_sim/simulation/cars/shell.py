"""The left half of a car without its faces: the painted shell, and what is bolted to it.

The shell has 19 stations along the car, 12 points a station. A station runs from the middle of
the floor around the side to the middle of the roof. Its lower points follow the wheel arches and
its upper points the windows, so a station may lean. All arrays have a leading axis of designs;
heights point up until `half_points` turns them into y.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.cars.design import Designs, front_axle, greenhouse, rear_axle

STATIONS = 19
# The points of a station: floor (middle, inner edge), side from the sill to the shoulder, foot
# of the window, its upper edge = pillars and roof rail, the inner edge of those, roof.
RING = ("b0", "b1", "s0", "s1", "s2", "s3", "s4", "g", "t0", "u0", "t1", "t2")
# How far each point follows the upper outline (windows) rather than the lower one (arches).
LEAN = np.array([0.0, 0.0, 0.0, 0.1, 0.35, 0.7, 1, 1, 1, 1, 1, 1])
# Share of the half width at the middle of the car; the upper five depend on the design.
SIDE_PROFILE = np.array([0.0, 0.6, 0.955, 0.988, 1.0, 0.99, 0.955, 0.915])
FULL_WIDTH_RADII = 0.4  # tyre radii beyond the axles: between them the car is at its widest
NEAR_END = np.zeros(STATIONS)  # where the shoulder line leaves room for the lamps
NEAR_END[[0, 1, 2, -3, -2, -1]] = (1.0, 0.8, 0.3, 0.3, 0.8, 1.0)
ABOVE_SHOULDER = np.array([0.015, 0.03, 0.034, 0.05, 0.06])  # bonnet and boot: g, t0, u0, t1, t2
BULGE = {5: 0.10, 6: 0.08, 7: 0.05, 12: -0.04, 13: -0.04, 14: -0.03}  # windows curve in plan
MIN_WING_METRES = 0.05  # metres: the least of a wing above a wheel arch; low bonnets swell there
FRONT_CAP_OFFSETS = np.array([0.05, 0.012, 0.03, 0.07, 0.14])  # how far s0..s4 lie behind the nose
REAR_CAP_OFFSETS = np.array([0.04, 0.012, 0.03, 0.06, 0.08])
CAP_INNER = 0.58  # the inner column of the front and the rear, as a share of their half width
CORNER_EXPONENT = 2.4  # exponent of the rounding of nose and tail in plan
SPOKES = 16  # corners of a wheel; one of them stands on the road
WHEEL_POINTS = 3 * SPOKES + 2  # tyre outside, rim, tyre inside, hub, inner centre
TYRE_WIDTH_METRES = 0.20
RIM_SHARE = 0.68  # radius of the rim over that of the tyre
BOX_CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)], dtype=float)


def shell(designs: Designs) -> Float[Array, "n 19 12 3"]:
    """Along, up, left of the points of every station."""
    count = len(designs["length"])
    points = np.zeros((count, STATIONS, len(RING), 3))
    low, high = _lower_outline(designs), _upper_outline(designs)
    points[..., 0] = low[..., :1] + LEAN * (high - low[..., 0])[..., None]
    points[..., 2] = _across(designs, points[..., 0])
    points[..., 1] = _heights(designs, low[..., 1])
    for station, bulge in BULGE.items():
        z = points[:, station, 8:, 2]
        points[:, station, 8:, 0] += bulge * (1.0 - (z / z[:, :1]) ** 2)
    for station, front in ((0, True), (STATIONS - 1, False)):
        rows = np.array([0, 0, 0, 1, 2, 3, 4, 4, 4, 4, 4, 4])
        points[:, station, :, 0] = _end(designs, front, rows, points[:, station, :, 2])
    return points


def cap(designs: Designs, points: Array, front: bool) -> Float[Array, "n 3 2 3"]:
    """Inside the front or the rear: rows s1..s3, columns inner and middle."""
    edge = points[:, 0 if front else -1, 3:6]
    inner = np.stack((edge, edge), axis=2)
    inner[..., 2] *= np.array([CAP_INNER, 0.0])
    for row in range(3):
        rows = np.full(2, row + 1)
        inner[:, row, :, 0] = _end(designs, front, rows, inner[:, row, :, 2])
    return inner


def _end(designs: Designs, front: bool, rows: Array, z: Array) -> Float[Array, "n m"]:
    """How far forward the points of the nose lie, or back those of the tail."""
    ending = "front" if front else "rear"
    width = 0.5 * designs["width"] * designs["nose_width" if front else "tail_width"]
    back = designs[f"corner_{ending}"][:, None] * (z / width[:, None]) ** CORNER_EXPONENT
    offset = (FRONT_CAP_OFFSETS if front else REAR_CAP_OFFSETS)[rows]
    along = 0.5 * designs["length"][:, None] - offset - back
    return along if front else -along


def _lower_outline(designs: Designs) -> Float[Array, "n 19 2"]:
    """Along and up of the side's lower edge: bumpers, arches, sill."""
    outline = np.zeros((len(designs["length"]), STATIONS, 2))
    half, clearance = 0.5 * designs["length"], designs["clearance"]
    radius = designs["arch"] * designs["wheel"]
    foot = np.sqrt(radius**2 - (designs["wheel"] - clearance) ** 2)
    for first, axle in ((2, front_axle(designs)), (12, rear_axle(designs))):
        reach = (foot, 0.63 * radius, 0.0 * radius, -0.63 * radius, -foot)
        rise = (0.0, 0.777, 1.0, 0.777, 0.0)  # of the radius, above the axle
        for step in range(5):
            outline[:, first + step, 0] = axle + reach[step]
            outline[:, first + step, 1] = designs["wheel"] + rise[step] * radius
        outline[:, [first, first + 4], 1] = clearance[:, None]
    for end, near, lip, sign in ((1, 2, "front", 1.0), (17, 16, "rear", -1.0)):
        corner = sign * (half - designs[f"corner_{lip}"] - 0.05)
        outline[:, end, 0] = 0.5 * (corner + outline[:, near, 0])
        outline[:, end, 1] = 0.7 * designs[f"lip_{lip}"] + 0.3 * clearance
        outline[:, end - int(sign), 1] = designs[f"lip_{lip}"]
    share = np.linspace(0.0, 1.0, 7)[1:-1]
    outline[:, 7:12, 0] = outline[:, 6, :1] + share * (outline[:, 12, :1] - outline[:, 6, :1])
    outline[:, 7:12, 1] = clearance[:, None]
    return outline


def _upper_outline(designs: Designs) -> Float[Array, "n 19"]:
    """Where the windows begin and end along the car, with bonnet and boot between."""
    along = np.zeros((len(designs["length"]), STATIONS))
    cowl, roof_front, roof_rear, foot = greenhouse(designs)
    nose = 0.5 * designs["length"] - designs["corner_front"] - FRONT_CAP_OFFSETS[4]
    tail = -0.5 * designs["length"] + designs["corner_rear"] + REAR_CAP_OFFSETS[4]
    lamp = nose - np.minimum(0.22, 0.3 * (nose - cowl))
    along[:, :6] = _between(lamp, cowl, np.array([-0.3, 0.0, 0.27, 0.52, 0.77, 1.0]))
    along[:, 6] = 0.5 * (cowl + roof_front)
    along[:, 7:13] = _between(roof_front, roof_rear, np.array([0, 0.2, 0.44, 0.50, 0.78, 1.0]))
    along[:, 13] = 0.5 * (roof_rear + foot)
    along[:, 14:] = _between(foot, tail, np.array([0.0, 0.25, 0.5, 0.75, 1.0]))
    return along


def _half_width(designs: Designs, along: Array) -> Float[Array, "n 19 12"]:
    """Half the car's width in plan: it tapers towards the nose and the tail."""
    plan = np.ones_like(along)
    axles = {"nose": front_axle(designs), "tail": -rear_axle(designs)}
    for sign, ending, end in ((1, "front", "nose"), (-1, "rear", "tail")):
        last = 0.5 * designs["length"] - designs[f"corner_{ending}"]
        reach = np.maximum(last - axles[end] - FULL_WIDTH_RADII * designs["wheel"], 0.1)
        inside = (last[:, None, None] - sign * along) / reach[:, None, None]
        narrow = (1.0 - np.clip(inside, 0.0, 1.0)) ** 3
        plan -= (1.0 - designs[f"{end}_width"][:, None, None]) * narrow
    return 0.5 * designs["width"][:, None, None] * plan


def _across(designs: Designs, along: Array) -> Float[Array, "n 19 12"]:
    """How far left the points lie; `along` is how far forward."""
    across = _half_width(designs, along)
    plan = 0.5 * designs["width"][:, None] * np.ones(STATIONS)
    plan[:, 0] *= designs["nose_width"]
    plan[:, -1] *= designs["tail_width"]
    across[..., :8] *= SIDE_PROFILE
    across[:, [0, -1], 2:7] = plan[:, [0, -1], None]  # the ends are upright
    across[:, [0, -1], 1] = CAP_INNER * plan[:, [0, -1]]
    across[:, [2, 3, 4, 5, 6, 12, 13, 14, 15, 16], 2] *= 1.02  # flared arches
    roof, screen = designs["roof_width"][:, None], designs["screen_width"][:, None]
    share = np.full(plan.shape, 0.84)
    share[:, [5, 14]] = screen
    share[:, 7:13] = roof
    share[:, [6, 13]] = 0.5 * (roof + screen)
    across[:, [0, -1], 7:9] = plan[:, [0, -1], None] * SIDE_PROFILE[7]
    across[..., 8] *= share
    across[..., 9] = across[..., 8] - 0.055
    across[..., 10] = 0.62 * across[..., 9]
    across[:, [0, -1], 10] = CAP_INNER * plan[:, [0, -1]]
    across[..., 11] = 0.0
    return across


def _heights(designs: Designs, lower: Array) -> Float[Array, "n 19 12"]:
    """How high the points lie; `lower` is the height of the side's lower edge."""
    up = np.zeros((*lower.shape, len(RING)))
    height = designs["height"]
    belt, deck = designs["belt"] * height, designs["deck_height"] * height
    shoulder = np.zeros_like(lower)
    shoulder[:, :6] = _between(
        designs["nose"] * height - 0.03, belt - 0.03, np.array([0, 0.2, 0.42, 0.65, 0.85, 1.0])
    )
    shoulder[:, 5:15] = _between(belt - 0.03, deck - 0.03, np.linspace(0.0, 1.0, 10))
    tail = deck - 0.03 - designs["tail"]
    shoulder[:, 14:] = _between(deck - 0.03, tail, np.array([0, 0.3, 0.6, 0.85, 1.0]))
    shoulder = np.maximum(shoulder, lower + MIN_WING_METRES)
    up[..., :2] = designs["clearance"][:, None, None]
    up[:, [0, 1, -2, -1], :2] = lower[:, [0, 1, -2, -1], None]
    side = shoulder - lower
    lamp = designs["lamp"][:, None] / side
    lamp = 0.15 + NEAR_END * (np.minimum(lamp, 0.4) - 0.15)
    shares = np.stack((0 * lamp, 0.33 * (1 - lamp), 0.67 * (1 - lamp), 1 - lamp, 1 + 0 * lamp), -1)
    up[..., 2:7] = lower[..., None] + shares * side[..., None]
    up[..., 7:] = shoulder[..., None] + ABOVE_SHOULDER
    _raise_roof(designs, up)
    return up


def _raise_roof(designs: Designs, up: Array) -> None:
    """Lift the points above the windows' foot: pillars, roof rails, roof."""
    front, rear = designs["drop_front"][:, None], designs["drop_rear"][:, None]
    share = np.array([0, 0.2, 0.44, 0.50, 0.78, 1.0])  # stations 7 .. 12
    drop = front + (rear - front) * share
    arc = np.array([1.0, 0.85, 0.8, 0.8, 0.85, 1.0])  # the rail is a bow
    rail = designs["height"][:, None] - drop * arc
    crown = designs["height"][:, None] - drop * np.array([0.4, 0.08, 0, 0, 0.08, 0.4])
    for column, part in ((8, 0.0), (9, 0.4), (10, 0.85), (11, 1.0)):
        up[:, 7:13, column] = rail + part * (crown - rail)
    for middle, below, above in ((6, 5, 7), (13, 14, 12)):
        up[:, middle, 8:] = 0.5 * (up[:, below, 8:] + up[:, above, 8:]) + 0.012


def _between(first: Array, last: Array, share: Array) -> Float[Array, "n m"]:
    """From one column to another in the given shares."""
    return first[:, None] + share * (last - first)[:, None]


def wheel(designs: Designs, front: bool) -> Float[Array, "n p 3"]:
    """Along, up, left of a left wheel's points."""
    turn = np.linspace(0.0, 2.0 * np.pi, SPOKES, endpoint=False)
    circle = np.stack((np.sin(turn), -np.cos(turn)), axis=1)  # the first corner is the lowest
    circle[0] = (0.0, -1.0)
    rings = np.concatenate((circle, RIM_SHARE * circle, circle, np.zeros((2, 2))))
    inward = np.repeat([0.02, 0.0, TYRE_WIDTH_METRES], SPOKES)
    inward = np.concatenate((inward, [0.025, TYRE_WIDTH_METRES]))
    radius = designs["wheel"]
    axle = front_axle(designs) if front else rear_axle(designs)
    outside = 0.5 * designs["width"] - 0.035
    points = np.empty((len(radius), WHEEL_POINTS, 3))
    points[..., 0] = axle[:, None] + radius[:, None] * rings[:, 0]
    points[..., 1] = radius[:, None] * (1.0 + rings[:, 1])
    points[..., 2] = outside[:, None] - inward
    return points


def mirror(designs: Designs, shell_points: Float[Array, "n 19 12 3"]) -> Float[Array, "n 8 3"]:
    """Along, up, left of the left mirror's corners: a box on the door, inside the full width."""
    cowl, roof_front, _, _ = greenhouse(designs)
    half = 0.5 * designs["width"]
    back = np.minimum(0.34, 0.5 * (cowl - roof_front))
    low = np.stack((cowl - back - 0.05, shell_points[:, 5, 6, 1] + 0.03, 0.86 * half), axis=1)
    high = low + np.stack((0.10 + 0 * half, 0.13 + 0 * half, 0.135 * half), axis=1)
    return low[:, None] + BOX_CORNERS * (high - low)[:, None]


def plate(designs: Designs, rows: Float[Array, "n 3 2 3"], front: bool) -> Float[Array, "n 8 3"]:
    """Along, up, left of half a number plate; it is the foremost or the last thing of the car.

    rows: the points inside the front or the rear of the shell, from `cap`.
    """
    middle = 0.5 * (rows[:, 0, 1, 1] + rows[:, 1, 1, 1])
    last = 0.5 * designs["length"]
    rear, ahead = (last - 0.05, last) if front else (-last, 0.05 - last)
    low = np.stack((rear, middle - 0.055, 0 * last), axis=1)
    high = np.stack((ahead, middle + 0.055, 0 * last + 0.26), axis=1)
    return low[:, None] + BOX_CORNERS * (high - low)[:, None]
