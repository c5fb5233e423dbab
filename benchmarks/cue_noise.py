"""How wrong shape and pose of the front end are, and the noise of profile `cues` that is as wrong.

    python -m benchmarks.cue_noise [--seeds 2] [--frames 60]

Three junctions are drawn, seen through the profile `rrc`, and measured by the keypoint network and
the fit. Printed are the parameters of the effects `Pose` and `Shape` that follow, and how often
the next frame's most alike car is the right one (rank-1), as measured and with that noise on the
same cars. Seeds begin at 2000: nothing else is tuned or reported on them.
"""

import argparse
from dataclasses import replace

import numpy as np
from numpy import ndarray as Array

from mot_sim.simulation.episode import record
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.cues import Pose, Shape
from mot_sim.simulation.sensors.sightings import Sightings
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from tracker.costs.shape_pose import ShapeAndPose
from tracker.front_end import FrontEnd
from tracker.geometry import box_iou, wrap_angle
from tracker.types.shape_pose import ShapePose

SCENES, FIRST_SEED = ("intersection", "roundabout", "t_junction"), 2000
LAGS, SECONDS = (1, 2, 3, 5, 10, 20), (0.2, 0.4, 0.8, 1.6)
PLAIN = 0.5  # visible fraction from which on a row counts for a car's median
GAPS, FACTORS = (1, 5, 10), (1.0, 1.3, 1.6, 2.0, 2.5, 3.0)  # frames; times what is pooled
ROBUST = 1.4826  # std of a normal error over its median size


class Sample:
    """The detections of one drive whose car is known, with what was measured and what is true."""

    def __init__(self, scene: str, seed: int, frames: int, front_end: FrontEnd) -> None:
        episode = record(find_scene(scene, frames=frames, profile="rrc"), seed, renderer="raster")
        true = Sightings.from_truth(episode.exact, episode.vehicles)
        rows, found = [], []
        for frame in (front_end(each, episode.camera) for each in episode):
            here = np.flatnonzero(true.frames == frame.index)
            pose = ShapePose.of(frame.detections)
            if len(here) == 0 or pose is None or len(pose) == 0:
                continue
            overlap = box_iou(frame.detections.boxes[:, None], true.boxes[here][None])
            sure = np.flatnonzero(overlap.max(axis=1) >= 0.6)
            rows.append(here[overlap[sure].argmax(axis=1)])
            found.append(pose.select(sure))
        measured = ShapePose.concatenate(found)
        known = np.isfinite(measured.yaw) & np.isfinite(measured.shape).all(axis=1)
        self.asked, self.known = len(known), int(known.sum())
        self.measured = measured.select(known)
        self.true = true.select(np.concatenate(rows)[known])

    def pairs(self, lag: int) -> tuple[Array, Array]:
        """Rows of one car `lag` frames apart."""
        row = {key: n for n, key in enumerate(self.keys())}
        both = [(n, row[f + lag, i]) for (f, i), n in row.items() if (f + lag, i) in row]
        one, other = np.array(both, int).reshape(-1, 2).T
        return one, other

    def keys(self) -> list[tuple[int, int]]:
        """Frame and car of each row."""
        return list(zip(self.true.frames.tolist(), self.true.ids.tolist(), strict=True))

    def made(self, pose: Pose, shape: Shape, seed: int) -> ShapePose:
        """What these effects make of the same cars."""
        yaw, _ = pose(self.true, seed, STEP_SECONDS)
        coefficients = shape(self.true, seed, STEP_SECONDS)
        assert coefficients is not None
        cov = np.zeros((len(yaw), 6, 6))
        cov[:, 0, 0] = pose.std(self.true) ** 2
        cov[:, range(1, 6), range(1, 6)] = shape.stated_std(self.true)[:, None] ** 2
        return ShapePose(coefficients, yaw, cov)


def rank1(samples: list[Sample], seen: list[ShapePose], gap: int) -> Array:
    """How often the most alike car `gap` frames later is the right one: shape, pose, eq. 6."""
    cost, hits, asked = ShapeAndPose(), np.zeros(3), 0
    for sample, looks in zip(samples, seen, strict=True):
        frames, ids = sample.true.frames, sample.true.ids
        for frame in np.unique(frames):
            later = np.flatnonzero(frames == frame + gap)
            if len(later) < 2:
                continue
            for row in np.flatnonzero((frames == frame) & np.isin(ids, ids[later])):
                one = looks.select(np.full(len(later), row))
                shape, pose = cost.squares(one, looks.select(later))
                whole = cost.eta_shape * shape + cost.eta_pose * pose
                hits += [ids[later][each.argmin()] == ids[row] for each in (shape, pose, whole)]
                asked += 1
    return hits / asked


def autocorrelation_of(fixed: float, changes: Array) -> tuple[float, Autocorrelation]:
    """Std and autocorrelation of an error: its variance `fixed` stays, the rest changes by lag.

    changes: half the variance of the difference of two errors, for each of LAGS.
    """
    best: tuple[float, Array, float] = (np.inf, np.zeros(2), SECONDS[0])
    for seconds in SECONDS:
        slow = 1.0 - np.exp(-np.array(LAGS) * STEP_SECONDS / seconds)
        fit = np.linalg.lstsq(np.column_stack((np.ones(len(LAGS)), slow)), changes, rcond=None)[0]
        fit = fit.clip(0.0)
        off = float(((fit[0] + fit[1] * slow - changes) ** 2).sum())
        if off < best[0]:
            best = off, fit, seconds
    _, (white, slow), seconds = best
    total = fixed + white + slow
    shares = np.round(np.array([white, slow, fixed]) / total, 3)
    shares[2] = round(1.0 - shares[:2].sum(), 3)
    return float(np.sqrt(total)), Autocorrelation(tuple(shares.tolist()), (0.0, seconds, 1e5))


def fit_pose(samples: list[Sample]) -> Pose:
    """Cars turned round apart: their share, and the seconds that it lasts."""
    off = [wrap_angle(each.measured.yaw - each.true.cuboids.yaw) for each in samples]
    turned = [np.abs(each) > 0.5 * np.pi for each in off]
    errors = np.concatenate(off)[~np.concatenate(turned)]
    visible = np.concatenate([each.true.visible for each in samples])[~np.concatenate(turned)]
    slope = np.polyfit(1.0 - visible, np.log(np.maximum(np.abs(errors), 1e-3)), 1)[0]
    plain = ROBUST * float(np.median(np.abs(errors[visible >= 0.9])))
    changes, again, before = [], 0, 0
    for lag in LAGS:
        moved = []
        for sample, error, flip in zip(samples, off, turned, strict=True):
            one, other = sample.pairs(lag)
            same = ~flip[one] & ~flip[other]
            moved.append(error[one][same] - error[other][same])
            if lag == 1:
                again, before = again + int(flip[other][flip[one]].sum()), before + flip[one].sum()
        changes.append((ROBUST * np.median(np.abs(np.concatenate(moved)))) ** 2 / 2.0)
    fixed = max(plain**2 - changes[-1], 0.0)
    _, autocorrelation = autocorrelation_of(fixed, np.array(changes))
    lasting = max(-STEP_SECONDS / np.log(np.clip(again / max(before, 1), 0.05, 0.99)), STEP_SECONDS)
    share = float(np.concatenate(turned).mean())
    print(f"yaw: {share:.3f} turned round, {again} of {before} in the next frame too")
    return Pose(
        round(plain, 4), round(float(max(slope, 0.0)), 2), round(share, 4), 0.03, autocorrelation,
        Autocorrelation((1.0,), (round(float(lasting), 2),)),
    )  # fmt: skip


def fit_shape(samples: list[Sample]) -> Shape:
    """The pull to the mean from the cars' medians; the noise pooled over the coefficients."""
    medians, truths = [], []
    for sample in samples:
        for car in np.unique(sample.true.ids):
            rows = np.flatnonzero((sample.true.ids == car) & (sample.true.visible >= PLAIN))
            if len(rows) > 5:
                medians.append(np.median(sample.measured.shape[rows], axis=0))
                truths.append(sample.true.shape[rows[0]])
    median, truth = (np.array(each) - np.mean(each, axis=0) for each in (medians, truths))
    kept = float((median * truth).sum() / (truth**2).sum())
    fixed = float((median - kept * truth).var(axis=0).mean())
    changes = []
    for lag in LAGS:
        off = [
            sample.measured.shape[one] - sample.measured.shape[other]
            for sample in samples
            for one, other in [sample.pairs(lag)]
        ]
        changes.append(float((np.concatenate(off) ** 2).mean()) / 2.0)
    spread, autocorrelation = autocorrelation_of(fixed, np.array(changes))
    cov = np.concatenate([sample.measured.cov for sample in samples])
    stated = float(np.sqrt(np.median(np.diagonal(cov[:, 1:, 1:], axis1=1, axis2=2))))
    return Shape(
        round(spread, 4), 0.0, 0.0, round(1.0 - kept, 3), round(stated, 3), autocorrelation
    )


def restless(shape: Shape, factor: float) -> Shape:
    """The same noise, the parts of it that change `factor` times as large."""
    white, slow, fixed = (share * shape.spread**2 for share in shape.autocorrelation.shares)
    parts = np.array([factor**2 * white, factor**2 * slow, fixed])
    shares = np.round(parts / parts.sum(), 3)
    shares[2] = round(1.0 - shares[:2].sum(), 3)
    autocorrelation = Autocorrelation(tuple(shares.tolist()), shape.autocorrelation.seconds)
    return replace(
        shape, spread=round(float(np.sqrt(parts.sum())), 4), autocorrelation=autocorrelation
    )


def matched(samples: list[Sample], pose: Pose, shape: Shape) -> Shape:
    """The noise that changes so much larger that cars are told apart as often as measured.

    The pooled noise is Gaussian and alike in all coefficients; the measured one is neither.
    """
    measured = [each.measured for each in samples]
    wanted = np.array([rank1(samples, measured, gap)[0] for gap in GAPS])
    best = (np.inf, shape)
    for factor in FACTORS:
        some = restless(shape, factor)
        made = [each.made(pose, some, 7) for each in samples]
        off = [rank1(samples, made, gap)[0] - want for gap, want in zip(GAPS, wanted, strict=True)]
        best = min(best, (float(np.square(off).sum()), some), key=lambda each: each[0])
    return best[1]


def main() -> None:
    """Measure, fit, compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--frames", type=int, default=60)
    options = parser.parse_args()
    front_end, samples = FrontEnd.of("pose"), []
    for scene in SCENES:
        for seed in range(FIRST_SEED, FIRST_SEED + options.seeds):
            samples.append(Sample(scene, seed, options.frames, front_end))
            print(f"{scene}, seed {seed}: {samples[-1].known} of {samples[-1].asked} measured")
    pose, shape = fit_pose(samples), fit_shape(samples)
    shape = matched(samples, pose, shape)
    print(f"\n{pose}\n{shape}\n\nrank-1, %                shape   pose   eq. 6")
    for gap in GAPS:
        real = rank1(samples, [each.measured for each in samples], gap)
        made = np.mean(
            [
                rank1(samples, [each.made(pose, shape, seed) for each in samples], gap)
                for seed in range(3)
            ],
            axis=0,
        )
        for name, row in (("measured", real), ("made", made)):
            print(f"{gap:2d} frames, {name:8s}     " + "  ".join(f"{100 * x:5.1f}" for x in row))


if __name__ == "__main__":
    main()
