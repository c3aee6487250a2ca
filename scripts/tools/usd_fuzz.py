"""Feed damaged USD files to the importer and count what happens.

python scripts/tools/usd_fuzz.py [--cases 2000] [--seconds 600] [--seed 0] [--keep FOLDER]

Each case is a shipped or generated stage with one to three mutations: extreme numbers, deleted, doubled and swapped
lines, exchanged paths and tokens, flipped bytes, truncation. A case may import (and then must compile and step) or end
in a UsdImportError. Anything else, a case that takes longer than ten seconds, or one that ends the interpreter, is a
failure; failing files are kept in FOLDER, and the exit status is 1.
"""

from __future__ import annotations

import multiprocessing
import random
import re
import tempfile
import time
from collections import Counter
from pathlib import Path

from lift_lab.app import cli

LIMIT_S = 10.0
"""Longest time one case may take."""
NUMBER = re.compile(r"(?<![\w.<@/#])-?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.@/>])")
EXTREMES = ("0", "-1", "1", "nan", "inf", "-inf", "1e30", "-1e30", "1e-30", "1e300", "2147483648", "-0.0", "1e10")
TOKENS = ("X", "Y", "Z", "none", "convexHull", "boundingCube", "sdf", "guide", "proxy", "acceleration", "force", "true")


def main() -> int:
    parser = cli.Parser(__doc__, overrides=False)
    parser.add_argument("--cases", type=int, default=2000, help="how many files to try")
    parser.add_argument("--seconds", type=float, default=600.0, help="stop after this time")
    parser.add_argument("--seed", type=int, default=0, help="seed of the mutations")
    parser.add_argument("--keep", type=Path, default=Path("usd_fuzz"), metavar="FOLDER", help="where failures go")
    args, _ = parser.parse()

    seeds = seed_files()
    counts: Counter[str] = Counter()
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        worker = Worker()
        for case in range(args.cases):
            if time.monotonic() - start > args.seconds:
                break
            rng = random.Random(f"{args.seed}-{case}")
            name, text = rng.choice(seeds)
            path = Path(folder) / f"{case}_{name}"
            path.write_bytes(mutate(text, rng))
            outcome, detail = worker.run(path)
            counts[outcome] += 1
            if outcome not in ("imported", "refused"):
                args.keep.mkdir(parents=True, exist_ok=True)
                path.replace(args.keep / path.name)
                print(f"{outcome}: {args.keep / path.name}: {detail}", flush=True)
            path.unlink(missing_ok=True)
        worker.close()
    total, seconds = sum(counts.values()), time.monotonic() - start
    print(f"{total} cases in {seconds:.0f} s: " + ", ".join(f"{n} {outcome}" for outcome, n in counts.most_common()))
    return 0 if total == counts["imported"] + counts["refused"] else 1


def seed_files() -> list[tuple[str, str]]:
    """Shipped stages as text, with absolute references, and a generated one that uses most of the mapping."""
    from pxr import Usd

    from lift_lab.utils.assets import ASSETS_USD_DIR

    found = []
    for path in sorted(ASSETS_USD_DIR.glob("*.usda")):
        text = path.read_text()
        found.append((path.name, re.sub(r"@\./", f"@{path.parent.as_posix()}/", text)))
    stage = Usd.Stage.CreateInMemory()
    generate(stage)
    # The generated stage is small and dense: give it half of the cases.
    return found + [("generated.usda", stage.GetRootLayer().ExportToString())] * max(1, len(found))


def generate(stage) -> None:
    """Author bodies of every shape, joints of every kind, drives, materials, groups and MjcPhysics prims."""
    from pxr import Gf, Sdf, UsdGeom, UsdPhysics, UsdShade

    names = Sdf.ValueTypeNames
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    material = UsdShade.Material.Define(stage, "/World/rubber")
    UsdPhysics.MaterialAPI.Apply(material.GetPrim()).CreateDynamicFrictionAttr(0.7)
    shapes = ("Cube", "Sphere", "Capsule", "Cylinder", "Cone", "Mesh")
    for i, shape in enumerate(shapes):
        body = UsdGeom.Xform.Define(stage, f"/World/b{i}")
        body.AddTranslateOp().Set(Gf.Vec3d(i, 0, 1))
        body.AddScaleOp().Set(Gf.Vec3f(1, 1, -1 if i == 5 else 1))
        UsdPhysics.RigidBodyAPI.Apply(body.GetPrim())
        if i % 2:
            mass = UsdPhysics.MassAPI.Apply(body.GetPrim())
            mass.CreateMassAttr(2.0)
            mass.CreateDiagonalInertiaAttr(Gf.Vec3f(0.1, 0.2, 0.25))
        prim = getattr(UsdGeom, shape).Define(stage, f"/World/b{i}/s").GetPrim()
        if shape == "Mesh":
            mesh = UsdGeom.Mesh(prim)
            mesh.CreatePointsAttr([Gf.Vec3f(*p) for p in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))])
            mesh.CreateFaceVertexCountsAttr([3, 3, 3, 3])
            mesh.CreateFaceVertexIndicesAttr([0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2])
            UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr("convexHull")
        UsdPhysics.CollisionAPI.Apply(prim)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    kinds = ("RevoluteJoint", "PrismaticJoint", "SphericalJoint", "Joint", "FixedJoint", "DistanceJoint")
    for i, kind in enumerate(kinds):
        joint = getattr(UsdPhysics, kind).Define(stage, f"/World/j{i}")
        joint.CreateBody0Rel().SetTargets([f"/World/b{i}"])
        joint.CreateBody1Rel().SetTargets([f"/World/b{(i + 1) % len(shapes)}"])
        joint.CreateLocalPos0Attr(Gf.Vec3f(1, 0, 0))
        if kind in kinds[:2]:
            joint.CreateLowerLimitAttr(-30.0)
            joint.CreateUpperLimitAttr(40.0)
            drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular" if i == 0 else "linear")
            drive.CreateStiffnessAttr(5.0)
            drive.CreateTypeAttr("force")
            joint.GetPrim().CreateAttribute("physxJoint:armature", names.Float).Set(0.1)
    limit = UsdPhysics.LimitAPI.Apply(stage.GetPrimAtPath("/World/j3"), "rotX")
    limit.CreateLowAttr(-10.0)
    limit.CreateHighAttr(20.0)
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath("/World/b0"))
    UsdPhysics.FilteredPairsAPI.Apply(stage.GetPrimAtPath("/World/b0")).CreateFilteredPairsRel().SetTargets(
        ["/World/b3"]
    )
    group = UsdPhysics.CollisionGroup.Define(stage, "/World/group")
    group.GetCollidersCollectionAPI().CreateIncludesRel().SetTargets(["/World/b1", "/World/b2"])
    group.CreateFilteredGroupsRel().SetTargets(["/World/group"])
    UsdPhysics.Scene.Define(stage, "/World/scene").CreateGravityMagnitudeAttr(9.81)
    motor = stage.DefinePrim("/World/motor", "MjcActuator")
    motor.CreateAttribute("mjc:gear", names.DoubleArray).Set([1, 0, 0, 0, 0, 0])
    motor.CreateRelationship("mjc:target").SetTargets(["/World/j0"])
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/heap")
    ball = UsdGeom.Sphere.Define(stage, "/World/heap/ball").GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(ball)
    UsdPhysics.CollisionAPI.Apply(ball)
    instancer.CreatePrototypesRel().SetTargets([ball.GetPath()])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([Gf.Vec3f(0, 3, 1), Gf.Vec3f(0, 6, 1)])


def mutate(text: str, rng: random.Random) -> bytes:
    """`text` with one to three mutations."""
    for _ in range(rng.randint(1, 3)):
        text = rng.choice((_number, _number, _number, _line, _path, _token))(text, rng)
    content = text.encode()
    damage = rng.random()
    if damage < 0.03:
        content = content[: rng.randrange(len(content))]
    elif damage < 0.06:
        at = rng.randrange(len(content))
        content = content[:at] + bytes([rng.randrange(256)]) + content[at + 1 :]
    return content


def _swap(text: str, match: re.Match[str], new: str) -> str:
    return text[: match.start()] + new + text[match.end() :]


def _number(text: str, rng: random.Random) -> str:
    found = list(NUMBER.finditer(text))
    match = rng.choice(found)
    new = rng.choice(EXTREMES) if rng.random() < 0.7 else repr(float(match.group()) * rng.choice((-1, 1e6, 1e-6)))
    return _swap(text, match, new)


def _line(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    at = rng.randrange(1, len(lines))
    change = rng.randrange(3)
    if change == 0:
        del lines[at]
    elif change == 1:
        lines.insert(at, lines[at])
    else:
        other = rng.randrange(1, len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    return "\n".join(lines)


def _path(text: str, rng: random.Random) -> str:
    found = list(re.finditer(r"<(/[\w/]+)>", text))
    return _swap(text, rng.choice(found), f"<{rng.choice(found).group(1)}>") if found else text


def _token(text: str, rng: random.Random) -> str:
    found = list(re.finditer(r'= "(\w+)"', text))
    return _swap(text, rng.choice(found), f'= "{rng.choice(TOKENS)}"') if found else text


class Worker:
    """A process that imports files on demand, started anew when a file ends it or takes too long."""

    def __init__(self) -> None:
        self._context = multiprocessing.get_context("spawn")
        self._start()

    def _start(self) -> None:
        self._pipe, other = self._context.Pipe()
        self._process = self._context.Process(target=_serve, args=(other,), daemon=True)
        self._process.start()
        other.close()
        self._pipe.recv()  # imports are done

    def run(self, path: Path) -> tuple[str, str]:
        """Outcome of importing one file and a line about it."""
        self._pipe.send(str(path))
        try:
            if self._pipe.poll(LIMIT_S):
                return self._pipe.recv()
            outcome = "hung", f"no answer in {LIMIT_S:g} s"
        except EOFError:
            outcome = "crashed", "the interpreter ended"
        self.close()
        self._start()
        return outcome

    def close(self) -> None:
        self._process.kill()
        self._process.join()
        self._pipe.close()


def _serve(pipe) -> None:
    import mujoco

    from lift_lab.usd import UsdImportError, load

    mujoco.set_mju_user_warning(lambda message: None)
    pipe.send("ready")
    while True:
        path = pipe.recv()
        stage = "load"
        try:
            spec, report = load(path)
            report.table()
            stage = "compile"
            model = spec.compile()
            stage = "step"
            mujoco.mj_step(model, mujoco.MjData(model))
            pipe.send(("imported", ""))
        except UsdImportError as error:
            pipe.send(("refused", str(error)))
        except BaseException as error:
            pipe.send((f"failed in {stage}", f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"))


if __name__ == "__main__":
    cli.run(main)
