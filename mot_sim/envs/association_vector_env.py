"""Many episodes of data association at once: what `AssociationEnv` is, for a batch of actions.

Every step of the tracker, of the score and of the observation is one call for all episodes.
"""

from copy import deepcopy
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.envs.association_actions import decide_batch, slots_after
from mot_sim.envs.association_env import AssociationEnv
from mot_sim.envs.association_experts import find_expert
from mot_sim.envs.association_observation import observe_batch
from mot_sim.envs.errors import BadAction, OutOfTurn, require_options
from mot_sim.envs.observations import Observation
from mot_sim.envs.running_clears import LabelledFrames, RunningClears
from tracker.batch import BatchTracker, PreparedFrames, prepare_frames
from tracker.errors import BadConfig

NO_EPISODE = -1
MAX_ENVS = 65536


class AssociationVectorEnv(VectorEnv[Observation, Any, Any]):
    """`num_envs` episodes of `AssociationEnv`, which are stepped together.

    Observations, rewards, ends and info are those of so many single environments, stacked, as
    Gymnasium's own vectors give them; arguments are theirs. autoreset_mode: of Gymnasium's;
    `DISABLED`: `reset` with the option `reset_mask` begins the episodes that have ended. The
    options of `reset` are those of the single environment; `episode_number` may be one per
    environment. `action_masks` gives the masks of all.

    Raises BadConfig for a number of environments that is none, for `render_mode="human"`, and for
    frames that no detector looked at.
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        scene: str = "crossing",
        render_mode: str | None = None,
        **arguments: Any,
    ) -> None:
        if type(num_envs) is not int or not 1 <= num_envs <= MAX_ENVS:
            raise BadConfig(f"num_envs is {num_envs!r}: give 1 to {MAX_ENVS}")
        if render_mode == "human":
            raise BadConfig(
                "render_mode 'human' opens a window for one environment: take 'rgb_array', or "
                "vectorization_mode='sync'"
            )
        known = [mode.value for mode in AutoresetMode]
        if not isinstance(autoreset_mode, AutoresetMode) and autoreset_mode not in known:
            raise BadConfig(f"autoreset_mode is {autoreset_mode!r}: give one of {', '.join(known)}")
        self._made = {"scene": scene, "render_mode": render_mode, **arguments}
        self.one = AssociationEnv(**self._made)
        self.num_envs, self.autoreset_mode = num_envs, AutoresetMode(autoreset_mode)
        self.metadata = {**deepcopy(self.one.metadata), "autoreset_mode": self.autoreset_mode}
        self.render_mode = render_mode
        self.single_observation_space = self.one.observation_space
        self.single_action_space = self.one.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._tracker = BatchTracker(self.one.tracker, num_envs)
        self._clears = RunningClears(num_envs)
        self._frames: PreparedFrames = prepare_frames(self.one.tracker, (), "none")
        self._labels = LabelledFrames.nothing()
        self._first: dict[int, int] = {}  # row of an episode's first frame, by its number
        self._labelled_of: dict[int, int] = {}
        self._length_of: dict[int, int] = {}
        self._generators: list[np.random.Generator] | None = None
        self._episodes = np.full(num_envs, NO_EPISODE)
        self._begins, self._lengths, self._done = np.zeros((3, num_envs), np.int64)
        self._labelled = np.ones(num_envs)
        self._refused = np.zeros(num_envs, np.int64)
        self._slots = np.zeros(0, np.int64)
        self._actions: list[list[Array]] = [[] for _ in range(num_envs)]
        self._drawn: dict[int, AssociationEnv] = {}
        self._compared = self._tracker.compare(self._frames, np.zeros(num_envs, np.int64))

    @property
    def pool(self) -> int:
        """How many episodes there are."""
        return self.one.pool

    @property
    def is_over(self) -> Bool[Array, " e"]:
        """Which episodes have ended; of those that have not begun all."""
        return self._done >= self._lengths

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """The first frames of new episodes, drawn by each environment for itself.

        seed: that of the first one, the others have the next ones; or one for each. Raises
        UnknownName and BadConfig.
        """
        chosen = require_options(options, ("episode_number", "reset_mask"))
        drives = np.flatnonzero(self._reset_mask(chosen.get("reset_mask")))
        self._seed(seed, drives)
        self._begin(drives, self._numbers(chosen.get("episode_number"), drives))
        self._compare()
        return self._observe(), self._info(drives)

    def step(
        self, actions: Any
    ) -> tuple[
        Observation, Float[Array, " e"], Bool[Array, " e"], Bool[Array, " e"], dict[str, Any]
    ]:
        """Decide on a frame of every episode; the next ones. Raises OutOfTurn and BadAction.

        In the mode NEXT_STEP what has ended begins anew instead, and its action is not used.
        """
        if (self._episodes == NO_EPISODE).any():
            raise OutOfTurn("nothing has begun: call reset() first")
        action, was_over = self._checked(actions), self.is_over
        if was_over.any() and self.autoreset_mode == AutoresetMode.DISABLED:
            raise OutOfTurn(
                f"a step after the end of {np.flatnonzero(was_over).tolist()}: call "
                "reset(options={'reset_mask': ...}) first"
            )
        rewards = self._decide(action, ~was_over)
        terminated = self.is_over & ~was_over
        infos: dict[str, Any] = {}
        again = np.flatnonzero(was_over)
        ended = np.flatnonzero(terminated)
        if self.autoreset_mode == AutoresetMode.SAME_STEP and len(ended):
            again, last = ended, self._info(ended)
            over = self._nothing_seen()
            for drive in ended.tolist():
                mine = {key: last[key][drive].item() for key in last if not key.startswith("_")}
                final = {"final_obs": deepcopy(over), "final_info": mine}
                infos = self._add_info(infos, final, drive)
        if len(again):
            self._begin(again, self._numbers(None, again))
        if len(ended):
            self._forget(np.setdiff1d(ended, again))
        self._compare()
        infos.update(self._info(np.arange(self.num_envs)))
        observation = self._observe()
        return observation, rewards, terminated, np.zeros(self.num_envs, bool), infos

    def action_masks(self) -> Bool[Array, "e c"]:
        """`AssociationEnv.action_masks` of all. Raises OutOfTurn before the first reset."""
        if (self._episodes == NO_EPISODE).any():
            raise OutOfTurn("nothing has begun: call reset() first")
        compared, t, d = self._compared, self.one.max_tracks, self.one.max_detections
        masks = np.zeros((self.num_envs, d, t + 2), bool)
        masks[:, :, t + 1] = True
        is_finite = np.isfinite(compared.costs)
        rows, columns = (which[is_finite] for which in compared.pairs)
        of_track, of_found = compared.track_drives, compared.detection_drives
        places = np.arange(len(of_found)) - compared.columns[of_found]
        masks[of_track[rows], places[columns], self._slots[rows]] = True
        masks[of_found, places, t] = (np.diff(compared.starts) < t)[of_found]
        return masks.reshape(self.num_envs, -1)

    def expert_actions(self, name: str = "hungarian") -> Int[Array, "e d"]:
        """What an expert of EXPERTS does now in every episode. Raises UnknownName, OutOfTurn."""
        policy, seen = find_expert(name), self._observe()
        if self.is_over.any() and self.autoreset_mode != AutoresetMode.NEXT_STEP:
            raise OutOfTurn(f"the {name} expert was asked after the end: call reset() first")
        each = [{key: part[drive] for key, part in seen.items()} for drive in range(self.num_envs)]
        return np.stack([policy(one) for one in each])

    def call(self, name: str, *arguments: Any, **named: Any) -> tuple[Any, ...]:
        """`action_masks` or `expert_action` of every environment, as Gymnasium's vectors have it.

        Raises BadConfig for other names.
        """
        known = {"action_masks": self.action_masks, "expert_action": self.expert_actions}
        if name not in known:
            raise BadConfig(f"{name!r} cannot be called: known are {', '.join(known)}")
        return tuple(known[name](*arguments, **named))

    def render(self) -> tuple[Any, ...] | None:
        """The frame of every episode that was decided last, see `AssociationEnv.render`."""
        if (self._episodes == NO_EPISODE).any():
            raise OutOfTurn("nothing has begun: call reset() first")
        if self.render_mode is None:
            return None
        return tuple(self._picture(drive) for drive in range(self.num_envs))

    def _picture(self, drive: int) -> Any:
        """The picture of an episode, drawn by a single environment that does the same."""
        if drive not in self._drawn:
            self._drawn[drive] = AssociationEnv(**self._made)
            self._drawn[drive].source = self.one.source
        one, actions = self._drawn[drive], self._actions[drive]
        if one.played[0] != self._episodes[drive] or one.played[1] > len(actions):
            one.reset(options={"episode_number": int(self._episodes[drive])})
        for action in actions[one.played[1] :]:
            one.step(action)
        return one.render()

    def _reset_mask(self, given: Any) -> Bool[Array, " e"]:
        """Which environments are reset."""
        if given is None:
            return np.ones(self.num_envs, bool)
        mask = np.asarray(given)
        if mask.shape != (self.num_envs,) or mask.dtype != bool or not mask.any():
            raise BadConfig(
                f"reset_mask of shape {mask.shape} and type {mask.dtype}: give {self.num_envs} "
                "booleans, one of them true"
            )
        if (self._episodes[~mask] == NO_EPISODE).any():
            raise OutOfTurn("reset_mask leaves out what has not begun: reset all first")
        return mask

    def _seed(self, seed: int | list[int | None] | None, drives: Int[Array, " r"]) -> None:
        """Make the generators that draw episodes, where they are asked for."""
        if seed is None or isinstance(seed, int | np.integer):
            first = None if seed is None else int(seed)
            seeds = [None if first is None else first + at for at in range(self.num_envs)]
        else:
            seeds = list(seed)
        if len(seeds) != self.num_envs:
            raise BadConfig(f"{len(seeds)} seeds for {self.num_envs} environments")
        if self._generators is None:
            self._generators = [seeding.np_random(None)[0] for _ in seeds]
        for drive in drives.tolist():
            if seeds[drive] is not None:
                self._generators[drive] = seeding.np_random(seeds[drive])[0]

    def _numbers(self, given: Any, drives: Int[Array, " r"]) -> list[int]:
        """Of the episodes that these environments play now."""
        if given is None:
            assert self._generators is not None
            return [int(self._generators[drive].integers(self.pool)) for drive in drives.tolist()]
        numbers = np.asarray(given)
        if numbers.shape not in {(), (self.num_envs,)} or numbers.dtype.kind not in "iu":
            raise BadConfig(f"episode_number {given!r}: give a number, or {self.num_envs}")
        every = np.broadcast_to(numbers, self.num_envs)[drives].tolist()
        for number in every:
            if not 0 <= number < self.pool:
                raise BadConfig(f"episode_number {number}: there are 0 to {self.pool - 1}")
        return every

    def _begin(self, drives: Int[Array, " r"], numbers: list[int]) -> None:
        """Play these episodes from their beginning."""
        for number in numbers:
            if number not in self._first:
                self._load(number)
        self._forget(drives)
        self._clears.reset(drives)
        self._episodes[drives], self._done[drives], self._refused[drives] = numbers, 0, 0
        self._begins[drives] = [self._first[number] for number in numbers]
        self._lengths[drives] = [self._length_of[number] for number in numbers]
        self._labelled[drives] = [self._labelled_of[number] for number in numbers]
        for drive in drives.tolist():
            self._actions[drive] = []

    def _load(self, number: int) -> None:
        """Prepare an episode of the pool."""
        frames, truth, labelled = self.one.episode(number)
        prepared = prepare_frames(self.one.tracker, frames, f"episode {number}")
        self._first[number] = len(self._frames)
        self._length_of[number], self._labelled_of[number] = len(frames), labelled
        self._frames = prepared.after(self._frames)
        self._labels = LabelledFrames.of(truth, len(frames)).after(self._labels)

    def _forget(self, drives: Int[Array, " r"]) -> None:
        """Drop the tracks of these episodes."""
        if len(drives):
            self._slots = self._slots[self._tracker.reset(drives)]

    def _compare(self) -> None:
        """The next frames, and what their detections cost; nothing is decided yet."""
        at = np.where(self.is_over, 0, self._begins + self._done)
        self._compared, self._at = self._tracker.compare(self._frames, at), at

    def _decide(
        self, action: Int[Array, "e d"], is_stepped: Bool[Array, " e"]
    ) -> Float[Array, " e"]:
        """Match as the actions say, count the rows of the frames; the rewards."""
        match, refused = decide_batch(action, self._compared, self._slots, self.one.max_tracks)
        self._refused = np.bincount(
            self._compared.detection_drives[refused], minlength=self.num_envs
        )
        rows = self._tracker.apply_match(self._compared, match)
        shape = self.num_envs, self.one.max_tracks
        self._slots = slots_after(self._slots, rows.sources, rows.drives, shape)
        before = self._clears.gain
        self._clears.add(self._labels, self._at, rows.output)
        self._done += is_stepped
        if self.render_mode is not None:
            for drive in np.flatnonzero(is_stepped).tolist():
                self._actions[drive].append(action[drive].copy())
        lost = self.one.penalty * self._refused
        return (self._clears.gain - before - lost) / self._labelled

    def _checked(self, actions: Any) -> Int[Array, "e d"]:
        """The actions. Raises BadAction for what is not in the space."""
        shape, most = self.action_space.shape, self.one.max_tracks + 1
        action = np.asarray(actions)
        if action.shape != shape or action.dtype.kind not in "iu":
            raise BadAction(
                f"actions of shape {action.shape} and type {action.dtype}: give whole numbers of "
                f"shape {shape}, one row per environment, one column per detection"
            )
        wrong = (action < 0) | (action > most)
        if wrong.any():
            drive, column = np.argwhere(wrong)[0].tolist()
            raise BadAction(
                f"action {action[drive, column]} of environment {drive} for detection {column}: "
                f"give slots 0 to {most - 2}, {most - 1} for a new track, {most} to reject"
            )
        return action.astype(np.int64)

    def _observe(self) -> Observation:
        """The tracks and detections of the frames, and what each pair costs; new arrays."""
        sizes = self.one.max_tracks, self.one.max_detections
        return observe_batch(self._compared, self._slots, self.one.tracker.camera, *sizes)

    def _nothing_seen(self) -> Observation:
        """What a single environment shows after the end of an episode."""
        return self.one.look_at_nothing()

    def _info(self, drives: Int[Array, " r"]) -> dict[str, Any]:
        """The info of these environments, as Gymnasium's vectors have it."""
        total = self._clears
        labels = np.maximum(1, total.CLR_TP + total.CLR_FN)
        columns = {
            "episode_number": self._episodes,
            "frame": self._done,
            "refused": self._refused,
            "CLR_TP": total.CLR_TP,
            "CLR_FP": total.CLR_FP,
            "CLR_FN": total.CLR_FN,
            "IDSW": total.IDSW,
            "MOTA": total.gain / labels,
        }
        is_told = np.zeros(self.num_envs, bool)
        is_told[drives] = True
        told: dict[str, Any] = {}
        for name, column in columns.items():
            told[name], told[f"_{name}"] = np.where(is_told, column, 0), is_told.copy()
        return told


__all__ = ["AssociationVectorEnv"]
