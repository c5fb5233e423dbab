"""Episodes of data association for Stable-Baselines3, many at once; needs the extra `rl`."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy import ndarray as Array

from mot_sim.envs.association_vector_env import AssociationVectorEnv
from tracker.errors import BadConfig

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise ImportError(
        f"Stable-Baselines3 cannot be imported ({error}): pip install 'mot-sim[rl]'"
    ) from error


class StableBaselinesEpisodes(VecEnv):
    """An `AssociationVectorEnv` as a `VecEnv`: for PPO and, with its masks, for MaskablePPO.

    Wrap it in Stable-Baselines3's `VecMonitor` to see the returns of episodes.
    """

    def __init__(self, num_envs: int, **arguments: Any) -> None:
        """arguments: of `AssociationVectorEnv`, but for `autoreset_mode`."""
        mode = AutoresetMode.SAME_STEP
        self.episodes = AssociationVectorEnv(num_envs, autoreset_mode=mode, **arguments)
        self._chosen: Any = None
        spaces = self.episodes.single_observation_space, self.episodes.single_action_space
        super().__init__(num_envs, *spaces)

    def reset(self) -> Any:
        """The first frames of new episodes; `seed` before seeds them."""
        observation, infos = self.episodes.reset(seed=self._first_seed())
        self.reset_infos = self._each(infos)
        self._reset_seeds()
        return observation

    def step_async(self, actions: Any) -> None:
        """Keep what is to be done."""
        self._chosen = actions

    def step_wait(self) -> tuple[Any, Array, Array, list[dict[str, Any]]]:
        """Do it; info holds `terminal_observation` where an episode has ended."""
        observation, rewards, terminated, _, infos = self.episodes.step(self._chosen)
        each = self._each(infos)
        for at in np.flatnonzero(terminated).tolist():
            last = {name: part[at] for name, part in infos["final_info"].items()}
            kept = {name: value for name, value in last.items() if not name.startswith("_")}
            each[at] = kept | {"terminal_observation": infos["final_obs"][at]}
            each[at]["TimeLimit.truncated"] = False
        return observation, rewards.astype(np.float32), terminated, each

    def close(self) -> None:
        """Close the episodes."""
        self.episodes.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of the episodes, or where they lack it of the single environment."""
        for owner in (self.episodes, self.episodes.one):
            if hasattr(owner, attr_name):
                return [getattr(owner, attr_name)] * len(self._chosen_ones(indices))
        raise AttributeError(attr_name)

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Nothing can be set. Raises BadConfig."""
        raise BadConfig(f"{attr_name} cannot be set: episodes at once share what they are made of")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        """`action_masks` or `expert_action` of environments. Raises BadConfig for others."""
        every = self.episodes.call(method_name, *args, **kwargs)
        return [every[at] for at in self._chosen_ones(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """None is."""
        return [False] * len(self._chosen_ones(indices))

    def get_images(self) -> Sequence[Array | None]:
        """The pictures of the episodes."""
        drawn = self.episodes.render()
        return [None] * self.num_envs if drawn is None else list(drawn)

    def _chosen_ones(self, indices: Any) -> list[int]:
        return list(self._get_indices(indices))

    def _first_seed(self) -> list[int | None] | None:
        """Those that `seed` has kept."""
        return None if all(seed is None for seed in self._seeds) else list(self._seeds)

    def _each(self, infos: dict[str, Any]) -> list[dict[str, Any]]:
        """The info of every environment."""
        columns = {
            name: column.tolist()
            for name, column in infos.items()
            if not name.startswith("_") and isinstance(column, Array) and column.dtype != object
        }
        return [
            {name: column[at] for name, column in columns.items()} for at in range(self.num_envs)
        ]
