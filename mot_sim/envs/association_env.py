"""Data association as a Gymnasium environment: who is who, decided a frame at a time.

The return of an episode is its MOTA (Bernardin & Stiefelhagen, EURASIP 2008, as TrackEval counts
KITTI's cars) for immediate output without filled gaps.
"""

from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from jaxtyping import Bool, Int, UInt8
from numpy import ndarray as Array

from mot_sim.envs.association_actions import Decision, Slots, decide, mask_of
from mot_sim.envs.association_experts import find_expert
from mot_sim.envs.association_observation import association_space, observe_association
from mot_sim.envs.episode_sources import EpisodeSource, FolderSource, SceneSource
from mot_sim.envs.errors import OutOfTurn, require_action, require_options
from mot_sim.envs.image_window import (
    RENDER_MODES,
    ImageWindow,
    require_render_mode,
    warn_without_mode,
)
from mot_sim.envs.observations import Observation, require_padding, surest
from mot_sim.envs.rollouts import ReplayPickle, scene_made
from mot_sim.envs.wrappers import RunningClear, counted_labels
from mot_sim.files.named_objects import make_tracker, without_own_name
from mot_sim.simulation.episode import SimulatedDrive
from mot_sim.simulation.scene import Knob
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from tracker import CostMatrix, Tracker, Tracks
from tracker.errors import BadConfig
from tracker.types import Frame


class AssociationEnv(ReplayPickle, gym.Env[Observation, Any]):
    """Recorded episodes, in which the action says what becomes of every detection of a frame.

    Action: for each detection a track's slot (0 to max_tracks - 1), `new` (max_tracks) or
    `reject` (max_tracks + 1); entries beyond the detections are ignored. Of two detections on
    one track the one with the larger cost is rejected (of equal costs the later one).
    Rejected are also those on an empty slot, on a track where they are not `possible`, and new
    ones when no slot is free; info counts them all as `refused`.

    Observation: see `observe_association`. Detections are those that the tracker does not
    suppress, of too many the surest. Reward: TP - FP - IDSW of the frame, less `penalty` for each
    refused decision, over the boxes of the episode that must be found, at least 1. Tracks die as
    the tracker's lifecycle says. The episode terminates after its last frame, with nothing to see.

    scene, knobs: the episodes of the `pool` seeds from first_seed on are recorded when they are
    drawn, and kept. episodes: a folder of recorded ones instead. tracker: of TRACKERS, whose
    suppression, costs and memory are used. penalty: 1 costs as much as a false positive.
    render_mode: `rgb_array` or `human`; the frame that was decided last. info: `episode_number`
    (in the pool, from 0), `frame`, `refused`, and CLR_TP, CLR_FP, CLR_FN, IDSW and MOTA so far.
    Raises UnknownName, BadConfig, DatasetNotFound.
    """

    # gym.make reads the class's; an instance has its own copy.
    metadata: dict[str, Any] = {  # noqa: RUF012
        "render_modes": list(RENDER_MODES),
        "render_fps": round(1.0 / STEP_SECONDS),
    }

    def __init__(
        self,
        scene: str = "crossing",
        *,
        episodes: str | None = None,
        first_seed: int = 0,
        pool: int = 16,
        tracker: str = "default",
        max_detections: int = 64,
        max_tracks: int = 64,
        penalty: float = 0.0,
        render_mode: str | None = None,
        **knobs: Knob,
    ) -> None:
        self._arguments = {
            "scene": scene,
            "episodes": episodes,
            "first_seed": first_seed,
            "pool": pool,
            "tracker": tracker,
            "max_detections": max_detections,
            "max_tracks": max_tracks,
            "penalty": penalty,
            "render_mode": render_mode,
            **knobs,
        }
        require_padding("max_detections", max_detections)
        require_padding("max_tracks", max_tracks)
        require_render_mode(render_mode)
        if not 0.0 <= penalty < np.inf:
            raise BadConfig(f"penalty is {penalty:g}: give 0 or more, finite")
        self.metadata, self.render_mode = deepcopy(AssociationEnv.metadata), render_mode
        self.penalty = penalty
        self.max_detections, self.max_tracks = max_detections, max_tracks
        self.source: EpisodeSource = _source_of(scene, episodes, first_seed, pool, knobs)
        ours: Tracker = make_tracker(without_own_name(tracker), self.source.camera, Tracker)
        # Tracks begin where the action says so, whatever the score.
        self.tracker = replace(ours, lifecycle=replace(ours.lifecycle, birth_score=-np.inf))
        self._episode: int | None = None
        self._actions: list[Any] = []
        self._decided: tuple[CostMatrix, Decision] | None = None
        self._window: ImageWindow | None = None
        self.observation_space = association_space(max_tracks, max_detections)
        self.action_space = spaces.MultiDiscrete(np.full(max_detections, max_tracks + 2))

    @property
    def pool(self) -> int:
        """How many episodes there are."""
        return len(self.source)

    @property
    def tracks(self) -> Tracks:
        """The rows of this episode so far."""
        return Tracks.concatenate([Tracks.empty(), *self._rows])

    @property
    def played(self) -> tuple[int | None, int]:
        """The number of this episode, and how many frames of it were decided."""
        return self._episode, len(self._actions)

    def episode(self, number: int) -> tuple[list[Frame], Tracks, int]:
        """An episode of the pool: its frames as they are decided, labels, how many count."""
        drive = self.source.load(number)
        return [self._decidable(frame) for frame in drive], drive.truth, count_labelled(drive)

    def look_at_nothing(self) -> Observation:
        """The observation after the end of an episode."""
        sizes = self.max_tracks, self.max_detections
        return observe_association(None, np.zeros(0, np.int64), self.source.camera, *sizes)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """The first frame of an episode that is drawn, or of options' `episode_number`.

        Raises UnknownName for other options, BadConfig for a number that is not there.
        """
        super().reset(seed=seed)
        chosen = require_options(options, ("episode_number",)).get("episode_number")
        number = int(self.np_random.integers(len(self.source)) if chosen is None else chosen)
        if not 0 <= number < len(self.source):
            raise BadConfig(f"episode_number {number}: there are 0 to {len(self.source) - 1}")
        self._begin(number)
        return self._observe(), self._info()

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Decide on a frame; the next one. Raises OutOfTurn and BadAction."""
        self._require_turn("a step")
        meaning = (
            f"give {self.max_detections} numbers: slots 0 to {self.max_tracks - 1}, "
            f"{self.max_tracks} for a new track, {self.max_tracks + 1} to reject"
        )
        require_action(self.action_space, action, meaning)
        before = self._clear.total.gain
        self._advance(np.array(action))
        lost = self.penalty * self._refused
        reward = (self._clear.total.gain - before - lost) / self._labelled
        return self._observe(), reward, self._is_over, False, self._info()

    def action_masks(self) -> Bool[Array, " c"]:
        """For every detection, one after another, which of its choices are not refused.

        It is what MaskablePPO of sb3-contrib asks for; see `mask_of`. After the end only
        rejection is left. Raises OutOfTurn before the first reset.
        """
        self._require_begun()
        possible = np.zeros((self.max_tracks, self.max_detections), bool)
        detections = np.zeros(self.max_detections, bool)
        if not self._is_over:
            costs = self._compared.costs
            possible[self._slots.of(self._compared.tracks.ids), : costs.shape[1]] = np.isfinite(
                costs
            )
            detections[: costs.shape[1]] = True
        return mask_of(possible, self._slots.taken, detections).ravel()

    def expert_action(self, name: str = "hungarian") -> Int[Array, " d"]:
        """What an expert of EXPERTS does now. Raises OutOfTurn after the end, UnknownName."""
        policy = find_expert(name)
        self._require_turn(f"the {name} expert was asked")
        return policy(self._look())

    def render(self) -> UInt8[Array, "h w 3"] | None:
        """The frame that was decided last, or after `reset` the first one.

        None where it goes to a window, and, with a warning, without a render mode. Raises
        OutOfTurn before the first reset.
        """
        self._require_begun()
        warn_without_mode(self.render_mode)
        if self.render_mode == "human":
            self._show()
        return self._draw() if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Close the window and end the episode; `reset` begins anew."""
        if self._window is not None:
            self._window.close()
        self._window, self._episode = None, None

    def _require_begun(self) -> None:
        if self._episode is None:
            raise OutOfTurn("nothing has begun: call reset() first")

    def _require_turn(self, what: str) -> None:
        """OutOfTurn before the first reset and after the end."""
        self._require_begun()
        if self._is_over:
            raise OutOfTurn(f"{what} after the end, frame {len(self._actions)}: call reset() first")

    @property
    def _is_over(self) -> bool:
        return len(self._actions) >= len(self._frames)

    def _begin(self, episode: int) -> None:
        """Play an episode from its beginning."""
        drive = self.source.load(episode)
        self._episode, self._actions = episode, []
        self._frames, self._truth = list(drive), drive.truth
        self._labelled = count_labelled(drive)
        self._clear, self._rows = RunningClear(), list[Tracks]()
        self._refused, self._decided = 0, None
        self._slots = Slots.empty(self.max_tracks)
        self.tracker.reset()
        self._compare()

    def _compare(self) -> None:
        """The next frame, and what its detections cost; nothing is decided yet."""
        if self._is_over:
            return
        self._frame: Frame = self._decidable(self._frames[len(self._actions)])
        self._compared: CostMatrix = self.tracker.cost_matrix(self._frame)

    def _decidable(self, frame: Frame) -> Frame:
        """A frame with the detections that are decided on."""
        if not frame.looked_at:
            return frame
        kept = self.tracker.suppress(frame.found, self.tracker.camera)
        return replace(frame, detections=surest(kept, self.max_detections))

    def _advance(self, action: Int[Array, " m"]) -> None:
        """Match as the action says; count the rows of the frame."""
        compared, index = self._compared, self._frame.index
        slots = self._slots.of(compared.tracks.ids)
        decisions = action[: len(compared.detections)]
        match, refused = decide(decisions, compared.costs, slots, self.max_tracks)
        rows = self.tracker.apply_match(self._frame, compared, match)
        living = self.tracker.state.tracks.ids
        born = living[len(living) - len(match.unmatched_detections) :]
        self._decided = compared, Decision(match, refused, born)
        self._refused, self._slots = int(refused.sum()), self._slots.after(living)
        first, last = np.searchsorted(self._truth.frames, [index, index + 1]).tolist()
        self._clear.add(self._truth.select(slice(first, last)), rows, index)
        self._rows.append(rows)
        self._actions.append(action)
        self._compare()

    def _observe(self) -> Observation:
        """The tracks and detections of this frame, and what each pair costs."""
        if self.render_mode == "human":
            self._show()
        return self._look()

    def _look(self) -> Observation:
        """New arrays with what is seen now."""
        compared = None if self._is_over else self._compared
        slots = np.zeros(0, np.int64) if compared is None else self._slots.of(compared.tracks.ids)
        sizes = self.max_tracks, self.max_detections
        return observe_association(compared, slots, self.source.camera, *sizes)

    def _draw(self) -> UInt8[Array, "h w 3"]:
        """The frame that was decided last; before the first decision the frame that is seen."""
        from mot_sim.envs.association_drawing import draw_association  # noqa: PLC0415 - OpenCV

        total, camera = self._clear.total, self.source.camera
        compared, decision = self._decided or (self._compared, None)
        words = (
            f"frame {max(len(self._actions) - 1, 0)}: TP {total.CLR_TP}, FP {total.CLR_FP}, "
            f"IDSW {total.IDSW}, refused {self._refused}"
        )
        return draw_association(compared, decision, camera, words)

    def _show(self) -> None:
        if self._window is None:
            self._window = ImageWindow("mot-sim: association", self.metadata["render_fps"])
        self._window.show(self._draw())

    def _info(self) -> dict[str, Any]:
        """The same keys after every step."""
        total = self._clear.total
        now = {
            "episode_number": self._episode,
            "frame": len(self._actions),
            "refused": self._refused,
        }
        return {**now, **vars(total), "MOTA": total.MOTA}


def count_labelled(drive: SimulatedDrive) -> int:
    """Boxes of an episode that must be found, at least 1."""
    return max(1, counted_labels(drive.truth, drive.frame_count))


def _source_of(
    scene: str, episodes: str | None, first_seed: int, pool: int, knobs: dict[str, Knob]
) -> EpisodeSource:
    """A folder's episodes, or a scene's."""
    if episodes is None:
        return SceneSource(scene_made(scene, tuple(sorted(knobs.items()))), pool, first_seed)
    if knobs or first_seed:
        named = sorted([*knobs, *(["first_seed"] if first_seed else [])])
        raise BadConfig(f"episodes of a folder are what they are: drop {named}")
    return FolderSource.find(Path(episodes))


__all__ = ["AssociationEnv"]
