"""A tracker that follows many drives at once: what one tracker per drive gives, row by row.

Almost all that a frame costs is the calls of many small steps; here every step is one call for all
drives. Each row of a table is a track or a detection, with its drive; drives ascend.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.batch.batch_costs import BatchCosts, BatchMatch, DrivePairs
from tracker.batch.car_pool import CarPool
from tracker.batch.drive_memories import DriveRoads, slopes_of
from tracker.batch.prepared_frames import FrameMotions, PreparedFrames, road_terms
from tracker.beliefs import Beliefs
from tracker.box_filter import LIMITS as GAIN_LIMITS
from tracker.box_filter import Gains
from tracker.car_filter.carried_boxes import MAX_GROWTH
from tracker.car_filter.projection import CUBOID_EDGES
from tracker.ego_motion import LIMITS, RoadMotion
from tracker.existence import LIMITS as EXISTENCE_LIMITS
from tracker.existence import DetectorStatistics, leaving_border
from tracker.kernels import Kernel
from tracker.lifecycle import MAX_CONSECUTIVE_STEPS, NO_TRACKS, ActiveTracks
from tracker.tracker import Tracker
from tracker.types import CarEstimates, Cuboids, Detections, Tracks
from tracker.types.cuboids import CORNERS
from tracker.types.shape_pose import ShapePose

MODULE = "tracker.kernels.drives"
CARRY = Kernel(MODULE, "carry_each")
CARRY_BOXES = Kernel(MODULE, "carry_boxes_each")
FILTER_EACH = Kernel(MODULE, "filter_boxes_each")
JUDGE = Kernel("tracker.kernels.existing", "judge_each")


class BatchRows(NamedTuple):
    """What becomes of the tracks of all drives in a frame."""

    output: Tracks
    """The rows that are put out; `frames` holds the drive of each."""
    sources: Int[Array, " n"]
    """For every track now its row among those before; -1: it began in this frame."""
    drives: Int[Array, " n"]
    """For every track now its drive."""


class BatchTracker:
    """One tracker on many drives, whose memories do not meet."""

    def __init__(self, tracker: Tracker, count: int) -> None:
        """tracker: how all drives are tracked. count: how many drives there are."""
        self.how, self.count, self.tracks = tracker, count, NO_TRACKS
        self.starts = np.zeros(count + 1, np.int64)
        cars = tracker.car_filter
        self.cars = None if cars is None else CarPool(cars, tracker.camera)
        self.places = np.zeros(0, np.int64)
        self.estimates = CarEstimates.unknown(0)
        self._gains = [np.empty(0)] * 3
        self.next_ids = np.zeros(count, np.int64)
        self._forget(np.arange(count))

    def _forget(self, drives: Int[Array, " r"]) -> None:
        """All that is known of drives, but their tracks."""
        how, count = self.how, self.count
        fresh = how.box_filter.start() if how.box_filter is not None else Gains(*[np.zeros(1)] * 3)
        if len(drives) == count:
            self.roads, self.detectors = DriveRoads.unknown(count), np.zeros((count, 4), np.int64)
            self._gains = [np.repeat(part[None], count, 0) for part in fresh]
        else:
            self.roads = self.roads.updated(drives, DriveRoads.unknown(len(drives)))
            self.detectors[drives] = DetectorStatistics()
            for mine, part in zip(self._gains, fresh, strict=True):
                mine[drives] = part
        self.next_ids[drives] = 0

    def reset(self, drives: Int[Array, " r"]) -> Bool[Array, " n"]:
        """Begin these drives anew, with ids from 0 on; which tracks are left, of those before."""
        is_new = np.zeros(self.count, bool)
        is_new[drives] = True
        kept = ~np.repeat(is_new, np.diff(self.starts))
        if not kept.all():
            self._keep(kept.nonzero()[0])
        if len(drives):
            self._forget(drives)
        return kept

    def compare(self, frames: PreparedFrames, at: Int[Array, " e"]) -> BatchCosts:
        """What the detections of a frame of each drive cost; see `Tracker.cost_matrix`.

        at: row of that frame in `frames`, 0 where a drive has none. The tracks are then as
        predicted, so that it is asked for once a frame.
        """
        how, camera = self.how, self.how.camera
        motions = frames.motions.select(at)
        counts = frames.starts[at + 1] - frames.starts[at]
        columns = np.concatenate((np.zeros(1, np.int64), np.cumsum(counts)))
        which = np.arange(columns[-1]) + np.repeat(frames.starts[at] - columns[:-1], counts)
        detections, observed = frames.detections.select(which), frames.observed.select(which)
        drives = np.repeat(np.arange(self.count), np.diff(self.starts))
        tracks, roads, before = self.tracks, self.roads, self.tracks.beliefs.boxes
        if len(tracks):
            tracks, motions = self._predict(tracks, drives, motions, detections, columns)
        if self.cars is not None:
            cars = self.cars.how
            roads, moved = roads.predicted(cars, motions)
            steps = slopes_of(roads, moved, cars, motions)
            if len(tracks):
                moving = motions.T_road, steps, motions.covariance
                self.cars.predict(self.places, drives, *moving)
                if cars.carries_boxes:
                    carried = np.empty(before.shape)
                    sizes = cars.motion._times, cars._log_size
                    lens = camera.P_road, camera.far_corner[0], CORNERS, CUBOID_EDGES, MAX_GROWTH
                    shared = drives, motions.T_road, steps[0], *sizes, *lens
                    CARRY_BOXES(before, self.estimates.means, *shared, carried)
                    given = motions.is_given[drives][:, None]
                    tracks = tracks.expected_at(np.where(given, carried, tracks.beliefs.boxes))
        found = observed, detections, columns
        pairs = DrivePairs(how, (tracks.beliefs, self.starts), found, 0.0)
        costs = self._costs(pairs, drives, motions.dt)
        mine = tracks, self.starts, detections, observed, columns
        return BatchCosts(*mine, pairs.pairs, costs, motions, roads)

    def _predict(
        self,
        tracks: ActiveTracks,
        drives: Int[Array, " n"],
        motions: FrameMotions,
        detections: Detections,
        columns: Int[Array, " _"],
    ) -> tuple[ActiveTracks, FrameMotions]:
        """`Tracker.predict_tracks` of all drives; the motions, corrected by the boxes."""
        dt = motions.dt[drives]
        beliefs, moved = self._moved(tracks.beliefs, dt)
        predicted = self._carried(beliefs, moved, drives, motions)
        if motions.is_uncertain.any():
            corrected = self._corrected(tracks, drives, predicted, motions, detections, columns)
            predicted = self._carried(beliefs, moved, drives, corrected)
            motions = corrected.replaced(covariance=motions.covariance)
        existence = tracks.existence
        if self.how.existence is not None:
            existence = existence * motions.survival[drives]
        later = tracks.replaced(
            beliefs=predicted,
            time_since_update=tracks.time_since_update + dt,
            existence=existence,
            scores=np.full(len(existence), np.nan),
        )
        return later, motions

    def _moved(
        self, beliefs: Beliefs, dt: Float[Array, " n"]
    ) -> tuple[Beliefs, Float[Array, "n 2"]]:
        """`Dynamics.predict`, for each row its own time."""
        times, of = np.unique(dt, return_inverse=True)
        parts, moves = [], []
        for number, seconds in enumerate(times.tolist()):
            part = beliefs if len(times) == 1 else beliefs.select(of == number)
            part, moved = self.how.dynamics.predict(part, seconds)
            parts.append(part)
            moves.append(np.zeros((len(part), 2)) if moved is None else moved)
        if len(times) == 1:
            return parts[0], moves[0]
        back = np.argsort(np.argsort(of, kind="stable"))
        return Beliefs.concatenate(parts).select(back), np.concatenate(moves)[back]

    def _carried(
        self,
        beliefs: Beliefs,
        moved: Float[Array, "n 2"],
        drives: Int[Array, " n"],
        motions: FrameMotions,
    ) -> Beliefs:
        """`compensate_ego_motion`, for each drive its own."""
        n, camera = len(beliefs), self.how.camera
        base, velocity, cov, boxes = out = (
            np.empty((n, 3)), np.empty((n, 2)), np.empty((n, 4, 4)), np.empty((n, 4))
        )  # fmt: skip
        before = beliefs.cuboids.base, beliefs.cuboids.size, beliefs.velocity, beliefs.cov
        of_road = motions.T_road, camera.road_shift, motions.covariance, camera.T_cam_road[2].copy()
        pixels = motions.H, motions.shift, motions.by_moved, LIMITS
        CARRY(*before, beliefs.boxes, moved, self.starts, *of_road, *pixels, *out)
        turn, pose = motions.turn[drives], beliefs.shape_pose
        cuboids = Cuboids(base, beliefs.cuboids.yaw + turn, beliefs.cuboids.size)
        if pose is not None:
            pose = ShapePose(pose.shape, pose.yaw + turn, pose.cov)
        return Beliefs(cuboids, velocity, cov, boxes, pose, beliefs.embedding)

    def _corrected(
        self,
        tracks: ActiveTracks,
        drives: Int[Array, " n"],
        predicted: Beliefs,
        motions: FrameMotions,
        detections: Detections,
        columns: Int[Array, " _"],
    ) -> FrameMotions:
        """The motions after `CameraRotationFilter`, drive by drive."""
        how, turns = self.how, self.how.camera_rotation_filter
        assert turns is not None
        just = tracks.time_since_update <= 0.0
        for drive in motions.is_uncertain.nonzero()[0].tolist():
            mine = just & (drives == drive)
            if not (drives == drive).any():
                continue
            seen = detections.boxes[columns[drive] : columns[drive + 1]]
            given = motions.T_now_before[drive], motions.covariance[drive]
            T, cov = turns(predicted.boxes[mine], seen, *given, how.camera)
            road = RoadMotion.of(T, how.camera)
            kept, _, rise = road_terms(how.car_filter, road, float(motions.dt[drive]))
            row = FrameMotions.select(motions, np.array([drive]))
            row = row.replaced(
                T_now_before=T[None],
                covariance=cov[None],
                kept=np.array([kept]),
                rise=np.array([rise]),
                **{name: np.array([value]) for name, value in road._asdict().items()},
            )
            motions = motions.updated(np.array([drive]), row)
        return motions

    def _costs(
        self, pairs: DrivePairs, drives: Int[Array, " n"], dt: Float[Array, " e"]
    ) -> Float[Array, " k"]:
        """`Tracker.pair_costs`, for each drive with the time since its last frame."""
        rows, _ = pairs.pairs
        if not len(rows):
            return np.zeros(0)
        seconds, of = np.unique(dt[drives[rows]].round(9), return_inverse=True)
        if len(seconds) == 1:
            return self.how.pair_costs(pairs.of(np.ones(len(rows), bool), float(seconds[0])))[0]
        costs = np.empty(len(rows))
        for number, time in enumerate(seconds.tolist()):
            costs[of == number] = self.how.pair_costs(pairs.of(of == number, time))[0]
        return costs

    def apply_match(self, compared: BatchCosts, match: BatchMatch) -> BatchRows:
        """What becomes of the tracks where this is the match; see `Tracker.apply_match`.

        compared: what `compare` gave last. Drives without a frame have no rows.
        """
        how, tracks = self.how, compared.tracks
        rows, columns = np.ascontiguousarray(match.pairs.T)
        missed, born = match.unmatched_tracks, match.unmatched_detections
        scores = compared.detections.scores
        born = born[scores[born] >= how.lifecycle.birth_score]
        of_track, of_found = compared.track_drives, compared.detection_drives
        matched, unmatched = tracks.select(rows), tracks.select(missed)
        seen, gone = (matched, of_track[rows]), (unmatched, of_track[missed])
        hit, miss, fresh = self._existence(compared, seen, gone, columns, born)
        updated = self._updated(compared, *seen, columns, hit)
        roads, places, drives = compared.roads, self.places, of_track
        if self.cars is not None:
            roads = self._update_cars(self.cars, compared, rows, columns, seen[1])
        sources = match.order_after(of_track)
        if self.cars is not None:
            places = places[sources]
        if len(missed):
            updated = tracks.updated(rows, updated)
            updated.existence[missed] = miss
            updated = updated.select(sources)
            alive = how.lifecycle.are_alive(updated, how.camera)
            if not alive.all():
                sources, updated = sources[alive], updated.select(alive)
                if self.cars is not None:
                    self.cars.release(places[~alive])
                    places = places[alive]
                drives = drives[alive]
        if len(born):
            of_born = of_found[born]
            new = compared.observed.select(born)
            first = np.searchsorted(of_born, of_born)
            newborn = ActiveTracks.born(new, scores[born], fresh, 0)
            newborn = newborn.replaced(ids=self.next_ids[of_born] + newborn.ids - first)
            self.next_ids += np.bincount(of_born, minlength=self.count)
            drives = np.concatenate((drives, of_born))
            order = np.argsort(drives, kind="stable")
            updated = ActiveTracks.concatenate((updated, newborn)).select(order)
            sources = np.concatenate((sources, np.full(len(born), -1)))[order]
            if self.cars is not None:
                found = compared.detections.select(born)
                others = compared.detections.boxes, compared.columns
                put = self.cars.start(of_born, roads, new.cuboids.base, found, others)
                places = np.concatenate((places, put))[order]
            drives = drives[order]
        self.tracks, self.roads, self.places = updated, roads, places
        self.starts = np.searchsorted(drives, np.arange(self.count + 1))
        if self.cars is not None:
            self.estimates = self.cars.estimate(places, drives, roads)
        return BatchRows(self._output(drives, compared.motions), sources, drives)

    def _keep(self, rows: Int[Array, " k"]) -> None:
        """Forget the other tracks."""
        drives = np.repeat(np.arange(self.count), np.diff(self.starts))[rows]
        if self.cars is not None:
            self.cars.release(np.delete(self.places, rows))
            self.places, self.estimates = self.places[rows], self.estimates.select(rows)
        self.tracks = self.tracks.select(rows)
        self.starts = np.searchsorted(drives, np.arange(self.count + 1))

    def _existence(
        self,
        compared: BatchCosts,
        seen: tuple[ActiveTracks, Int[Array, " k"]],
        gone: tuple[ActiveTracks, Int[Array, " l"]],
        columns: Int[Array, " k"],
        born: Int[Array, " b"],
    ) -> tuple[Float[Array, " k"], Float[Array, " l"], Float[Array, " b"]]:
        """Probabilities of the matched, the other and the new tracks, in drives' own ways."""
        how, (unmatched, of_missed) = self.how.existence, gone
        if how is None:
            return np.ones(len(columns)), unmatched.existence, np.ones(len(born))
        (matched, of_seen), scores = seen, compared.detections.scores
        hit, miss, fresh = np.empty(len(columns)), np.empty(len(unmatched)), np.empty(len(born))
        of_born = compared.detection_drives[born]
        starts, lost_starts, born_starts = (
            np.searchsorted(drives, np.arange(self.count + 1))
            for drives in (of_seen, of_missed, of_born)
        )
        found = matched.existence, matched.hits, matched.time_since_update, scores[columns]
        lost = unmatched.existence, unmatched.hits, unmatched.time_since_update
        others, right = (
            (compared.detections.boxes, compared.columns),
            leaving_border(self.how.camera),
        )
        steps = MAX_CONSECUTIVE_STEPS * compared.motions.dt, EXISTENCE_LIMITS, right
        begun = *lost, unmatched.beliefs.boxes, lost_starts, scores[born], born_starts
        JUDGE(*found, starts, *begun, *others, how.settings, *steps, hit, miss, fresh,
              self.detectors)  # fmt: skip
        return hit, miss, fresh

    def _updated(
        self,
        compared: BatchCosts,
        matched: ActiveTracks,
        drives: Int[Array, " k"],
        columns: Int[Array, " k"],
        existence: Float[Array, " k"],
    ) -> ActiveTracks:
        """`Tracker.update_tracks`, each drive with its own gains."""
        how, k = self.how, len(columns)
        observed, scores = compared.observed.select(columns), compared.detections.scores[columns]
        updated, innovations = how.dynamics.update(matched.beliefs, observed), matched.innovations
        if how.box_filter is not None and k:
            boxes, innovations, of = np.empty((k, 4)), np.empty((k, 4)), how.box_filter
            starts = np.searchsorted(drives, np.arange(self.count + 1))
            sizes, far = of.size_limits, how.camera.far_corner
            before = matched.beliefs.boxes, updated.boxes, matched.hits, matched.time_since_update
            limits = compared.motions.dt, far, of.border, of.prior, GAIN_LIMITS
            given = *self._gains, sizes, *before, matched.innovations, starts, *limits
            FILTER_EACH(*given, boxes, innovations)
            updated = updated.replaced(boxes=boxes)
        return matched.seen_again(updated, scores, existence, innovations)

    def _update_cars(
        self,
        cars: CarPool,
        compared: BatchCosts,
        rows: Int[Array, " k"],
        columns: Int[Array, " k"],
        drives: Int[Array, " k"],
    ) -> DriveRoads:
        """The cars of matched tracks after their detections; what is known of the roads then."""
        if not len(rows):
            return compared.roads
        starts = np.searchsorted(drives, np.arange(self.count + 1))
        found = compared.detections.select(columns)
        others = compared.detections.boxes, compared.columns
        where = self.places[rows], starts, compared.roads
        return cars.update(*where, found, others, compared.motions.dt)

    def _output(self, drives: Int[Array, " n"], motions: FrameMotions) -> Tracks:
        """The rows that are put out, see `Tracker.step`; without cuboids."""
        how, tracks = self.how, self.tracks
        missed, scores, boxes = np.isnan(tracks.scores), tracks.scores, tracks.beliefs.boxes
        written = ~missed
        if how.existence is not None:
            scores = np.where(missed, tracks.existence, scores)
            written = how.existence.written(tracks)
            unseen = (tracks.time_since_update > 0.0) & motions.is_given[drives]
            if self.cars is not None and how.gap_rows is not None and unseen.any():
                which = unseen.nonzero()[0]
                gone = tracks.select(which), self.estimates.select(which)
                scores[which], written[which] = how.gap_rows(*gone, how.camera)
        if missed.any():
            boxes = np.where(missed[:, None], how.camera.clip_boxes(boxes), boxes)
        return Tracks(drives, tracks.ids, boxes, scores).select(written)
