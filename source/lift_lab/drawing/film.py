"""Films as recorded states, and the process that draws them.

    python -m lift_lab.drawing.film FILM VIDEO.mp4 [--background]

draws a film, writes the video and deletes the film. The process that filmed needs no OpenGL for it, and waits for
nothing. With ``--background`` this process runs only while no other process needs the CPU.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .opengl import DrawError, mujoco_problem

if TYPE_CHECKING:
    from .scene import Picture
    from .shapes import Primitive

SUFFIX = ".film"
"""Ending of a film's file."""
_FAILED = 3
"""Exit status where a film could not be drawn, for a reason told in one line."""


@dataclass
class Film:
    """Pictures of one model, and how they are shown."""

    model: bytes
    """The compiled model, in MuJoCo's binary format."""
    width: int
    height: int
    fps: float
    origins: np.ndarray
    """Position of each environment in the frame in m, shape (n, 3)."""
    camera: str | None = None
    """A camera of the model; None for the pictures' own views."""
    fine: bool = False
    """Smooth edges and sharp shadows."""
    pictures: list[Picture] = field(default_factory=list)

    def save(self, path: Path) -> None:
        """Write the film as one file."""
        shapes: list[list[Primitive]] = []
        numbers: dict[int, int] = {}
        markers = []
        for k, picture in enumerate(self.pictures):
            for placed in picture.markers:
                if id(placed.shape) not in numbers:
                    numbers[id(placed.shape)] = len(shapes)
                    shapes.append(placed.shape)
                head = np.tile((float(k), float(numbers[id(placed.shape)])), (len(placed.positions), 1))
                markers.append(np.hstack((head, placed.positions, placed.quats, placed.scales)))
        header = {
            "size": (self.width, self.height),
            "fps": self.fps,
            "camera": self.camera,
            "fine": self.fine,
            "lines": [picture.lines for picture in self.pictures],
        }
        views = [(*p.view.lookat, p.view.distance, p.view.azimuth_deg, p.view.elevation_deg) for p in self.pictures]
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb") as file:
            np.savez(
                file,
                header=np.frombuffer(json.dumps(header).encode(), dtype=np.uint8),
                model=np.frombuffer(self.model, dtype=np.uint8),
                origins=np.asarray(self.origins, dtype=np.float32),
                qpos=np.stack([picture.qpos for picture in self.pictures]),
                mocap_pos=np.stack([picture.mocap_pos for picture in self.pictures]),
                mocap_quat=np.stack([picture.mocap_quat for picture in self.pictures]),
                views=np.asarray(views, dtype=np.float64),
                shapes=np.stack([part.row() for shape in shapes for part in shape]) if shapes else np.zeros((0, 20)),
                shape_sizes=np.asarray([len(shape) for shape in shapes], dtype=np.int64),
                markers=np.concatenate(markers) if markers else np.zeros((0, 12)),
            )

    @classmethod
    def load(cls, path: Path) -> Film:
        """Read a film's file."""
        from .framing import View
        from .scene import Picture
        from .shapes import Placed, from_row

        with np.load(path) as file:
            content = {name: file[name] for name in file.files}
        header = json.loads(content["header"].tobytes())
        ends = np.cumsum(content["shape_sizes"])
        rows = np.split(content["shapes"], ends[:-1]) if len(ends) else []
        shapes = [[from_row(row) for row in part] for part in rows]
        markers = content["markers"]
        pictures = []
        for k, view in enumerate(content["views"]):
            here = markers[markers[:, 0] == k]
            placed = [
                Placed(shape, rows[:, 2:5], rows[:, 5:9], rows[:, 9:12])
                for i, shape in enumerate(shapes)
                if len(rows := here[here[:, 1] == i])
            ]
            pictures.append(
                Picture(
                    content["qpos"][k],
                    content["mocap_pos"][k],
                    content["mocap_quat"][k],
                    View((view[0], view[1], view[2]), view[3], view[4], view[5]),
                    placed,
                    [(label, value) for label, value in header["lines"][k]],
                )
            )
        width, height = header["size"]
        return cls(
            content["model"].tobytes(),
            width,
            height,
            header["fps"],
            content["origins"],
            header["camera"],
            header["fine"],
            pictures,
        )


def model_bytes(model: Any) -> bytes:
    """A compiled model in MuJoCo's binary format."""
    import mujoco

    buffer = np.empty(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def draw_film(film: Film, video: Path) -> None:
    """Draw a film in this process.

    Raises:
        DrawError: there is no OpenGL library, or no such camera.
    """
    import mujoco

    from .mp4 import Mp4Writer
    from .scene import SceneDrawer

    model = mujoco.MjModel.from_binary_path("film.mjb", {"film.mjb": film.model})
    drawer = SceneDrawer(model, film.width, film.height, film.origins, film.camera, film.fine)
    writer = Mp4Writer(video, film.fps)
    for picture in film.pictures:
        writer.add(drawer.draw(picture))
    writer.close()
    drawer.close()


def start(film: Path, video: Path, background: bool) -> subprocess.Popen[bytes]:
    """Draw a film's file in a process of its own, which outlives this one if it has to.

    It is in a session of its own, so that Ctrl-C on the terminal leaves it alone. Its last line of standard error says
    what went wrong.
    """
    command = [sys.executable, "-m", __name__, str(film), str(video)]
    settings: dict[str, str] = {}
    if background:
        command.append("--background")
        settings |= {"LP_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}  # llvmpipe's threads
    return subprocess.Popen(
        command,
        env=settings | os.environ,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


def main() -> int:
    """Draw the film that the command line names."""
    parser = argparse.ArgumentParser()
    parser.add_argument("film", type=Path)
    parser.add_argument("video", type=Path)
    parser.add_argument("--background", action="store_true")
    args = parser.parse_args()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if args.background:
        os.nice(19)
    problem = mujoco_problem()
    if problem is not None:
        print(problem, file=sys.stderr)
        return _FAILED
    try:
        draw_film(Film.load(args.film), args.video)
    except (DrawError, OSError) as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        return _FAILED
    finally:
        args.film.unlink(missing_ok=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
