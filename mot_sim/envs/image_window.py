"""A window that shows what an environment draws."""

from typing import Any

from gymnasium import logger
from jaxtyping import UInt8
from numpy import ndarray as Array

from tracker.errors import UnknownName

RENDER_MODES = ("rgb_array", "human")


def require_render_mode(render_mode: str | None) -> None:
    """UnknownName for what is neither None nor one of RENDER_MODES."""
    if render_mode not in (None, *RENDER_MODES):
        raise UnknownName.of("render mode", str(render_mode), RENDER_MODES)


def warn_without_mode(render_mode: str | None) -> None:
    """Gymnasium's warning for a picture that nobody asked for when the environment was made."""
    if render_mode is None:
        logger.warn(
            "render() gives None without a render mode: gym.make(id, render_mode='rgb_array') for "
            "arrays, 'human' for a window"
        )


class ImageWindow:
    """Shows one image after another; pygame is imported when the first one is shown."""

    def __init__(self, title: str, fps: int) -> None:
        self.title, self.fps = title, fps
        self._pygame: Any = None

    def show(self, image: UInt8[Array, "h w 3"]) -> None:
        """Show an image, and wait until it has been there for its time."""
        if self._pygame is None:
            import pygame  # noqa: PLC0415

            self._pygame = pygame
            pygame.display.init()
            pygame.display.set_caption(self.title)
            self._screen = pygame.display.set_mode(image.shape[1::-1])
            self._clock = pygame.time.Clock()
        surface = self._pygame.surfarray.make_surface(image.swapaxes(0, 1))
        self._screen.blit(surface, (0, 0))
        self._pygame.event.pump()
        self._pygame.display.flip()
        self._clock.tick(self.fps)

    def close(self) -> None:
        """Close it, if it is open."""
        if self._pygame is not None:
            self._pygame.display.quit()
            self._pygame = None
