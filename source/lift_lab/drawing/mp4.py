"""mp4 files, encoded by PyAV: no program has to be installed beside Python."""

from __future__ import annotations

import os
import re
import socket
from pathlib import Path
from typing import Any

import numpy as np


class Mp4Writer:
    """Writes frames to an mp4 file. The file appears when it is closed."""

    def __init__(self, path: str | Path, fps: float, crf: int = 21):
        """Start a video.

        Args:
            path: the file, ending in ``.mp4``.
            fps: frames a second.
            crf: H.264's constant rate factor: smaller is better and larger.
        """
        import av

        self.path = Path(path)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        # Named as by lift_lab.utils.io.temporary_path, which would bring torch along.
        host = re.sub(r"\W", "-", socket.gethostname().partition(".")[0])[:32]
        self._temporary = self.path.with_name(f".{self.path.stem}.{host}-{os.getpid()}.tmp.mp4")
        self._av = av
        self._fps, self._crf = max(1, round(fps)), crf
        self._container: Any = av.open(str(self._temporary), mode="w")
        self._stream: Any = None
        self.frames = 0

    def add(self, frame: np.ndarray) -> None:
        """Append a frame, shape (height, width, 3), uint8. All frames have one size; an odd side loses a pixel."""
        if self._stream is None:
            self._stream = self._container.add_stream("libx264", rate=self._fps)
            height, width = frame.shape[:2]
            self._stream.height, self._stream.width = height - height % 2, width - width % 2
            self._stream.pix_fmt = "yuv420p"
            self._stream.options = {"crf": str(self._crf), "preset": "veryfast"}
        even = frame[: self._stream.height, : self._stream.width]
        picture = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(even), format="rgb24")
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
