"""Frames of the running simulation, drawn in this process. See :mod:`lift_lab.drawing.opengl` for what that needs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from lift_lab.drawing.framing import View
from lift_lab.drawing.opengl import DrawError
from lift_lab.drawing.scene import Picture, SceneDrawer
from lift_lab.drawing.shapes import Placed
from lift_lab.utils.errors import PhysicsError

if TYPE_CHECKING:
    from .physics.base import Physics


@dataclass
class RenderView(View):
    """Camera, size and environments of a frame."""

    env_ids: tuple[int, ...] = (0,)
    """Environments drawn in one frame."""
    origins: np.ndarray | None = None
    """Position of each of them in the frame in m, shape (len(env_ids), 3); None puts all at zero."""
    camera: str | None = None
    """A camera of the model, seen in the first of them; None for the view that the other fields give."""
    width: int = 640
    height: int = 480
    fine: bool = False
    """Smooth edges and sharp shadows, at about four times the cost."""
    markers: list[Placed] = field(default_factory=list)
    """Shapes drawn besides, in the frame's coordinates."""
    lines: list[tuple[str, str]] = field(default_factory=list)
    """Text over the picture: label and value of each line."""

    def frame_origins(self) -> np.ndarray:
        """:attr:`origins` with the default filled in."""
        return np.zeros((len(self.env_ids), 3)) if self.origins is None else np.asarray(self.origins)


class FrameRenderer:
    """Draws frames of one size. Bound to the thread that made it."""

    def __init__(self, physics: Physics, view: RenderView):
        """Open an off-screen context.

        Raises:
            PhysicsError: no OpenGL library could be opened, or there is no such camera.
        """
        self._physics = physics
        self._key = _key(view)
        try:
            self._drawer = SceneDrawer(
                physics.model, view.width, view.height, view.frame_origins(), view.camera, view.fine
            )
        except DrawError as error:
            raise PhysicsError(f"cannot draw: {error}") from error

    def fits(self, view: RenderView) -> bool:
        """Whether this renderer can draw ``view`` (same size, environments at the same places, same camera)."""
        return self._key == _key(view)

    def draw(self, view: RenderView) -> np.ndarray:
        """Draw one frame, shape (height, width, 3), uint8.

        Raises:
            PhysicsError: OpenGL cannot draw the scene.
        """
        rows = list(view.env_ids)
        state = {name: self._physics.field(name)[rows].cpu().numpy() for name in ("qpos", "mocap_pos", "mocap_quat")}
        try:
            return self._drawer.draw(Picture(**state, view=view, markers=view.markers, lines=view.lines))
        except DrawError as error:
            raise PhysicsError(f"cannot draw: {error}") from error

    def close(self) -> None:
        """Free the context."""
        self._drawer.close()


def _key(view: RenderView) -> tuple[object, ...]:
    return view.width, view.height, view.fine, view.camera, view.frame_origins().tobytes()
