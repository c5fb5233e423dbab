"""What trackers are given: truth recorded once a scene and seed, then seen under conditions."""

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.recorded import DetectionLog, RecordedSequence
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.files.cache_folder import read_or_make
from mot_sim.files.fingerprint import digest, truth_digest
from mot_sim.files.kept import keep_within, mark_used, size_limit
from mot_sim.files.settings import versions
from mot_sim.metrics.spatial import SpatialScores, spatial_scores
from mot_sim.simulation.episode import episode_of
from mot_sim.simulation.episodes.extra import Extra, Metadata, arrays_of, read_extra, write_extra
from mot_sim.simulation.scene import Rollout, record_scene_traffic
from mot_sim.simulation.sensors import Detector, Timed
from mot_sim.simulation.traffic.recording import RecordedTraffic
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from mot_sim.simulation.truth import annotate, labels
from tracker.geometry import invert
from tracker.types import Sequence, Tracks
from tracker.user_cache import user_cache


@dataclass(frozen=True, eq=False)
class TrialSequence:
    """What a tracker is given, and what it is scored against."""

    sequence: Sequence
    """The frames as they reach the tracker, in the order of time."""
    truth: Tracks
    """The labels of the frames that reach the tracker."""
    frame_count: int
    """Frames of the recording, including those that never arrive."""
    Ts_world_road: Float[Array, "m 4 4"]
    """For each of them where the true road frame stands in the world."""
    frame_rate: float = 1.0 / STEP_SECONDS
    """Frames of the recording per second, Hz."""

    def spatial_scores(self, output: Tracks) -> SpatialScores:
        """The scores of an output's cuboids. Raises BadTracks where it has none."""
        return spatial_scores(
            self.truth, output, self.frame_count, self.Ts_world_road, self.frame_rate
        )


def traffic_key(conditions: Conditions, seed: int) -> str:
    """The name of the recorded traffic: equal for all conditions that share it."""
    return digest([truth_digest(), "traffic", conditions.traffic(), seed])


def truth_key(conditions: Conditions, seed: int) -> str:
    """The name of the recorded truth."""
    return digest([truth_digest(), "truth", conditions.truth(), seed])


@dataclass(frozen=True)
class Recordings:
    """Recorded traffic and truth in a folder, each made when it is first asked for.

    Files appear whole; one that is damaged is made again. Two processes that make the same one
    write the same bytes.
    """

    folder: Path
    """The folder; traffic lies in `traffic` inside it, truth in `truth`."""

    @classmethod
    def shared(cls) -> "Recordings":
        """Those that everything here shares; what was used longest ago goes beyond a limit."""
        return cls(default_cache() / truth_digest()[:16])

    @classmethod
    def beside(cls, folder: Path) -> "Recordings":
        """The shared ones, or others in a folder where the shared ones cannot be written."""
        shared = cls.shared()
        try:
            shared.folder.mkdir(parents=True, exist_ok=True)
            with TemporaryFile(dir=shared.folder):
                return shared
        except OSError:
            return cls(folder)

    def truth_path(self, conditions: Conditions, seed: int) -> Path:
        """Where the truth lies, or will lie."""
        return self.folder / "truth" / f"{truth_key(conditions, seed)}.npz"

    def traffic_path(self, conditions: Conditions, seed: int) -> Path:
        """Where the traffic lies, or will lie."""
        return self.folder / "traffic" / f"{traffic_key(conditions, seed)}.npz"

    def truth(self, conditions: Conditions, seed: int) -> Extra:
        """Traffic, cast and truth; those read last are kept in memory."""
        path = self.truth_path(conditions, seed)
        return self._kept(path, _read, lambda path: self._annotate(conditions, seed, path))

    def record_truth(self, conditions: Conditions, seed: int) -> None:
        """Let the truth lie in its file, for those who read it later."""
        path = self.truth_path(conditions, seed)
        if not path.is_file():
            self._made(path, lambda path: self._annotate(conditions, seed, path))

    def _kept(self, path: Path, read: Callable[[Path], Any], make: Callable[[Path], None]) -> Any:
        """What a file holds, made if need be."""
        found = read_or_make(path, read, lambda path: self._made(path, make))
        mark_used(path)
        return found

    def _made(self, path: Path, make: Callable[[Path], None]) -> None:
        """Make a file; shared ones beyond the limit are removed."""
        make(path)
        if self.folder.parent == default_cache():
            keep_within(default_cache(), size_limit(), [path])

    def traffic(self, conditions: Conditions, seed: int) -> RecordedTraffic:
        """Who is where."""
        path = self.traffic_path(conditions, seed)
        return self._kept(
            path,
            RecordedTraffic.load,
            lambda path: record_scene_traffic(conditions.make_scene(), seed).save(path),
        )

    def _annotate(self, conditions: Conditions, seed: int, path: Path) -> None:
        """Write the truth of a run."""
        scene = replace(conditions.make_scene(), detector=Detector("perfect"))
        take = Rollout.of(scene, seed, self.traffic(conditions, seed))
        episode = episode_of(
            take, annotate(take.traffic_states, take.scene_meshes, take.scenery_in)
        )
        knobs = dict(conditions.traffic()["knobs"])
        metadata = Metadata(scene.name, knobs, seed, len(take), None, (), versions(), {})
        write_extra(path, metadata, arrays_of(episode))


def default_cache() -> Path:
    """Where recordings lie when nobody says where."""
    named = os.environ.get("MOT_SIM_CACHE")
    return Path(named) if named else user_cache("episodes")


@lru_cache(maxsize=4)
def _read(path: Path) -> Extra:
    return read_extra(path)


def drive_of(conditions: Conditions, recorded: Extra, seed: int) -> TrialSequence:
    """A recorded run as detector, odometry, clock and calibration of these conditions show it.

    All draws hang on (seed, effect, object, frame): levels that differ share them.
    """
    count, camera = recorded.metadata.frames, recorded.camera
    truth = recorded.annotations.truth
    log = conditions.make_detector()(truth, seed, camera, count, recorded.vehicles)
    wrong = conditions.miscalibration
    boxes = wrong.shake(log.detections.boxes, log.frames, camera, seed, STEP_SECONDS)
    rig = conditions.rig.rig
    poses = rig.Ts_world_cam(recorded.traffic)
    scores = conditions.seen_scores(log.detections.scores)
    whole = RecordedSequence(
        name=f"{conditions.scene}/{seed}",
        camera=wrong.believed(conditions.rig.believed, seed),
        frame_count=count,
        log=DetectionLog(log.frames, replace(log.detections, boxes=boxes, scores=scores)),
        frame_indices=conditions.frames(count),
        Ts_world_cam=conditions.odometry(poses, seed, STEP_SECONDS),
        motion_cov=conditions.odometry.motion_cov(poses, STEP_SECONDS),
        frame_rate=1.0 / STEP_SECONDS,
    )
    arriving: Timed = conditions.timing(whole, seed)
    labelled = labels(truth)
    came = np.isin(labelled.frames, arriving.sequence.frame_indices)
    roads = poses @ invert(camera.T_road_cam)
    return TrialSequence(arriving, labelled.select(came), count, roads)
