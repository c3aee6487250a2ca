"""Pictures: visual geoms, colours, textures, subsets, cameras, lights and sites."""

from __future__ import annotations

import math
import struct
import zlib

import mujoco
import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade
from scipy.spatial.transform import Rotation

BOX_POINTS = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
BOX_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def _srgb(linear):
    return [12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055 for c in linear]


def _preview(a, path, color=None, opacity=None):
    material = UsdShade.Material.Define(a.stage, path)
    shader = UsdShade.Shader.Define(a.stage, f"{path}/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    if color:
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*color))
    if opacity is not None:
        shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(opacity)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material, shader


def test_visual_geoms_do_not_collide_weigh_nothing_and_are_in_group_two(author):
    a = author()
    a.body("/Robot/b")
    a.gprim("/Robot/b/v", "Cube", collider=False, pos=(0, 0, 1), size=0.4)
    a.mesh("/Robot/b/m", BOX_POINTS, BOX_FACES, collider=False)
    model, _ = a.load()
    for name in ("v", "m"):
        geom = model.geom(name)
        assert (geom.contype[0], geom.conaffinity[0], geom.group[0]) == (0, 0, 2)
    np.testing.assert_allclose(model.geom("v").size, 0.2)
    np.testing.assert_allclose(model.geom("v").pos, (0, 0, 1))
    assert model.body("b").mass[0] == pytest.approx(1.0)


@pytest.mark.parametrize(("purpose", "drawn"), [("default", 1), ("render", 1), ("proxy", 0), ("guide", 0)])
def test_only_prims_of_purpose_default_or_render_are_drawn(author, purpose, drawn):
    a = author()
    a.body("/Robot/b")
    prim = a.gprim("/Robot/b/v", "Cube", collider=False, size=0.4)
    UsdGeom.Imageable(prim).CreatePurposeAttr(purpose)
    assert a.load()[0].ngeom == drawn


def test_invisible_prims_are_not_drawn(author):
    a = author()
    a.body("/Robot/b")
    a.gprim("/Robot/b/v", "Cube", collider=False, size=0.4)
    UsdGeom.Imageable(a.stage.GetPrimAtPath("/Robot/b")).MakeInvisible()
    assert a.load()[0].ngeom == 0


def test_display_colour_is_linear_and_inherited(author):
    a = author()
    body = a.body("/Robot/b")
    a.gprim("/Robot/b/v", "Cube", collider=False, size=0.4)
    primvars = UsdGeom.PrimvarsAPI(body)
    color = primvars.CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray, "constant")
    color.Set([Gf.Vec3f(0.002, 0.2, 0.8)])
    primvars.CreatePrimvar("displayOpacity", Sdf.ValueTypeNames.FloatArray, "constant").Set([0.25])
    np.testing.assert_allclose(a.load()[0].geom("v").rgba, [*_srgb((0.002, 0.2, 0.8)), 0.25], atol=1e-6)


def test_a_bound_preview_surface_beats_display_colour(author):
    a = author()
    prim = a.gprim("/Robot/v", "Cube", collider=False, size=0.4)
    UsdGeom.Gprim(prim).CreateDisplayColorAttr([Gf.Vec3f(1, 0, 0)])
    material, _ = _preview(a, "/Robot/look", (0.0, 0.5, 1.0), 0.5)
    UsdShade.MaterialBindingAPI.Apply(a.stage.GetPrimAtPath("/Robot")).Bind(material)
    np.testing.assert_allclose(a.load()[0].geom("v").rgba, [*_srgb((0, 0.5, 1)), 0.5], atol=1e-6)


def test_material_subsets_split_a_mesh_and_the_rest_keeps_the_meshs_colour(author):
    a = author()
    prim = a.mesh("/Robot/m", BOX_POINTS, BOX_FACES, collider=False)
    UsdGeom.Gprim(prim).CreateDisplayColorAttr([Gf.Vec3f(1, 1, 1)])
    for name, faces, color in (("red", [0, 1], (1, 0, 0)), ("blue", [2], (0, 0, 1))):
        subset = UsdGeom.Subset.CreateGeomSubset(UsdGeom.Imageable(prim), name, "face", faces, "materialBind")
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(_preview(a, f"/Robot/{name}_look", color)[0])
    model, _ = a.load()
    colors = {model.geom(i).name: model.geom(i).rgba[:3].tolist() for i in range(model.ngeom)}
    assert colors == {"red": [1, 0, 0], "blue": [0, 0, 1], "m": [1, 1, 1]}
    triangles = {model.geom(i).name: int(model.mesh_facenum[model.geom(i).dataid[0]]) for i in range(model.ngeom)}
    assert triangles == {"red": 4, "blue": 2, "m": 6}


def test_flat_and_tiny_visual_meshes_compile(author):
    a = author()
    a.mesh("/Robot/quad", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)], collider=False)
    a.mesh("/Robot/tri", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], collider=False)
    assert a.load()[0].nmesh == 2


def _png(path, rgb):
    """A 2 x 2 PNG of one colour, written by hand."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + bytes(rgb) * 2 for _ in range(2))
    header = struct.pack(">IIBBBBB", 2, 2, 8, 2, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    )


def test_a_png_texture_becomes_a_material(author, tmp_path):
    a = author()
    _png(tmp_path / "wood.png", (200, 100, 50))
    prim = a.mesh("/Robot/m", BOX_POINTS, BOX_FACES, collider=False)
    st = UsdGeom.PrimvarsAPI(prim).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
    st.Set([Gf.Vec2f(x, y) for x, y, _ in BOX_POINTS])
    material, shader = _preview(a, "/Robot/look")
    texture = UsdShade.Shader.Define(a.stage, "/Robot/look/wood")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(str(tmp_path / "wood.png")))
    texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(texture.ConnectableAPI(), "rgb")
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    model, _ = a.load()
    assert (model.nmat, model.ntex) == (1, 1)
    assert model.geom("m").matid[0] == 0
    assert model.tex_data[:3].tolist() == [200, 100, 50]
    # USD's v axis points up, MuJoCo's down
    coords = model.mesh_texcoord.reshape(-1, 2)
    expected = {(x, 1 - y) for x, y, _ in BOX_POINTS}
    assert {tuple(c) for c in coords.tolist()} == expected


def test_a_texture_that_cannot_be_shown_is_reported_and_falls_back_to_its_colour(author, notes):
    a = author()
    prim = a.mesh("/Robot/m", BOX_POINTS, BOX_FACES, collider=False)
    material, shader = _preview(a, "/Robot/look")
    texture = UsdShade.Shader.Define(a.stage, "/Robot/look/wood")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath("missing.png"))
    texture.CreateInput("fallback", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(0, 1, 0, 1))
    texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(texture.ConnectableAPI(), "rgb")
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    model, report = a.load()
    assert notes(report, "/Robot/look/wood")[0] == ["the texture file does not resolve"]
    np.testing.assert_allclose(model.geom("m").rgba, (0, 1, 0, 1))


@pytest.mark.parametrize("up", ["Y", "Z"])
def test_a_camera_keeps_its_view_and_its_vertical_field(author, up):
    a = author(up, 0.01)
    a.body("/Robot/b", pos=(0, 0, 100))
    rot = Rotation.from_euler("xyz", (10, 20, 30), degrees=True)
    camera = UsdGeom.Camera.Define(a.stage, "/Robot/b/eye")
    a.place(camera.GetPrim(), (1, 2, 3), np.roll(rot.as_quat(), 1))
    camera.CreateFocalLengthAttr(24.0)
    camera.CreateVerticalApertureAttr(18.0)
    model, _ = a.load()
    np.testing.assert_allclose(model.cam("eye").pos, (0.01, 0.02, 0.03), atol=1e-9)
    found = Rotation.from_quat(np.roll(model.cam("eye").quat, -1))
    np.testing.assert_allclose(found.as_matrix(), rot.as_matrix(), atol=1e-6)
    assert model.cam("eye").fovy[0] == pytest.approx(math.degrees(2 * math.atan(9 / 24)))
    assert model.cam("eye").bodyid[0] == model.body("b").id


def test_lights_shine_along_their_minus_z_and_static_ones_belong_to_the_world(author, notes):
    a = author()
    sun = UsdLux.DistantLight.Define(a.stage, "/sun")
    a.place(sun.GetPrim(), quat=(math.sqrt(0.5), 0, math.sqrt(0.5), 0))
    sun.CreateColorAttr(Gf.Vec3f(1, 0, 0))
    UsdLux.SphereLight.Define(a.stage, "/Robot/bulb")
    UsdLux.DomeLight.Define(a.stage, "/sky")
    a.gprim("/Robot/c", "Cube", size=0.1)
    model, report = a.load()
    assert model.nlight == 2
    names = {model.light(i).name: i for i in range(2)}
    np.testing.assert_allclose(model.light_dir[names["sun"]], (-1, 0, 0), atol=1e-7)
    assert model.light_type[names["sun"]] == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    assert model.light_diffuse[names["sun"]][1] == 0
    assert model.light_bodyid.tolist() == [0, 0]
    assert report.bodies == ["Robot"]
    assert "dome" in notes(report, "/sky")[0][0]


@pytest.mark.parametrize("schema", ["MjcSiteAPI", "NewtonSiteAPI"])
def test_sites_keep_place_and_shape_and_are_no_geoms(author, schema):
    a = author("Z", 0.1)
    a.body("/Robot/b")
    a.set(a.gprim("/Robot/b/tip", "Sphere", collider=False, pos=(1, 2, 3), radius=0.5), schema)
    model, _ = a.load()
    assert (model.nsite, model.ngeom) == (1, 0)
    np.testing.assert_allclose(model.site("tip").pos, (0.1, 0.2, 0.3))
    assert model.site("tip").size[0] == pytest.approx(0.05)
    assert model.site("tip").bodyid[0] == model.body("b").id


def test_instances_are_drawn_through_their_prototypes(author):
    a = author()
    UsdGeom.Xform.Define(a.stage, "/Looks/wheel")
    a.mesh("/Looks/wheel/tyre", BOX_POINTS, BOX_FACES, collider=False)
    a.gprim("/Looks/wheel/hub", "Sphere", radius=0.1)
    UsdGeom.Imageable(a.stage.GetPrimAtPath("/Looks")).MakeInvisible()
    a.stage.GetPrimAtPath("/Looks").SetActive(True)
    for i in range(2):
        a.body(f"/Robot/w{i}", pos=(i, 0, 0))
        shell = UsdGeom.Xform.Define(a.stage, f"/Robot/w{i}/shape").GetPrim()
        shell.GetReferences().AddInternalReference("/Looks/wheel")
        shell.SetInstanceable(True)
    model, _ = a.load()
    for i in range(2):
        geoms = [g for g in range(model.ngeom) if model.geom_bodyid[g] == model.body(f"w{i}").id]
        assert len(geoms) == 2
    # the prototype itself lies outside any body: only its collider remains, and it shows nothing
    assert model.nmesh == 1


def _textured(a, prim, path):
    """Bind a preview surface whose colour is a texture file."""
    material, shader = _preview(a, "/Robot/look")
    texture = UsdShade.Shader.Define(a.stage, "/Robot/look/wood")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(str(path)))
    texture.CreateInput("fallback", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(0, 1, 0, 1))
    texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(texture.ConnectableAPI(), "rgb")
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)


def _uv_box(a, primvar="st"):
    prim = a.mesh("/Robot/m", BOX_POINTS, BOX_FACES, collider=False)
    st = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(primvar, Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
    st.Set([Gf.Vec2f(x, y) for x, y, _ in BOX_POINTS])
    return prim


@pytest.mark.parametrize(("suffix", "mode"), [("jpg", "RGB"), ("bmp", "RGB"), ("png", "I;16"), ("tga", "RGBA")])
def test_other_picture_formats_are_shown_too(author, tmp_path, suffix, mode):
    color = {"RGB": (200, 100, 50), "RGBA": (200, 100, 50, 255), "I;16": 65535}[mode]
    Image.new(mode, (4, 4), color).save(tmp_path / f"wood.{suffix}")
    a = author()
    _textured(a, _uv_box(a, "UVMap"), tmp_path / f"wood.{suffix}")
    model, _ = a.load(strict=True)
    assert (model.ntex, model.geom("m").matid[0]) == (1, 0)
    expected = (255, 255, 255) if mode == "I;16" else (200, 100, 50)
    np.testing.assert_allclose(model.tex_data[:3], expected, atol=3)
    assert model.mesh_texcoord.size


def test_a_picture_that_cannot_be_read_is_reported_and_the_model_still_compiles(author, tmp_path, notes):
    (tmp_path / "wood.png").write_bytes(b"\x89PNG\r\n\x1a\n garbage")
    a = author()
    _textured(a, _uv_box(a), tmp_path / "wood.png")
    model, report = a.load()
    assert "not a picture" in notes(report, "/Robot/look/wood")[0][0]
    np.testing.assert_allclose(model.geom("m").rgba, (0, 1, 0, 1))


def test_a_texture_on_a_shape_without_coordinates_is_reported(author, tmp_path, notes):
    _png(tmp_path / "wood.png", (200, 100, 50))
    a = author()
    _textured(a, a.gprim("/Robot/v", "Cube", collider=False, size=0.4), tmp_path / "wood.png")
    model, report = a.load()
    assert "without texture coordinates" in notes(report, "/Robot/v")[0][0]
    np.testing.assert_allclose(model.geom("v").rgba, (0, 1, 0, 1))


@pytest.mark.parametrize("textured", [False, True])
def test_an_omnipbr_material_gives_its_colour_or_texture(author, tmp_path, textured):
    """As Isaac Sim's assets author it: an MDL shader of which usd-core knows nothing."""
    _png(tmp_path / "wood.png", (200, 100, 50))
    a = author()
    prim = _uv_box(a)
    material = UsdShade.Material.Define(a.stage, "/Robot/Looks/steel")
    shader = UsdShade.Shader.Define(a.stage, "/Robot/Looks/steel/Shader")
    shader.SetSourceAsset(Sdf.AssetPath("OmniPBR.mdl"), "mdl")
    shader.SetSourceAssetSubIdentifier("OmniPBR", "mdl")
    shader.CreateInput("diffuse_color_constant", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0.0, 0.5, 1.0))
    shader.CreateInput("diffuse_tint", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(1.0, 0.5, 1.0))
    if textured:
        file = shader.CreateInput("diffuse_texture", Sdf.ValueTypeNames.Asset)
        file.Set(Sdf.AssetPath(str(tmp_path / "wood.png")))
    material.CreateSurfaceOutput("mdl").ConnectToSource(shader.ConnectableAPI(), "out")
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    model, _ = a.load()
    expected = _srgb((1.0, 0.5, 1.0)) if textured else _srgb((0.0, 0.25, 1.0))
    np.testing.assert_allclose(model.geom("m").rgba[:3], expected, atol=1e-6)
    assert model.ntex == int(textured)


def test_another_shader_is_reported_and_leaves_the_display_colour(author, notes):
    a = author()
    prim = a.gprim("/Robot/v", "Cube", collider=False, size=0.4)
    UsdGeom.Gprim(prim).CreateDisplayColorAttr([Gf.Vec3f(1, 0, 0)])
    material = UsdShade.Material.Define(a.stage, "/Robot/look")
    shader = UsdShade.Shader.Define(a.stage, "/Robot/look/other")
    shader.CreateIdAttr("ND_standard_surface_surfaceshader")
    material.CreateSurfaceOutput("mtlx").ConnectToSource(shader.ConnectableAPI(), "out")
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    model, report = a.load()
    assert "not drawn" in notes(report, "/Robot/look")[0][0]
    np.testing.assert_allclose(model.geom("v").rgba, (1, 0, 0, 1))
