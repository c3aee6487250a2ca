"""Imports run downward only, and importing a package does no work."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[1] / "source"

FLOORS = [
    {"lift_lab.drawing", "lift_lab.utils"},
    {"lift_lab.usd"},
    {"lift_lab.sim"},
    {
        "lift_lab.actuators",
        "lift_lab.assets",
        "lift_lab.controllers",
        "lift_lab.devices",
        "lift_lab.markers",
        "lift_lab.sensors",
        "lift_lab.terrains",
        "lift_lab.visualizers",
    },
    {"lift_lab.scene"},
    {"lift_lab.managers"},
    {"lift_lab.envs"},
    {"lift_lab_assets", "lift_lab_rl", "lift_lab.app"},
    {"lift_lab_tasks"},
]


def _floor(module: str) -> int | None:
    for height, rooms in enumerate(FLOORS):
        if any(module == room or module.startswith(f"{room}.") for room in rooms):
            return height
    return None


def _runtime_imports(path: Path) -> list[str]:
    """Modules that a file imports when it is executed (not those for annotations only)."""
    tree = ast.parse(path.read_text())
    package = path.relative_to(SOURCE).with_suffix("").parts
    package = package[:-1]
    found = []

    def visit(node: ast.AST) -> None:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            return
        if isinstance(node, ast.Import):
            found.extend(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(part for part in (base, node.module or "") if part)
            found.append(module)
            found.extend(f"{module}.{alias.name}" for alias in node.names)
        for child in ast.iter_child_nodes(node):
            visit(child)

    visit(tree)
    return found


def _files() -> list[Path]:
    return sorted(SOURCE.rglob("*.py"))


def test_every_room_has_a_floor():
    rooms = {p.parent.name for p in SOURCE.glob("lift_lab/*/__init__.py")}
    known = {room.split(".")[1] for floor in FLOORS for room in floor if room.startswith("lift_lab.")}
    assert rooms == known


def test_imports_run_downward_only():
    wrong = []
    for path in _files():
        own = ".".join(path.relative_to(SOURCE).with_suffix("").parts)
        height = _floor(own)
        if height is None:
            continue
        for module in _runtime_imports(path):
            other = _floor(module)
            if other is not None and other > height:
                wrong.append(f"{own} imports {module}")
    assert not wrong


@pytest.mark.parametrize(
    ("package", "allowed"),
    [
        ("rsl_rl", ("lift_lab_rl", "lift_lab_tasks")),
        ("hydra", ("lift_lab_tasks", "lift_lab.app.multirun")),
        ("skrl", ("lift_lab_rl.skrl",)),
        ("stable_baselines3", ("lift_lab_rl.sb3", "lift_lab_rl.sb3_runs")),
        ("viser", ("lift_lab.visualizers",)),
        ("warp", ("lift_lab.sim.physics.warp",)),
        ("mujoco_warp", ("lift_lab.sim.physics.warp",)),
    ],
)
def test_a_heavy_package_is_imported_in_its_room_only(package, allowed):
    wrong = []
    for path in _files():
        own = ".".join(path.relative_to(SOURCE).with_suffix("").parts)
        if own.startswith(allowed):
            continue
        wrong += [own for module in _runtime_imports(path) if module.split(".")[0] == package]
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
