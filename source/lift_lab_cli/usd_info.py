"""Import a USD file and report the result.

lift-lab usd FILE [--view PNG] [--mjcf XML] [--variant SET=NAME ...] [--strict]
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from lift_lab.app import cli

if TYPE_CHECKING:
    import mujoco
    import numpy as np


def main() -> int:
    parser = cli.Parser(__doc__, overrides=False)
    parser.add_argument("file", type=Path, help="a .usd, .usda, .usdc or .usdz file")
    parser.add_argument("--view", type=Path, default=None, metavar="PNG", help="write a picture of the initial state")
    parser.add_argument("--mjcf", type=Path, default=None, metavar="XML", help="write the model as MJCF")
    parser.add_argument("--variant", action="append", default=[], metavar="SET=NAME", help="choose a variant")
    parser.add_argument("--strict", action="store_true", help="fail if physics would be ignored")
    args, _ = parser.parse()

    from rich.console import Console

    from lift_lab.usd import add_initial_key, load
    from lift_lab.utils.errors import ConfigError

    wrong = [text for text in args.variant if "=" not in text]
    if wrong:
        raise ConfigError(f"--variant {wrong[0]}: write SET=NAME")
    variants = dict(text.split("=", 1) for text in args.variant)
    spec, report = load(args.file, variants=variants, strict=args.strict)
    console = Console()
    # A table that is piped into another program is not cut to the width of a terminal.
    console.print(report.table()) if console.is_terminal else Console(width=200).print(report.table())
    add_initial_key(spec, report)
    model = spec.compile()
    size = f"{model.nbody - 1} bodies, {model.nv} degrees of freedom, {model.nu} actuators, {model.ngeom} geoms"
    console.print(f"model: {size}, {model.body_mass.sum():.4g} kg")
    picture = draw(model) if args.view else None
    if args.mjcf:
        args.mjcf.parent.mkdir(parents=True, exist_ok=True)
        args.mjcf.write_text(spec.to_xml())
        for name, content in spec.assets.items():
            (args.mjcf.parent / name).write_bytes(content)
    if picture is not None:
        from PIL import Image

        args.view.parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(picture).save(args.view, format="PNG")
    return 0


def draw(model: mujoco.MjModel, width: int = 960, height: int = 720) -> np.ndarray:
    """The key ``initial`` with the whole model in view, shape (height, width, 3), uint8.

    Raises:
        PhysicsError: there is no OpenGL library to draw with.
    """
    import mujoco
    import numpy as np

    from lift_lab.drawing.framing import corners, drawn_geoms, fit
    from lift_lab.drawing.opengl import DrawError
    from lift_lab.drawing.scene import Picture, SceneDrawer
    from lift_lab.utils.errors import PhysicsError

    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("initial").id)
    mujoco.mj_forward(model, data)
    points = corners(model, data, drawn_geoms(model))
    view = fit(points if len(points) else np.zeros((1, 3)), width / height, fill=0.8)
    picture = Picture(data.qpos[None], data.mocap_pos[None], data.mocap_quat[None], view)
    try:
        drawer = SceneDrawer(model, width, height, np.zeros((1, 3)), fine=True)
        frame = drawer.draw(picture)
    except DrawError as error:
        raise PhysicsError(f"--view: {error}") from error
    drawer.close()
    return frame


if __name__ == "__main__":
    cli.run(main)
