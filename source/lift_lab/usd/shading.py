"""Shading networks: colour, opacity and texture of a material, and texture files as the PNG that MuJoCo reads."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

from PIL import Image
from pxr import Ar, Gf, Sdf, UsdShade

_GREY = (0.18, 0.18, 0.18)
"""Diffuse colour of a UsdPreviewSurface that authors none."""
_MDL_GREY = (0.2, 0.2, 0.2)
"""Diffuse colour of an OmniPBR that authors none."""
_LARGEST = 8192
"""Most pixels along a side of a texture."""


@dataclass
class Look:
    """Look of a material; colours are linear."""

    color: Any = None
    alpha: float = 1.0
    texture: Sdf.AssetPath | None = None
    where: str = ""
    """Shader prim that names the texture."""
    attribute: str = ""
    tint: Any = None
    """Factor on the texture's colour, None for one."""


def look_of(material: UsdShade.Material) -> Look | None:
    """Read a UsdPreviewSurface, or an MDL shader with OmniPBR's inputs; None for any other network."""
    source = material.ComputeSurfaceSource()[0]
    if source and source.GetIdAttr().Get() == "UsdPreviewSurface":
        return _preview(source)
    source = material.ComputeSurfaceSource("mdl")[0]
    return _mdl(source) if source and source.GetSourceAsset("mdl") else None


def _constant(shader: UsdShade.Shader, name: str) -> Any:
    """Value of an input that no other node drives, followed through the material's interface."""
    found = shader.GetInput(name)
    if not found:
        return None
    for attribute in found.GetValueProducingAttributes():
        return attribute.Get() if not UsdShade.Output.IsOutput(attribute) else None
    return None


def _preview(shader: UsdShade.Shader) -> Look:
    opacity = _constant(shader, "opacity")
    look = Look(_GREY, float(opacity) if isinstance(opacity, float) else 1.0)
    diffuse = shader.GetInput("diffuseColor")
    for attribute in diffuse.GetValueProducingAttributes() if diffuse else ():
        node = UsdShade.Shader(attribute.GetPrim())
        if node and node.GetIdAttr().Get() == "UsdUVTexture":
            look.color = _constant(node, "fallback")
            look.texture = _constant(node, "file") or Sdf.AssetPath()
            look.where, look.attribute = str(node.GetPath()), "inputs:file"
            look.tint = _constant(node, "scale")
        else:
            look.color = attribute.Get()
        break
    return look


def _mdl(shader: UsdShade.Shader) -> Look:
    color, tint = _constant(shader, "diffuse_color_constant"), _constant(shader, "diffuse_tint")
    color = Gf.Vec3f(*_MDL_GREY) if color is None else Gf.Vec3f(color)
    if tint is not None:
        color = Gf.CompMult(color, Gf.Vec3f(tint))
    opacity = _constant(shader, "opacity_constant") if _constant(shader, "enable_opacity") else None
    look = Look(color, float(opacity) if isinstance(opacity, float) else 1.0)
    texture = _constant(shader, "diffuse_texture")
    if texture and texture.path:
        look.texture, look.where, look.attribute = texture, str(shader.GetPath()), "inputs:diffuse_texture"
        look.tint = tint
    return look


def read_png(path: str) -> bytes:
    """Content of a texture file, inside a .usdz too, as PNG.

    Raises:
        ValueError: It cannot be read, or it is no picture that Pillow knows; the message says which.
    """
    asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(path))
    if asset is None:
        raise ValueError("the texture file cannot be opened")
    content = bytes(asset.GetBuffer())
    try:
        with Image.open(io.BytesIO(content)) as image:
            if max(image.size) > _LARGEST:
                raise ValueError(f"a texture of {image.size[0]} x {image.size[1]} pixels; at most {_LARGEST}")
            if image.format == "PNG" and image.mode in ("L", "LA", "RGB", "RGBA", "P"):
                image.verify()
                return content
            plain = image.convert("RGBA" if image.has_transparency_data else "RGB")
    except (OSError, SyntaxError, Image.DecompressionBombError) as error:
        raise ValueError(f"not a picture that can be read ({' '.join(str(error).split())[:80]})") from None
    png = io.BytesIO()
    plain.save(png, "PNG", compress_level=1)
    return png.getvalue()
