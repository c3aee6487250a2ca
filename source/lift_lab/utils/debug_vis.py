"""Showing and hiding markers: what command and action terms and sensors have in common."""

from __future__ import annotations

from typing import Any, ClassVar


class DebugVis:
    """Something with markers that a viewer may show; its ``cfg.debug_vis`` says whether it does at first.

    Sub-classes override :meth:`_set_debug_vis_impl` and :meth:`_debug_vis_callback`. Markers are made when a
    viewer asks for the first frame, so that training without one never makes them.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_debug_vis"})

    cfg: Any
    _debug_vis: bool | None = None

    @property
    def has_debug_vis_implementation(self) -> bool:
        """Whether the sub-class draws anything."""
        return type(self)._set_debug_vis_impl is not DebugVis._set_debug_vis_impl

    def set_debug_vis(self, debug_vis: bool) -> bool:
        """Show or hide the markers; returns whether there are any."""
        if not self.has_debug_vis_implementation:
            self._debug_vis = False
            return False
        self._set_debug_vis_impl(debug_vis)
        self._debug_vis = debug_vis
        return True

    def update_debug_vis(self) -> None:
        """Move the markers to the current state, making them first if the config asks for them.

        A viewer calls this once for each frame.
        """
        if self._debug_vis is None:
            self.set_debug_vis(self.cfg.debug_vis)
        if self._debug_vis:
            self._debug_vis_callback(None)

    def _set_debug_vis_impl(self, debug_vis: bool) -> None:
        """Make the markers if needed and set their visibility."""
        raise NotImplementedError(f"{type(self).__name__} draws no markers")

    def _debug_vis_callback(self, event: Any) -> None:
        """Write the current state into the markers; ``event`` is always None."""
        raise NotImplementedError(f"{type(self).__name__} draws no markers")
