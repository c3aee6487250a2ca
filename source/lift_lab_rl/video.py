"""Videos of environments as mp4 files, encoded by PyAV: no program has to be installed beside Python."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from lift_lab.utils.errors import LiftLabError


class VideoError(LiftLabError, RuntimeError):
    """No video can be made."""


def require_video() -> None:
    """Check that videos can be encoded, before a long run finds out that they cannot.

    Raises:
        VideoError: PyAV is not installed.
    """
    if importlib.util.find_spec("av") is None:
        raise VideoError("videos need PyAV: pip install 'lift-lab[video]'")


class VideoWriter:
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
        import av

        self.path = Path(path)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._temporary = self.path.with_name(f".{self.path.stem}.{os.getpid()}.tmp.mp4")
        self._av = av
        self._fps = max(1, round(fps))
        self._container: Any = av.open(str(self._temporary), mode="w")
        self._stream: Any = None
        self.frames = 0

    def add(self, frame: np.ndarray) -> None:
        """Append a frame, shape (height, width, 3), uint8. All frames have one size, with even sides."""
        if self._stream is None:
            self._stream = self._container.add_stream("libx264", rate=self._fps)
            self._stream.height, self._stream.width = frame.shape[:2]
            self._stream.pix_fmt = "yuv420p"
            self._stream.options = {"crf": "21", "preset": "veryfast"}
        picture = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")
        for packet in self._stream.encode(picture):
            self._container.mux(packet)
        self.frames += 1

    def close(self) -> Path | None:
        """Finish the file; returns its path, or None if there was no frame."""
        if self._stream is not None:
            for packet in self._stream.encode():
                self._container.mux(packet)
        self._container.close()
        if not self.frames:
            self._temporary.unlink(missing_ok=True)
            return None
        os.replace(self._temporary, self.path)
        return self.path


class RecordVideo(gym.Wrapper):
    """Records the first ``length`` steps of every ``interval`` steps while an environment is used."""

    def __init__(self, env: gym.Env, folder: str | Path, interval: int, length: int, prefix: str = "step"):
        """Record nothing yet.

        Args:
            env: made with ``render_mode="rgb_array"``.
            folder: where files go.
            interval: steps between the starts of two videos.
            length: steps in a video.
            prefix: files are called ``{prefix}_{step}.mp4``.

        Raises:
            VideoError: PyAV is not installed, or the lengths are not positive.
        """
        require_video()
        if interval < 1 or length < 1:
            raise VideoError(f"video length and interval must be positive, got {length} and {interval}")
        super().__init__(env)
        self._folder, self._interval, self._length, self._prefix = Path(folder), interval, length, prefix
        self._step = 0
        self._writer: VideoWriter | None = None
        self.files: list[Path] = []

    def step(self, action: Any) -> Any:
        """Step, and draw if a video is running."""
        if self._writer is None and self._step % self._interval == 0:
            fps = self.env.unwrapped.metadata.get("render_fps", 50)
            self._writer = VideoWriter(self._folder / f"{self._prefix}_{self._step}.mp4", fps)
        result = self.env.step(action)
        self._step += 1
        if self._writer is not None:
            frame: Any = self.env.render()
            self._writer.add(frame)
            if self._writer.frames >= self._length:
                self._finish()
        return result

    def close(self) -> None:
        """Finish a running video and close the environment."""
        self._finish()
        super().close()

    def _finish(self) -> None:
        if self._writer is not None:
            path = self._writer.close()
            if path is not None:
                self.files.append(path)
            self._writer = None
