"""Build the USD files under `assets/usd/` from their descriptions.

    python scripts/maintainers/build_assets.py                  # rewrite the files
    python scripts/maintainers/build_assets.py --check          # compare only; exit 1 where a file differs
    python scripts/maintainers/build_assets.py --meshes DIR     # bake the Panda's visual meshes anew, too

The robot's numbers stand in `panda_description.py`, the cabinet's in `cabinet_description.py`, the other objects'
below. Visual meshes are baked by `mesh_baking.py` from the OBJ files of the PyPI package `dm-robotics-panda` 0.4.8
(see `assets/usd/NOTICE`); without `--meshes` the file that holds them is left alone.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable
from math import pi
from pathlib import Path

import cabinet_description as cabinet
import mesh_baking
import numpy as np
import panda_description as panda
import usd_authoring as author
from panda_description import Box, Contact, Link
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

ASSETS_DIR = Path(__file__).resolve().parents[2] / "assets" / "usd"
VISUALS_FILE = "franka_panda_visuals.usdc"
BUILT = "Built by scripts/maintainers/build_assets.py."

CUBE_EDGE = 0.04
"""Edge of the cube, m: on its corner, its centre stays below the lift threshold of 0.04 m (a 4.8 cm cube's
does not)."""
FACE_EDGE = 0.036
"""Edge of the coloured plate on each face, m."""
CUBE_MASS = 0.2
"""kg."""
CUBE_FACES = {
    "x_pos": ((1, 0, 0), (0.80, 0.08, 0.06)),
    "x_neg": ((-1, 0, 0), (0.90, 0.40, 0.05)),
    "y_pos": ((0, 1, 0), (0.05, 0.45, 0.12)),
    "y_neg": ((0, -1, 0), (0.06, 0.16, 0.65)),
    "z_pos": ((0, 0, 1), (0.85, 0.70, 0.06)),
    "z_neg": ((0, 0, -1), (0.75, 0.75, 0.75)),
}
"""Outward direction and linear RGB of each face."""

SOFT_CUBE_MASS = 0.1
"""kg."""
SOFT_CUBE_MATERIAL = {"youngsModulus": 5e4, "poissonsRatio": 0.3, "elasticityDamping": 0.005, "dynamicFriction": 1.0}
"""About as stiff as very soft silicone rubber: Pa, -, s, -. Rubber keeps its volume (0.49); MuJoCo's solver does not
converge there."""
SOFT_CUBE_COLOR = (0.85, 0.10, 0.35)
"""Linear RGB."""

TABLE_SIZE = (1.4, 1.4)
"""Table top along x and y, m. The lift task puts the table's middle 0.5 m in front of the robot: the top
spans x from -0.2 to 1.2 m and carries the robot's base, which begins at -0.154 m."""
TABLE_HEIGHT = 1.05
"""m, from the floor to the top, which is the table's origin."""
TABLE_THICKNESS = 0.04
"""Of the top as seen, m."""
TABLE_COLLIDER_THICKNESS = 0.2
"""Of the top as collided with, m: thick enough that nothing is pushed out at the bottom."""

CARTPOLE_BOXES = {
    "slider": Box("rail", (0.03, 8.0, 0.03), (0.0, 0.0, 0.0)),
    "cart": Box("cart", (0.2, 0.25, 0.2), (0.0, 0.0, 0.0)),
    "pole": Box("pole", (0.04, 0.06, 1.0), (0.0, 0.0, 0.47)),
}
"""The links of the cart-pole: uniform boxes of 1 kg each, in their own frames, as in the classic URDF."""
CARTPOLE_HINGE = (0.12, 0.0, 0.0)
"""Where the pole hangs on the cart, m."""


def author_panda(layer: Sdf.Layer) -> None:
    """`franka_panda.usda`: the arm with its hand, as Isaac Sim lays out an articulation."""
    stage, root = author.start_stage(
        layer,
        "Panda",
        f"Franka Emika Panda with its hand. {BUILT} Sources in NOTICE. Variant sets: "
        + ", ".join(f"{name} ({', '.join(variants)})" for name, variants in panda.VARIANTS.items()),
    )
    author.set_articulation_root(root)
    materials = {
        panda.LINK_CONTACT: author.define_material(stage, "/Panda/materials/link", panda.LINK_CONTACT),
        panda.PAD_CONTACT: author.define_material(stage, "/Panda/materials/pad", panda.PAD_CONTACT),
    }
    UsdGeom.Scope.Define(stage, "/Panda/materials")

    identity = (np.zeros(3), np.eye(3))
    poses = {"panda_link0": identity}
    for joint in panda.JOINTS:
        offset = np.array(joint.xyz), author.rotation_from_rpy(joint.rpy)
        poses[joint.child] = author.compose(poses[joint.parent], offset)
    for name, link in panda.LINKS.items():
        author.define_link(stage, f"/Panda/{name}", link, poses[name])

    for first, second in panda.FILTERED_PAIRS:
        filtered = UsdPhysics.FilteredPairsAPI.Apply(stage.GetPrimAtPath(f"/Panda/{first}"))
        filtered.CreateFilteredPairsRel().AddTarget(f"/Panda/{second}")

    author.define_fixed_joint(stage, f"/Panda/{panda.ROOT_JOINT}", "", "/Panda/panda_link0", identity)
    for joint in panda.JOINTS:
        path, parent, child = (
            f"/Panda/{joint.parent}/{joint.name}",
            f"/Panda/{joint.parent}",
            f"/Panda/{joint.child}",
        )
        pose = np.array(joint.xyz), author.rotation_from_rpy(joint.rpy)
        if joint.kind == "fixed":
            author.define_fixed_joint(stage, path, parent, child, pose)
            continue
        author.define_joint(
            stage,
            path,
            joint.kind,
            parent=parent,
            child=child,
            pose=pose,
            axis=joint.axis,
            limits=(joint.lower, joint.upper),
            drive=panda.DRIVE[joint.kind],
            effort=joint.effort,
            velocity=joint.velocity,
            armature=panda.ARMATURE,
            damping=panda.DAMPING[joint.kind],
        )

    def capsules(link: str, shapes: tuple[panda.Capsule, ...]) -> None:
        for capsule in shapes:
            shape = author.define_capsule(stage, f"/Panda/{link}/collisions/{capsule.name}", capsule)
            author.make_collider(shape, panda.LINK_CONTACT, materials[panda.LINK_CONTACT])

    for link, shapes in panda.LINK_COLLIDERS.items():
        UsdGeom.Xform.Define(stage, f"/Panda/{link}/collisions")
        capsules(link, shapes)
    for link in ("panda_hand", "panda_leftfinger", "panda_rightfinger"):
        UsdGeom.Xform.Define(stage, f"/Panda/{link}/collisions")

    def finger_colliders(variant: str) -> None:
        capsules("panda_hand", panda.HAND_COLLIDERS[variant])
        for side, turn in (("left", 0.0), ("right", pi)):
            for box in panda.FINGER_COLLIDERS[variant]:
                x, y, z = box.xyz
                name = f"panda_{side}finger_{box.name}"
                turned = Box(name, box.size, (x, y if side == "left" else -y, z), (box.rpy[0], box.rpy[1], turn))
                shape = author.define_box(stage, f"/Panda/panda_{side}finger/collisions/{name}", turned)
                author.make_collider(shape, panda.PAD_CONTACT, materials[panda.PAD_CONTACT])

    def finger_mimic(variant: str) -> None:
        if variant == "on":
            prim = stage.GetPrimAtPath("/Panda/panda_hand/panda_finger_joint2")
            prim.AddAppliedSchema("PhysxMimicJointAPI:rotX")
            # PhysX holds q + gearing * q_reference + offset = 0.
            author.attribute(prim, "physxMimicJoint:rotX:gearing", "float", -1.0)
            author.attribute(prim, "physxMimicJoint:rotX:offset", "float", 0.0)
            reference = prim.CreateRelationship("physxMimicJoint:rotX:referenceJoint", custom=False)
            reference.SetTargets(["/Panda/panda_hand/panda_finger_joint1"])

    def joint_friction(variant: str) -> None:
        if variant == "identified":
            for joint in panda.JOINTS:
                if joint.name in panda.FRICTION_LOSS:
                    prim = stage.GetPrimAtPath(f"/Panda/{joint.parent}/{joint.name}")
                    author.attribute(prim, "mjc:frictionloss", "double", panda.FRICTION_LOSS[joint.name])

    _author_variants(root, "FingerColliders", finger_colliders)
    _author_variants(root, "FingerMimic", finger_mimic)
    _author_variants(root, "JointFriction", joint_friction)


def author_panda_visuals(layer: Sdf.Layer) -> None:
    """Reference each link's baked meshes. By spec, no stage being open: an unsaved one could not resolve the
    file."""
    for link in panda.LINKS:
        spec = Sdf.CreatePrimInLayer(layer, f"/Panda/{link}/visuals")
        spec.specifier, spec.typeName, spec.instanceable = Sdf.SpecifierDef, "Xform", True
        spec.referenceList.Prepend(Sdf.Reference(f"./{VISUALS_FILE}", f"/Visuals/{link}"))


def _author_variants(prim: Usd.Prim, name: str, write: Callable[[str], None]) -> None:
    """Add a variant set of `panda.VARIANTS`; `write` authors one variant's opinions."""
    variant_set = prim.GetVariantSets().AddVariantSet(name)
    for variant in panda.VARIANTS[name]:
        variant_set.AddVariant(variant)
        variant_set.SetVariantSelection(variant)
        with variant_set.GetVariantEditContext():
            write(variant)
    variant_set.SetVariantSelection(panda.VARIANTS[name][0])


def author_cube(layer: Sdf.Layer) -> None:
    """`cube.usda`: a cube to grasp, a colour on each face. Its inertia follows from mass and collider, at any
    scale."""
    stage, root = author.start_stage(layer, "Cube", f"A cube of edge {CUBE_EDGE} m and {CUBE_MASS} kg. {BUILT}")
    UsdPhysics.RigidBodyAPI.Apply(root)
    UsdPhysics.MassAPI.Apply(root).CreateMassAttr(CUBE_MASS)
    material = author.define_material(stage, "/Cube/materials/surface", panda.PAD_CONTACT)
    UsdGeom.Scope.Define(stage, "/Cube/materials")
    UsdGeom.Xform.Define(stage, "/Cube/visuals")
    cube = Box("cube", (CUBE_EDGE, CUBE_EDGE, CUBE_EDGE), (0.0, 0.0, 0.0))
    # A dark body, and a plate on each face that leaves its edges bare and stands 0.1 mm proud of it.
    author.define_box(stage, "/Cube/visuals/body", cube, (0.02, 0.02, 0.02))
    for name, (normal, color) in CUBE_FACES.items():
        x, y, z = (0.0004 if n else FACE_EDGE for n in normal)
        i, j, k = (n * (CUBE_EDGE / 2 - 0.0001) for n in normal)
        author.define_box(stage, f"/Cube/visuals/face_{name}", Box(name, (x, y, z), (i, j, k)), color)
    UsdGeom.Xform.Define(stage, "/Cube/collisions")
    shape = author.define_box(stage, "/Cube/collisions/cube_collision", cube)
    author.make_collider(shape, panda.PAD_CONTACT, material)


def author_soft_cube(layer: Sdf.Layer) -> None:
    """`soft_cube.usda`: the cube as a PhysX deformable body."""
    doc = f"A soft cube of edge {CUBE_EDGE} m and {SOFT_CUBE_MASS} kg. {BUILT}"
    stage, _ = author.start_stage(layer, "SoftCube", doc)
    material = author.define_material(stage, "/SoftCube/materials/rubber", panda.PAD_CONTACT)
    UsdGeom.Scope.Define(stage, "/SoftCube/materials")
    material.GetPrim().AddAppliedSchema("PhysxDeformableBodyMaterialAPI")
    for name, value in SOFT_CUBE_MATERIAL.items():
        author.attribute(material.GetPrim(), f"physxDeformableBodyMaterial:{name}", "float", value)
    mesh = author.define_box_mesh(stage, "/SoftCube/mesh", (CUBE_EDGE,) * 3, SOFT_CUBE_COLOR)
    prim = mesh.GetPrim()
    prim.AddAppliedSchema("PhysxDeformableBodyAPI")
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(SOFT_CUBE_MASS)
    author.attribute(prim, "mjc:condim", "int", panda.PAD_CONTACT.condim)
    author.attribute(prim, "mjc:solref", "double[]", list(panda.PAD_CONTACT.solref))
    author.attribute(prim, "mjc:solimp", "double[]", list(panda.PAD_CONTACT.solimp))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, materialPurpose="physics")


def author_table(layer: Sdf.Layer) -> None:
    """`table.usda`: a static table; its origin is the middle of its top."""
    stage, _ = author.start_stage(
        layer,
        "Table",
        f"A static table, its top at z = 0 and its feet at z = {-TABLE_HEIGHT} m. {BUILT}",
    )
    contact: Contact = panda.LINK_CONTACT
    material = author.define_material(stage, "/Table/materials/surface", contact)
    UsdGeom.Scope.Define(stage, "/Table/materials")
    x, y = TABLE_SIZE
    UsdGeom.Xform.Define(stage, "/Table/visuals")
    top = Box("top", (x, y, TABLE_THICKNESS), (0.0, 0.0, -TABLE_THICKNESS / 2))
    author.define_box(stage, "/Table/visuals/table_top", top, (0.48, 0.36, 0.24))
    leg = 0.06
    height = TABLE_HEIGHT - TABLE_THICKNESS
    for i, (sx, sy) in enumerate(((1, 1), (1, -1), (-1, 1), (-1, -1))):
        center = (sx * (x - 2 * leg) / 2, sy * (y - 2 * leg) / 2, -TABLE_THICKNESS - height / 2)
        author.define_box(
            stage, f"/Table/visuals/table_leg{i}", Box("leg", (leg, leg, height), center), (0.1, 0.1, 0.11)
        )
    UsdGeom.Xform.Define(stage, "/Table/collisions")
    slab = Box("slab", (x, y, TABLE_COLLIDER_THICKNESS), (0.0, 0.0, -TABLE_COLLIDER_THICKNESS / 2))
    shape = author.define_box(stage, "/Table/collisions/table_collision", slab)
    author.make_collider(shape, contact, material)


def author_cartpole(layer: Sdf.Layer) -> None:
    """`cartpole.usda`: a cart on a rail with a pole, under the names of Isaac Lab's cart-pole."""
    stage, root = author.start_stage(layer, "Cartpole", f"A cart on a rail with a pole. {BUILT}")
    author.set_articulation_root(root)
    frames = {"slider": np.zeros(3), "cart": np.zeros(3), "pole": np.array(CARTPOLE_HINGE)}
    colors = {"slider": (0.60, 0.30, 0.05), "cart": (0.05, 0.20, 0.50), "pole": (0.70, 0.70, 0.70)}
    for name, box in CARTPOLE_BOXES.items():
        link = Link(1.0, box.xyz, author.box_inertia(1.0, box.size))
        author.define_link(stage, f"/Cartpole/{name}", link, (frames[name], np.eye(3)))
        UsdGeom.Xform.Define(stage, f"/Cartpole/{name}/visuals")
        shape = author.define_box(stage, f"/Cartpole/{name}/visuals/{name}_visual", box, colors[name])
        # Switched off: nothing touches the cart-pole, and the file says that this is meant.
        UsdPhysics.CollisionAPI.Apply(shape.GetPrim()).CreateCollisionEnabledAttr(False)
    author.define_fixed_joint(stage, "/Cartpole/root_joint", "", "/Cartpole/slider", (np.zeros(3), np.eye(3)))
    rail = ("slider_to_cart", "prismatic", "slider", "cart", "Y", (-4.0, 4.0))
    hinge = ("cart_to_pole", "revolute", "cart", "pole", "X", None)
    for name, kind, parent, child, axis, limits in (rail, hinge):
        author.define_joint(
            stage,
            f"/Cartpole/{parent}/{name}",
            kind,
            parent=f"/Cartpole/{parent}",
            child=f"/Cartpole/{child}",
            pose=(frames[child] - frames[parent], np.eye(3)),
            axis=axis,
            limits=limits,
            drive=(0.0, 0.0),
            effort=400.0,
            velocity=100.0,
        )


def author_cabinet(layer: Sdf.Layer) -> None:
    """`cabinet.usda`: a cabinet with drawers and doors, under the names of Isaac Sim's Sektion cabinet."""
    stage, root = author.start_stage(layer, "Cabinet", f"A cabinet with two drawers and two doors. {BUILT}")
    author.set_articulation_root(root)
    link, pad = panda.LINK_CONTACT, panda.PAD_CONTACT
    panel_material = author.define_material(stage, "/Cabinet/materials/panel", link)
    handle_material = author.define_material(stage, "/Cabinet/materials/handle", pad)
    UsdGeom.Scope.Define(stage, "/Cabinet/materials")
    for name, part in cabinet.PARTS.items():
        path = f"/Cabinet/{name}"
        author.define_link(stage, path, author.link_of_boxes(part.mass, part.boxes), (np.array(part.xyz), np.eye(3)))
        UsdGeom.Xform.Define(stage, f"{path}/visuals")
        UsdGeom.Xform.Define(stage, f"{path}/collisions")
        for box in part.boxes:
            author.define_box(stage, f"{path}/visuals/{name}_{box.name}_visual", box, part.color)
            shape = author.define_box(stage, f"{path}/collisions/{name}_{box.name}", box)
            if name in cabinet.GRASPED:
                author.make_collider(shape, pad, handle_material)
            else:
                author.make_collider(shape, link, panel_material)
    author.define_fixed_joint(stage, "/Cabinet/root_joint", "", "/Cabinet/sektion", (np.zeros(3), np.eye(3)))
    for joint in cabinet.JOINTS:
        parent, child = f"/Cabinet/{joint.parent}", f"/Cabinet/{joint.child}"
        pose = np.array(joint.xyz), np.eye(3)
        if joint.kind == "fixed":
            author.define_fixed_joint(stage, f"{parent}/{joint.name}", parent, child, pose)
            continue
        author.define_joint(
            stage,
            f"{parent}/{joint.name}",
            joint.kind,
            parent=parent,
            child=child,
            pose=pose,
            axis=joint.axis,
            limits=(joint.lower, joint.upper),
            drive=cabinet.DRIVE[joint.kind],
            effort=joint.effort,
            velocity=joint.velocity,
        )


AUTHORS: dict[str, tuple[Callable[[Sdf.Layer], None], ...]] = {
    "franka_panda.usda": (author_panda, author_panda_visuals),
    "cube.usda": (author_cube,),
    "soft_cube.usda": (author_soft_cube,),
    "table.usda": (author_table,),
    "cartpole.usda": (author_cartpole,),
    "cabinet.usda": (author_cabinet,),
}


def build(name: str) -> Sdf.Layer:
    """What the file `name` should say."""
    layer = Sdf.Layer.CreateAnonymous(name)
    for write in AUTHORS[name]:
        write(layer)
    return layer


_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def differs(layer: Sdf.Layer, path: Path) -> bool:
    """Whether the file is missing or says anything else than the layer.

    The last digits of numbers may: sines and products round differently on another processor.
    """
    there = Sdf.Layer.OpenAsAnonymous(str(path)) if path.is_file() else None
    if there is None:
        return True
    texts = [text.ExportToString() for text in (there, layer)]
    words, numbers = zip(*((_NUMBER.sub("0", text), _NUMBER.findall(text)) for text in texts), strict=True)
    return words[0] != words[1] or not np.allclose(*(np.array(n, float) for n in numbers), rtol=1e-12, atol=1e-12)


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Build the USD files under assets/usd.")
    parser.add_argument("--out", type=Path, default=ASSETS_DIR, help="folder of the files (default: assets/usd)")
    mode = parser.add_mutually_exclusive_group()
    mode.add_argument("--check", action="store_true", help="write nothing; exit 1 where a file differs")
    mode.add_argument("--meshes", type=Path, help="folder of OBJ files: bake the Panda's visual meshes, too")
    args = parser.parse_args(argv)
    if args.check:
        stale = [args.out / name for name in AUTHORS if differs(build(name), args.out / name)]
        for path in stale:
            print(f"{path} differs from its description: run scripts/maintainers/build_assets.py")
        return 1 if stale else 0
    if args.meshes:
        missing = [name for name in sorted(set(mesh_baking.SOURCES.values())) if not (args.meshes / name).is_file()]
        if missing:
            parser.error(f"--meshes {args.meshes}: no {', '.join(missing)}")
    args.out.mkdir(parents=True, exist_ok=True)
    for name in AUTHORS:
        build(name).Export(str(args.out / name))
        print(f"wrote {args.out / name}")
    if args.meshes:
        mesh_baking.bake(args.meshes, args.out / VISUALS_FILE)
        print(f"wrote {args.out / VISUALS_FILE}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
