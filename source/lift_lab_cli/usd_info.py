"""Import a USD file and say what became of it.

lift-lab usd FILE [--view PNG] [--mjcf XML] [--variant SET=NAME ...] [--strict]
"""

from __future__ import annotations

import os
import struct
import zlib
from pathlib import Path

from lift_lab.app import cli


def main() -> int:
    parser = cli.Parser(__doc__, overrides=False)
    parser.add_argument("file", type=Path, help="a .usd, .usda, .usdc or .usdz file")
    parser.add_argument("--view", type=Path, default=None, metavar="PNG", help="write a picture of the initial state")
    parser.add_argument("--mjcf", type=Path, default=None, metavar="XML", help="write the model as MJCF")
    parser.add_argument("--variant", action="append", default=[], metavar="SET=NAME", help="choose a variant")
    parser.add_argument("--strict", action="store_true", help="fail on physics that would be ignored")
    args, _ = parser.parse()
    if args.view:
        os.environ.setdefault("MUJOCO_GL", "egl")  # read when mujoco is imported

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
    if args.mjcf:
        args.mjcf.parent.mkdir(parents=True, exist_ok=True)
        args.mjcf.write_text(spec.to_xml())
        for name, content in spec.assets.items():
            (args.mjcf.parent / name).write_bytes(content)
    if args.view:
        args.view.parent.mkdir(parents=True, exist_ok=True)
        args.view.write_bytes(_png(_picture(spec)))
    return 0


def _picture(spec, width: int = 960, height: int = 720):
    """RGB image of the key `initial`, the whole model in view."""
    import mujoco

    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
    spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.35] * 3, [0.55] * 3
    sky = spec.add_texture(name="usd_info_sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, width=64, height=64)
    sky.builtin, sky.rgb1, sky.rgb2 = mujoco.mjtBuiltin.mjBUILTIN_GRADIENT, [0.75, 0.8, 0.85], [0.95, 0.96, 0.97]
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("initial").id)
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, camera)
    camera.azimuth, camera.elevation, camera.distance = 140.0, -20.0, 1.2 * model.stat.extent
    with mujoco.Renderer(model, height, width) as renderer:
        renderer.update_scene(data, camera)
        return renderer.render()


def _png(image) -> bytes:
    """An RGB image of shape (height, width, 3), uint8, as PNG."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    height, width, _ = image.shape
    rows = b"".join(b"\0" + row.tobytes() for row in image)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 6)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


if __name__ == "__main__":
    cli.run(main)
