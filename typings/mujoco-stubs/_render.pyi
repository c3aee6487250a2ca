# Made by scripts/maintainers/make_stubs.py from mujoco 4.0.0. Do not edit.
import collections.abc
import typing
from typing import Any, ClassVar

import numpy
import numpy.typing
from numpy.typing import NDArray
import mujoco._structs

from ._types import *

class MjrContext:
    @typing.overload
    def __init__(self) -> None: ...
    @typing.overload
    def __init__(self, arg0: mujoco._structs.MjModel, arg1: Whole) -> None: ...
    auxColor: Field[NDArray[numpy.uint32], numpy.typing.ArrayLike]
    auxColor_r: Field[NDArray[numpy.uint32], numpy.typing.ArrayLike]
    auxFBO: Field[NDArray[numpy.uint32], numpy.typing.ArrayLike]
    auxFBO_r: Field[NDArray[numpy.uint32], numpy.typing.ArrayLike]
    auxHeight: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    auxSamples: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    auxWidth: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    baseBuiltin: Field[int, Real]
    baseFontBig: Field[int, Real]
    baseFontNormal: Field[int, Real]
    baseFontShadow: Field[int, Real]
    baseHField: Field[int, Real]
    baseMesh: Field[int, Real]
    basePlane: Field[int, Real]
    charHeight: Field[int, Real]
    charHeightBig: Field[int, Real]
    charWidth: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    charWidthBig: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    currentBuffer: Field[int, Real]
    fogEnd: Field[float, Real]
    fogRGBA: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    fogStart: Field[float, Real]
    fontScale: Field[int, Real]
    def free(self) -> None: ...
    glInitialized: Field[int, Real]
    lineWidth: Field[float, Real]
    mat_texid: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    mat_texrepeat: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    mat_texuniform: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    nskin: Fixed[int]
    ntexture: Field[int, Real]
    offColor: Field[int, Real]
    offColor_r: Field[int, Real]
    offDepthStencil: Field[int, Real]
    offDepthStencil_r: Field[int, Real]
    offFBO: Field[int, Real]
    offFBO_r: Field[int, Real]
    offHeight: Field[int, Real]
    offSamples: Field[int, Real]
    offWidth: Field[int, Real]
    rangeBuiltin: Field[int, Real]
    rangeFont: Field[int, Real]
    rangeHField: Field[int, Real]
    rangeMesh: Field[int, Real]
    rangePlane: Field[int, Real]
    readDepthMap: Field[int, Real]
    readPixelFormat: Field[int, Real]
    shadowClip: Field[float, Real]
    shadowFBO: Field[int, Real]
    shadowScale: Field[float, Real]
    shadowSize: Field[int, Real]
    shadowTex: Field[int, Real]
    skinfaceVBO: Fixed[tuple]
    skinnormalVBO: Fixed[tuple]
    skintexcoordVBO: Fixed[tuple]
    skinvertVBO: Fixed[tuple]
    texture: Field[NDArray[numpy.uint32], numpy.typing.ArrayLike]
    textureType: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    windowAvailable: Field[int, Real]
    windowDoublebuffer: Field[int, Real]
    windowSamples: Field[int, Real]
    windowStereo: Field[int, Real]

def mjr_drawPixels(rgb: NDArray[numpy.uint8] | None, depth: NDArray[numpy.float32] | None, viewport: mujoco._structs.MjrRect, con: MjrContext) -> None: ...
def mjr_overlay(font: Whole, gridpos: Whole, viewport: mujoco._structs.MjrRect, overlay: str, overlay2: str, con: MjrContext) -> None: ...
def mjr_readPixels(rgb: numpy.typing.ArrayLike | None, depth: numpy.typing.ArrayLike | None, viewport: mujoco._structs.MjrRect, con: MjrContext) -> None: ...
def mjr_render(viewport: mujoco._structs.MjrRect, scn: mujoco._structs.MjvScene, con: MjrContext) -> None: ...
def mjr_setBuffer(framebuffer: Whole, con: MjrContext) -> None: ...
