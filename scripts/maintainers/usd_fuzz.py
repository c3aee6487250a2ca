"""Feed damaged USD files to the importer and count what happens.

python scripts/maintainers/usd_fuzz.py [--cases 2000] [--seconds 600] [--seed 0] [--keep FOLDER] [--only SUFFIX]

A case is a shipped or generated stage, damaged. Text (.usda) gets one to three mutations: extreme numbers, deleted,
doubled and swapped lines, exchanged paths and tokens, flipped bytes, truncation. Crates (.usdc) and packages (.usdz)
get flipped bytes, extreme integers where offsets and counts lie, copied and blanked stretches, truncation.

Files are imported by a process of their own with bounds on time and memory. A case may import (and then must compile
and step) or end in a UsdImportError of one line. Anything else is a failure: another exception, more than thirty
seconds of computing, the end of the interpreter. Failing files are kept in FOLDER, and the exit status is 1.
"saved" counts the refused crates and packages that ended, or held up, the process which the importer lets read them
first (lift_lab.usd.sandbox): without it they would be failures.
"""

from __future__ import annotations

import multiprocessing
import random
import re
import resource
import signal
import struct
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from lift_lab.app import cli

LIMIT_S = 30.0
"""Longest computing time of one case: a wrong count in a crate makes usd-core compute for seconds before it refuses.
A busy machine may take PATIENCE times as long by the clock."""
PATIENCE = 20.0
FINE = ("imported", "refused", "saved")
SAVED = re.compile(r"reading it (ends usd-core|takes more)")
MEMORY = 16 << 30
"""Address space of the importing process in bytes."""
NUMBER = re.compile(r"(?<![\w.<@/#])-?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.@/>])")
EXTREMES = ("0", "-1", "1", "nan", "inf", "-inf", "1e30", "-1e30", "1e-30", "1e300", "2147483648", "-0.0", "1e10")
INTEGERS = (0, 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)
TOKENS = ("X", "Y", "Z", "none", "convexHull", "boundingCube", "sdf", "guide", "proxy", "acceleration", "force", "true")


@dataclass
class Seed:
    """A valid file that cases are made from."""

    name: str
    content: bytes

    @property
    def suffix(self) -> str:
        return self.name.rsplit(".", 1)[-1]


def main() -> int:
    parser = cli.Parser(__doc__, overrides=False)
    parser.add_argument("--cases", type=int, default=2000, help="how many files to try")
    parser.add_argument("--seconds", type=float, default=600.0, help="stop after this time")
    parser.add_argument("--seed", type=int, default=0, help="seed of the mutations")
    parser.add_argument("--keep", type=Path, default=Path("usd_fuzz"), metavar="FOLDER", help="where failures go")
    parser.add_argument("--only", choices=("usda", "usdc", "usdz"), default=None, help="damage this format alone")
    args, _ = parser.parse()

    start = time.monotonic()
    seeds = [seed for seed in seed_files() if args.only in (None, seed.suffix)]
    counts = fuzz(seeds, args.cases, args.seconds, args.seed, args.keep)
    total, seconds = sum(counts.values()), time.monotonic() - start
    print(f"{total} cases in {seconds:.0f} s")
    for (suffix, outcome), count in sorted(counts.items()):
        print(f"{suffix}: {count} {outcome}")
    return 1 if failures(counts) else 0


def fuzz(seeds: list[Seed], cases: int, seconds: float, seed: int, keep: Path) -> Counter[tuple[str, str]]:
    """Try damaged files until `cases` or `seconds` are used up; returns counts by format and outcome."""
    counts: Counter[tuple[str, str]] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        worker = Worker()
        start = time.monotonic()
        for case in range(cases):
            if time.monotonic() - start > seconds:
                break
            rng = random.Random(f"{seed}-{case}")
            chosen = rng.choice(seeds)
            path = Path(folder) / f"{case}_{chosen.name}"
            path.write_bytes(damage(chosen, rng))
            outcome, detail = worker.run(path)
            counts[chosen.suffix, outcome] += 1
            if outcome not in FINE:
                keep.mkdir(parents=True, exist_ok=True)
                (keep / path.name).write_bytes(path.read_bytes())
                print(f"{outcome}: {keep / path.name}: {detail}", flush=True)
            path.unlink()
        worker.close()
    return counts


def failures(counts: Counter[tuple[str, str]]) -> int:
    """Number of cases that neither imported nor were refused."""
    return sum(count for (_, outcome), count in counts.items() if outcome not in FINE)


def seed_files(shipped: bool = True) -> list[Seed]:
    """Shipped stages with absolute references, and a generated one that uses most of the mapping, in every format."""
    from pxr import Sdf, Usd, UsdUtils

    from lift_lab_assets.files import ASSETS_USD_DIR

    texts, crates = [], []
    stage = Usd.Stage.CreateInMemory()
    generate(stage)
    with tempfile.TemporaryDirectory() as folder:
        layers = {"generated": stage.GetRootLayer()}
        for path in sorted(ASSETS_USD_DIR.glob("*.usda")) if shipped else ():
            text = path.read_text()
            texts.append(Seed(path.name, re.sub(r"@\./", f"@{path.parent.as_posix()}/", text).encode()))
            if "@" not in text and (layer := Sdf.Layer.OpenAsAnonymous(str(path))):
                layers[path.stem] = layer
        for name, layer in layers.items():
            crate, package = Path(folder) / f"{name}.usdc", Path(folder) / f"{name}.usdz"
            layer.Export(str(crate))
            crates.append(Seed(crate.name, crate.read_bytes()))
            UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(crate)), str(package))
            crates.append(Seed(package.name, package.read_bytes()))
    generated = Seed("generated.usda", stage.GetRootLayer().ExportToString().encode())
    # Half of the text cases are damaged copies of the generated stage, which is small and dense; half of all are text.
    texts += [generated] * max(1, len(texts))
    return texts * max(1, round(len(crates) / len(texts))) + crates


def damage(seed: Seed, rng: random.Random) -> bytes:
    """The content of a seed with random mutations that suit its format."""
    return mutate(seed.content.decode(), rng) if seed.suffix == "usda" else mutate_bytes(seed.content, rng)


def mutate_bytes(content: bytes, rng: random.Random) -> bytes:
    """A crate or package with one kind of damage."""
    data = bytearray(content)
    kind = rng.random()
    if kind < 0.1:
        del data[rng.randrange(len(data)) :]
    elif kind < 0.45:
        for _ in range(rng.choice((1, 1, 1, 2, 5, 20))):
            data[rng.randrange(len(data))] = rng.randrange(256)
    elif kind < 0.8:
        for _ in range(rng.randint(1, 2)):
            # Offsets and counts are eight bytes wide and mostly aligned; the header and the table at the end have most.
            at = rng.choice((rng.randrange(min(96, len(data) - 8)), rng.randrange(len(data) - 8)))
            at -= at % 8 if rng.random() < 0.7 else 0
            number = rng.choice((*INTEGERS, len(data), rng.getrandbits(16), rng.getrandbits(64)))
            data[at : at + 8] = struct.pack("<Q", number)
    elif kind < 0.9:
        first, second = sorted(rng.sample(range(len(data)), 2))
        length = min(rng.randint(1, 64), len(data) - second)
        data[first : first + length] = data[second : second + length]
    else:
        at, length = rng.randrange(len(data)), rng.randint(1, 64)
        data[at : at + length] = (rng.choice((b"\0", b"\xff")) * length)[: len(data) - at]
    return bytes(data)


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
    _add_instanced_colliders(stage)


def _add_instanced_colliders(stage) -> None:
    """Author a body whose colliders stand below an instanced prim with CollisionAPI, and a frame welded to it."""
    from pxr import Gf, Sdf, UsdGeom, UsdPhysics

    stage.CreateClassPrim("/shapes").SetTypeName("Xform")
    UsdGeom.Cube.Define(stage, "/shapes/box").CreateSizeAttr(0.5)
    UsdGeom.Xform.Define(stage, "/shapes/deep").AddTranslateOp().Set(Gf.Vec3d(0, 0, 0.5))
    UsdGeom.Sphere.Define(stage, "/shapes/deep/ball").CreateRadiusAttr(0.1)
    foot = UsdGeom.Xform.Define(stage, "/World/foot")
    foot.AddTranslateOp().Set(Gf.Vec3d(0, -3, 1))
    UsdPhysics.RigidBodyAPI.Apply(foot.GetPrim())
    colliders = UsdGeom.Xform.Define(stage, "/World/foot/colliders").GetPrim()
    colliders.GetReferences().AddInternalReference("/shapes")
    colliders.SetInstanceable(True)
    UsdPhysics.CollisionAPI.Apply(colliders)
    UsdPhysics.MeshCollisionAPI.Apply(colliders).CreateApproximationAttr("boundingCube")
    UsdPhysics.MassAPI.Apply(colliders).CreateMassAttr(3.0)
    colliders.CreateAttribute("physxCollision:contactOffset", Sdf.ValueTypeNames.Float).Set(0.02)
    frame = UsdGeom.Xform.Define(stage, "/World/frame").GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(frame)
    UsdPhysics.MassAPI.Apply(frame).CreateMassAttr(1e-9)
    frame.CreateAttribute("newton:inertia", Sdf.ValueTypeNames.DoubleArray).Set([0.0] * 6)
    weld = UsdPhysics.FixedJoint.Define(stage, "/World/weld")
    weld.CreateBody0Rel().SetTargets(["/World/foot"])
    weld.CreateBody1Rel().SetTargets(["/World/frame"])


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
            if self._pipe.poll(LIMIT_S * PATIENCE):
                return self._pipe.recv()
            outcome = "hung", f"no answer in {LIMIT_S * PATIENCE:g} s"
        except EOFError:
            self._process.join()
            code = self._process.exitcode
            hung = code == -signal.SIGPROF
            outcome = ("hung", f"more than {LIMIT_S:g} s of computing") if hung else ("crashed", f"exit status {code}")
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
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    pipe.send("ready")
    while True:
        try:
            path = pipe.recv()
        except EOFError:
            return
        # The timer of computing time ends the process, whatever code it is in.
        signal.setitimer(signal.ITIMER_PROF, LIMIT_S)
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
            text = str(error)
            outcome = "saved" if SAVED.search(text) else "refused"
            pipe.send((outcome, text) if "\n" not in text else ("failed in message", text[:200]))
        except BaseException as error:
            pipe.send((f"failed in {stage}", f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"))
        signal.setitimer(signal.ITIMER_PROF, 0)


if __name__ == "__main__":
    cli.run(main)
