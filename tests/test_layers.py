"""Rules between packages: imports run downward only, and what one package may know of another.

``docs/architecture.md`` lists the rules in words. Each test reads the source as a syntax tree.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from itertools import pairwise
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[1] / "source"

LAYERS = [
    {"lift_lab.drawing", "lift_lab.isaac.finder", "lift_lab.isaac.table", "lift_lab.utils"},
    {"lift_lab.usd"},
    {"lift_lab.sim"},
    {
        "lift_lab.actuators",
        "lift_lab.assets",
        "lift_lab.controllers",
        "lift_lab.markers",
        "lift_lab.sensors",
        "lift_lab.terrains",
        "lift_lab.visualizers",
    },
    {"lift_lab.scene"},
    {"lift_lab.isaac", "lift_lab.managers"},
    {"lift_lab.envs"},
    {"lift_lab_assets", "lift_lab_rl", "lift_lab.app"},
    {"lift_lab_tasks"},
    {"lift_lab_cli"},
]
"""From the lowest to the highest. A package imports from its own layer and from lower ones."""

ENGINES = "lift_lab.sim.physics"
"""The package of the physics engines, which knows them by name."""

ENGINE_TABLE = "lift_lab.sim.engines"
"""The module that lists them."""

ENGINE_NAMES = {"native", "warp"}

TASK_WORDS = {"lift", "lifting", "cube", "franka", "panda", "cabinet", "sektion", "cartpole", "object_pose"}
"""Words of tasks and robots, which the framework does not know."""

FRAMEWORK = {"lift_lab", "lift_lab_rl"}

SHAPE_WORDS = {"lift_lab.usd": {"cube"}, "lift_lab.sim.spawners": {"cube"}}
"""In these packages a cube is a shape of USD."""

PYTHON_PACKAGE_NAMES = {"lift_lab.utils.state_writer"}
"""In these modules ``warp`` is the Python package."""

PUBLIC = {"os._exit"}
"""Documented names that begin with an underscore."""

PRIVATE_ACCESSES = {
    "_version": "torch counts the writes into a tensor and has no public name for the count",
    "_foreach_add_": "one call for many tensors; torch's optimizers do the same",
    "_foreach_copy_": "the same",
    "_foreach_mul_": "the same",
}
"""Private attributes that a module may use of an object of another one, and why."""

MOST_PRIVATE_ACCESSES = 8
"""How often they are used. The limit only becomes lower."""


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def modules() -> list[tuple[str, Path]]:
    """Name and path of every module; a package has the name ``package.__init__``."""
    paths = sorted(SOURCE.rglob("*.py"))
    return [(".".join(path.relative_to(SOURCE).with_suffix("").parts), path) for path in paths]


def is_in(module: str, packages: set[str]) -> bool:
    return any(module == package or module.startswith(f"{package}.") for package in packages)


def layer_of(module: str) -> int | None:
    return next((height for height, packages in enumerate(LAYERS) if is_in(module, packages)), None)


def imports(module: str, path: Path, for_types_too: bool = False) -> Iterator[str]:
    """Modules and names that a module imports when it is executed, and on request those for annotations alone."""
    return _imports(module, tree_of(path), for_types_too)


def _imports(module: str, tree: ast.Module, for_types_too: bool) -> Iterator[str]:
    package = module.split(".")[:-1]

    def visit(node: ast.AST) -> Iterator[str]:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test) and not for_types_too:
            return
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            source = ".".join([*base, *([node.module] if node.module else [])])
            yield source
            yield from (f"{source}.{alias.name}" for alias in node.names)
        for child in ast.iter_child_nodes(node):
            yield from visit(child)

    return visit(tree)


TOP_LEVEL = (ast.Import, ast.ImportFrom, ast.If, ast.Try)
"""Statements with which a module imports when it is imported itself."""


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


# -- imports


def test_every_package_has_a_layer():
    packages = {path.parent.name for path in SOURCE.glob("lift_lab/*/__init__.py")}
    known = {name.split(".")[1] for layer in LAYERS for name in layer if name.startswith("lift_lab.")}
    assert packages == known


def test_imports_run_downward_only():
    wrong = []
    for own, path in modules():
        height = layer_of(own)
        for module in imports(own, path) if height is not None else ():
            other = layer_of(module)
            if other is not None and other > height:
                wrong.append(f"{own} imports {module}")
    assert not wrong


def test_no_modules_import_each_other_in_a_circle():
    """Imports inside of functions and for annotations are left out."""
    names = {own.removesuffix(".__init__") for own, _ in modules()}
    graph = {}
    for own, path in modules():
        top = ast.Module([node for node in tree_of(path).body if isinstance(node, TOP_LEVEL)], [])
        found = {module for module in _imports(own, top, False) if module in names}
        graph[own.removesuffix(".__init__")] = {m for m in found if not f"{own}.".startswith(f"{m}.")}
    TopologicalSorter(graph).prepare()  # raises a CycleError that names a circle


@pytest.mark.parametrize(
    ("package", "allowed"),
    [
        ("rsl_rl", ("lift_lab_rl", "lift_lab_tasks")),
        ("hydra", ("lift_lab_tasks", "lift_lab.app.multirun")),
        ("skrl", ("lift_lab_rl.skrl",)),
        ("stable_baselines3", ("lift_lab_rl.sb3", "lift_lab_rl.sb3_runs")),
        ("viser", ("lift_lab.visualizers",)),
        ("warp", (f"{ENGINES}.warp",)),
        ("mujoco_warp", (f"{ENGINES}.warp",)),
    ],
)
def test_a_heavy_package_is_imported_where_it_is_needed_only(package, allowed):
    wrong = []
    for own, path in modules():
        if not own.startswith(allowed):
            wrong += [own for module in imports(own, path) if module.split(".")[0] == package]
    assert not wrong


def test_private_modules_and_names_are_imported_in_their_own_package_only():
    """``a.b._c`` is for modules of ``a.b``, and so is the name ``_c`` of a module ``a.b.module``."""
    wrong = []
    for own, path in modules():
        for module in imports(own, path, for_types_too=True):
            parts = module.split(".")
            first = next((i for i, part in enumerate(parts) if is_private(part)), None)
            if first is None or parts[0] not in ("lift_lab", "lift_lab_assets", "lift_lab_rl", "lift_lab_tasks"):
                continue
            owner = parts[:first]
            if SOURCE.joinpath(*owner).with_suffix(".py").is_file():  # a name in a module
                owner = owner[:-1]
            if not is_in(own, {".".join(owner)}):
                wrong.append(f"{own} imports {module}")
    assert not wrong


def _loaded_by(code: str, modules: tuple[str, ...]) -> str:
    """Which of some modules a fresh interpreter has loaded after some code, as the text of a list."""
    code = f"import sys; {code}; print([m for m in {modules} if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return out.stdout.strip()


def test_importing_the_tasks_loads_no_engine_and_no_learner():
    assert _loaded_by("import lift_lab_tasks", ("warp", "mujoco_warp", "mujoco", "rsl_rl", "pxr", "hydra")) == "[]"


def test_seeding_loads_no_compiler():
    """Torch's takes seconds to import, and its switch for deterministic algorithms does it."""
    code = "from lift_lab.utils.seed import configure_seed; configure_seed(1)"
    assert _loaded_by(code, ("torch._dynamo", "torch._inductor")) == "[]"


# -- words


def strings(tree: ast.Module) -> Iterator[ast.Constant]:
    """String constants, without docstrings."""
    bodies = (getattr(node, "body", None) for node in ast.walk(tree))
    statements = (statement for body in bodies if isinstance(body, list) for statement in body)
    docstrings = {id(s.value) for s in statements if isinstance(s, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            yield node


def identifiers(tree: ast.Module) -> Iterator[str]:
    """Names of variables, attributes, arguments, functions, classes and imports."""
    for node in ast.walk(tree):
        for field in ("id", "attr", "arg", "name", "asname"):
            if isinstance(name := getattr(node, field, None), str):
                yield name


def words(text: str) -> set[str]:
    """Lower-case words of a text or an identifier, and its pairs of words; the product's own name is none."""
    text = re.sub(r"(?i)lift[_-]?lab", " ", text)
    found = [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", text)]
    return {*found, *(f"{one}_{two}" for one, two in pairwise(found))}


def test_no_module_above_the_engines_knows_one_by_name():
    named, imported = [], []
    for own, path in modules():
        if is_in(own, {ENGINES, ENGINE_TABLE}):
            continue
        if own not in PYTHON_PACKAGE_NAMES and any(text.value in ENGINE_NAMES for text in strings(tree_of(path))):
            named.append(own)
        for module in imports(own, path, for_types_too=True):
            name = module.removeprefix(f"{ENGINES}.").split(".")[0]
            if module.startswith(f"{ENGINES}.") and name.startswith(tuple(ENGINE_NAMES)):
                imported.append(f"{own} imports {module}")
    assert not named
    assert not imported


def test_the_framework_has_no_words_of_a_task():
    """Examples in docstrings and comments may be of a task; identifiers and texts may not."""
    wrong = {}
    for own, path in modules():
        if is_in(own, FRAMEWORK):
            allowed = set().union(*(known for package, known in SHAPE_WORDS.items() if is_in(own, {package})))
            texts = [*identifiers(tree_of(path)), *(str(text.value) for text in strings(tree_of(path)))]
            if found := set().union(*map(words, texts)) & TASK_WORDS - allowed:
                wrong[own] = found
    assert not wrong


# -- private attributes


def own_attributes(tree: ast.Module) -> set[str]:
    """Attributes and methods of the classes that a module defines."""
    found = set()
    for cls in (node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)):
        for node in ast.walk(cls):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                found.add(node.name)
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                found.add(node.id)
            elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and _is_self(node.value):
                found.add(node.attr)
    return found


def _is_self(node: ast.expr) -> bool:
    if isinstance(node, ast.Call):
        node = node.func
    return isinstance(node, ast.Name) and node.id in ("self", "cls", "super")


def private_accesses(tree: ast.Module) -> list[str]:
    """Expressions ``x._y`` that reach into another module's object.

    Here x is not ``self``, ``cls`` or ``super()``, and no class of the module defines ``_y``.
    """
    own = own_attributes(tree)
    attributes = (node for node in ast.walk(tree) if isinstance(node, ast.Attribute))
    return [
        ast.unparse(node)
        for node in attributes
        if is_private(node.attr)
        and node.attr not in own
        and not _is_self(node.value)
        and ast.unparse(node) not in PUBLIC
    ]


def test_private_attributes_are_used_by_their_own_module():
    found = [(own, access) for own, path in modules() for access in private_accesses(tree_of(path))]
    names = [access.rpartition(".")[2] for _, access in found]
    assert not [place for place, name in zip(found, names, strict=True) if name not in PRIVATE_ACCESSES]
    assert set(PRIVATE_ACCESSES) == set(names), "a name that is no longer used leaves the list"
    assert len(found) <= MOST_PRIVATE_ACCESSES, found


def test_the_rules_find_what_they_are_for():
    tree = ast.parse("""
class Own:
    "franka"
    kept: int = 0
    def __init__(self, other):
        self._x = other._y
        super()._z
        other._x, cls._w, other.__dict__
        self._deep._v = "Franka robots, object_pose" + other.cubeSize
""")
    assert private_accesses(tree) == ["other._y", "self._deep._v"]
    assert [text.value for text in strings(tree)] == ["Franka robots, object_pose"]
    assert words("Franka robots, object_pose of LiftLabRunner") >= {"franka", "robots", "object_pose", "runner"}
    assert not words("lift_lab_rl LiftLabRunner lift-lab") & TASK_WORDS
    assert "cube" in words("cubeSize") & words("_ScaledCube") & words("CUBE")
    assert {"Own", "kept", "other", "cubeSize"} <= set(identifiers(tree))
