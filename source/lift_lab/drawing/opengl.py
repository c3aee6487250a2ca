"""Off-screen OpenGL contexts. The library is chosen when the first frame is drawn, not when mujoco is imported."""

from __future__ import annotations

import importlib
import os
import sys
from typing import Any, Protocol

INSTALL = "on Debian or Ubuntu: apt-get install libegl1 libgl1-mesa-dri libopengl0"
"""Requirements of drawing."""
_OFF = ("disable", "disabled", "off", "false", "0")
_MODULES = {"egl": "mujoco.egl", "osmesa": "mujoco.osmesa", "cgl": "mujoco.cgl"}
"""Module by value of MUJOCO_GL."""
_WINDOWS = ("glfw", "glx", "wgl", "enable", "enabled", "on", "true", "1")
"""Values of MUJOCO_GL that stand for a hidden window."""


class DrawError(RuntimeError):
    """Nothing can be drawn."""


class Context(Protocol):
    """An OpenGL context."""

    def make_current(self) -> None:
        """Let this thread draw into it."""

    def free(self) -> None:
        """Free it."""


def mujoco_problem() -> str | None:
    """Return why mujoco cannot be imported with the library that ``MUJOCO_GL`` names, in one line; None if it can."""
    if "MUJOCO_GL" not in os.environ:
        return None
    try:
        import mujoco  # noqa: F401
    except (ImportError, AttributeError, OSError, RuntimeError) as error:
        problem = " ".join(str(error).split())
        setting = f"MUJOCO_GL={os.environ['MUJOCO_GL']}"
        return f"mujoco cannot be imported with {setting} ({problem}): unset MUJOCO_GL, or {INSTALL}"
    return None


def open_context(width: int, height: int) -> Context:
    """Open an off-screen context.

    The environment variable ``MUJOCO_GL`` chooses the library, as everywhere in MuJoCo. Where it is not set, Linux uses
    EGL, which needs no display, then GLFW if there is a display; macOS uses CGL, Windows GLFW.

    Args:
        width: of the frames in pixels.
        height: of the frames in pixels.

    Raises:
        DrawError: no library could be opened. The message is one line that says what to install or to set.
    """
    wanted = os.environ.get("MUJOCO_GL", "").lower().strip()
    if wanted in _OFF:
        raise DrawError(f"MUJOCO_GL={wanted} switches drawing off: unset it")
    if wanted and wanted not in (*_MODULES, *_WINDOWS):
        raise DrawError(f"MUJOCO_GL={wanted} is none of {', '.join((*_MODULES, _WINDOWS[0]))}: unset it, or choose one")
    problems = []
    for name in [wanted] if wanted else _candidates():
        try:
            return _open_egl_or_like(_MODULES[name], width, height) if name in _MODULES else _open_window(width, height)
        # PyOpenGL raises AttributeError where a library is missing
        except (ImportError, AttributeError, OSError, RuntimeError, TypeError) as error:
            problems.append(f"{name}: {' '.join(str(error).split())}")
    raise DrawError(_advice(wanted, "; ".join(problems)))


def _open_egl_or_like(module: str, width: int, height: int) -> Context:
    made: Any = importlib.import_module(module).GLContext(width, height)
    made.make_current()
    return made


def _open_window(width: int, height: int) -> Context:
    """A hidden window. GLFW only warns where it cannot open one."""
    if not has_display():
        raise RuntimeError("no display")
    import glfw
    import mujoco.glfw

    made: Any = mujoco.glfw.GLContext(width, height)
    made.make_current()
    if not glfw.get_current_context():
        raise RuntimeError("no window could be opened")
    return made


def _candidates() -> list[str]:
    if sys.platform == "darwin":
        return ["cgl", "glfw"]
    if not sys.platform.startswith("linux"):
        return ["glfw"]
    return ["egl", "glfw"] if has_display() else ["egl"]


def has_display() -> bool:
    """Whether a window could be opened."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _advice(wanted: str, problems: str) -> str:
    """What to do where nothing can be drawn."""
    if wanted not in ("", "egl", "osmesa") and not has_display():
        return f"MUJOCO_GL={wanted} needs a display, and there is none: unset it to draw without one ({problems})"
    if wanted == "osmesa":
        return f"OSMesa was not found: unset MUJOCO_GL; or on Debian or Ubuntu: apt-get install libosmesa6 ({problems})"
    if sys.platform.startswith("linux"):
        return f"no OpenGL library was found; {INSTALL} ({problems})"
    return f"no OpenGL context could be opened ({problems})"
