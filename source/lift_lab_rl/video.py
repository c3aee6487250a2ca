"""Videos of environments as mp4 files.

An environment is filmed as states and markers, which costs next to nothing; a process of its own draws them (see
:mod:`lift_lab.drawing.film`). So the process that records needs no OpenGL, does not wait for pictures, and survives
errors of a video.
"""

from __future__ import annotations

import base64
import importlib.util
import signal
import subprocess
import tempfile
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium as gym
import torch

from lift_lab.drawing import film
from lift_lab.drawing.mp4 import Mp4Writer
from lift_lab.envs.frame_capture import Frame, FrameCapture
from lift_lab.utils.errors import LiftLabError

_INLINE_FPS = 30
"""Most frames per second of a video in a notebook."""


class VideoError(LiftLabError, RuntimeError):
    """No video can be made."""


def require_video() -> None:
    """Check that videos can be encoded, before a long run finds out that they cannot.

    Raises:
        VideoError: PyAV is not installed.
    """
    if importlib.util.find_spec("av") is None:
        raise VideoError("videos need PyAV: pip install 'lift-lab[video]'")


class VideoWriter(Mp4Writer):
    """Writes frames to an mp4 file. The file appears when it is closed."""

    def __init__(self, path: str | Path, fps: float):
        """Start a video.

        Args:
            path: the file, ending in ``.mp4``.
            fps: frames a second.

        Raises:
            VideoError: PyAV is not installed.
        """
        require_video()
        super().__init__(path, fps)


class RecordVideo(gym.Wrapper):
    """Films the first ``length`` steps of every ``interval`` steps while an environment is used.

    ``env.cfg.viewer`` sets the camera. Films are drawn one after the other. If one cannot be drawn, that is said in
    one line, and nothing is filmed from then on.
    """

    def __init__(
        self,
        env: gym.Env,
        path: Callable[[int], Path],
        interval: int,
        length: int,
        background: bool = True,
        say: Callable[[str], None] = print,
    ):
        """Film nothing yet.

        Args:
            env: a manager-based environment.
            path: the file of the video that starts at a step.
            interval: steps between the starts of two videos.
            length: steps in a video.
            background: whether drawing takes only the processor time that nobody else wants.
            say: shows a line to the user.

        Raises:
            VideoError: PyAV is not installed, or the lengths are not positive.
            ConfigError: the viewer names an environment, asset or body that does not exist.
        """
        require_video()
        if interval < 1 or length < 1:
            raise VideoError(f"video length and interval must be positive, got {length} and {interval}")
        super().__init__(env)
        self._path, self._interval, self._length = path, interval, length
        self._background, self._say = background, say
        self._capture = FrameCapture(env.unwrapped)  # type: ignore[arg-type]
        self._step = self._start = 0
        self._frames: list[Frame] | None = None
        self._waiting: deque[tuple[Path, Path]] = deque()
        self._drawing: tuple[subprocess.Popen[bytes], Path, Path] | None = None
        self.problem: str | None = None
        """Why nothing is filmed any more."""
        self.files: list[Path] = []
        """Videos that are complete."""

    def step(self, action: Any) -> Any:
        """Step, and take a frame while a video is running."""
        if self._frames is None and self._step % self._interval == 0 and self.problem is None:
            self._frames, self._start = [], self._step
        result = self.env.step(action)
        self._step += 1
        if self._frames is not None:
            self._frames.append(self._capture.frame())
            if len(self._frames) >= self._length:
                self._end_film()
        if self._drawing is not None and self._drawing[0].poll() is not None:
            self._end_drawing()
        return result

    def close(self) -> None:
        """Finish every video and close the environment. After Ctrl-C the drawing continues by itself."""
        self._end_film()
        if self._drawing is not None:
            videos = [self._drawing[2], *(video for _, video in self._waiting)]
            self._say(f"drawing {', '.join(str(video) for video in videos)} (Ctrl-C does not wait for it)")
        try:
            while self._drawing is not None:
                self._drawing[0].wait()
                self._end_drawing()
        except KeyboardInterrupt:
            self._say("not waiting: the drawing goes on by itself")
            for source, video in self._waiting:
                film.start(source, video, self._background)
            self._drawing = None
            self._waiting.clear()
        super().close()

    def _end_film(self) -> None:
        """Hand a running film over to be drawn."""
        frames, self._frames = self._frames, None
        if not frames or self.problem is not None:
            return
        video = self._path(self._start)
        source = video.with_name(f".{video.stem}{film.SUFFIX}")
        try:
            fps = self.env.unwrapped.metadata.get("render_fps", 50)
            self._capture.film(frames, fps).save(source)
            self._waiting.append((source, video))
            self._begin_drawing()
        except OSError as error:
            self._give_up(f"'{video}' cannot be drawn: {error}")

    def _begin_drawing(self) -> None:
        if self._drawing is None and self._waiting:
            source, video = self._waiting.popleft()
            self._drawing = film.start(source, video, self._background), source, video

    def _end_drawing(self) -> None:
        """Look how a process that has ended did."""
        assert self._drawing is not None
        process, source, video = self._drawing
        self._drawing = None
        _, errors = process.communicate()
        if process.returncode == 0:
            self.files.append(video)
            self._begin_drawing()
            return
        source.unlink(missing_ok=True)
        self._give_up(f"'{video}' could not be drawn: {_reason(process.returncode, errors)}")

    def _give_up(self, problem: str) -> None:
        self.problem = problem
        for source, _ in self._waiting:
            source.unlink(missing_ok=True)
        self._waiting.clear()
        self._say(f"warning: {problem}; no more videos")


@dataclass(frozen=True)
class InlineVideo:
    """A video that a notebook shows where it is the last value of a cell."""

    data: bytes
    """Content of an mp4 file."""

    def save(self, path: str | Path) -> Path:
        """Write the mp4 file. Returns its path."""
        path = Path(path)
        path.write_bytes(self.data)
        return path

    def _repr_html_(self) -> str:
        source = base64.b64encode(self.data).decode()
        return f'<video controls autoplay loop muted playsinline src="data:video/mp4;base64,{source}"></video>'

    def __repr__(self) -> str:
        return f"InlineVideo({len(self.data) / 1e3:.0f} kB)"


def show_video(
    env: Any,
    policy: Callable[[Any], torch.Tensor] | None = None,
    steps: int = 200,
    resolution: tuple[int, int] = (640, 360),
) -> InlineVideo:
    """Reset an environment, let a policy act, and film it: one line in a notebook.

    ``env.cfg.viewer`` sets the camera. The film has at most 30 frames a second of simulated time.

    Args:
        env: a manager-based environment, possibly inside wrappers of gymnasium's or rsl_rl's.
        policy: returns actions, shape (num_envs, num_actions), for the observations that ``env.step`` returns. A method
            ``reset(dones)`` is called after each step. None for zero actions.
        steps: environment steps.
        resolution: width and height in pixels.

    Raises:
        VideoError: PyAV is not installed, ``steps`` is not positive, or the film cannot be drawn.
        ConfigError: the viewer names an environment, asset or body that does not exist.
    """
    require_video()
    if steps < 1:
        raise VideoError(f"show_video: steps must be positive, got {steps}")
    inner = env.unwrapped
    capture, fps = FrameCapture(inner, resolution), inner.metadata["render_fps"]
    every = max(1, round(fps / _INLINE_FPS))
    zeros = torch.zeros(inner.num_envs, inner.action_manager.total_action_dim, device=inner.device)
    with torch.inference_mode():
        obs, _ = env.reset()
        frames = [capture.frame()]
        for step in range(1, steps + 1):
            obs, _, dones, *others = env.step(zeros.clone() if policy is None else policy(obs))
            if len(others) == 2:  # gymnasium's terminated and truncated, not rsl_rl's dones
                dones = dones | others[0]
            if hasattr(policy, "reset"):
                policy.reset(dones)  # type: ignore[union-attr]
            if step % every == 0:
                frames.append(capture.frame())
    with tempfile.TemporaryDirectory() as folder:
        source, video = Path(folder, f"a{film.SUFFIX}"), Path(folder, "a.mp4")
        capture.film(frames, fps / every).save(source)
        process = film.start(source, video, background=False)
        try:
            _, errors = process.communicate()
        except BaseException:  # Ctrl-C, or the notebook's stop button
            process.kill()
            process.wait()
            raise
        if process.returncode != 0:
            raise VideoError(f"the video cannot be drawn: {_reason(process.returncode, errors)}")
        return InlineVideo(video.read_bytes())


def _reason(status: int, errors: bytes) -> str:
    """Why a process that draws has failed, in one line."""
    if status < 0:
        return f"the drawing process was ended by {signal.Signals(-status).name}"
    lines = errors.decode(errors="replace").strip().splitlines()
    # of a traceback the line that names the error
    found = next((line for line in reversed(lines) if not line.startswith((" ", "\t", ">"))), None)
    return found or f"the drawing process ended with status {status}"
