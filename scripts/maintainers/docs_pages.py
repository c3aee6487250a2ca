"""The table of the reference's pages: which modules each one documents."""

from __future__ import annotations

from dataclasses import dataclass

TASKS = "lift_lab_tasks.manager_based"
LIFT = f"{TASKS}.manipulation.lift"
REACH = f"{TASKS}.manipulation.reach"
CABINET = f"{TASKS}.manipulation.cabinet"
CARTPOLE = f"{TASKS}.classic.cartpole"


@dataclass
class Page:
    """A page of the reference: file below ``docs/``, title, a line of text, and section titles with their modules.

    A module that ends in ``.*`` stands for itself and for all modules below it, each with a section of its own.
    """

    file: str
    title: str
    text: str
    sections: dict[str, str]


def _mdp(name: str, title: str, text: str, *tasks: str) -> Page:
    """Return the page of one kind of term: Isaac Lab's terms, then those of our tasks."""
    sections = {"General terms": f"lift_lab.envs.mdp.{name}"}
    sections |= {f"Terms of the {task.rpartition('.')[2]} task": f"{task}.mdp.{name}" for task in tasks}
    return Page(f"api/{name}.md", title, text, sections)


_TERMS = "Import general terms from `lift_lab.envs.mdp`, and those of a task from its `mdp` package."
PAGES: dict[str, list[Page]] = {
    "Environment": [
        Page(
            "api/envs.md",
            "Environments",
            "Import from `lift_lab.envs`.",
            {"Environments": "lift_lab.envs", "IO descriptors": "lift_lab.envs.utils.io_descriptors"},
        ),
        Page("api/managers.md", "Managers", "Import from `lift_lab.managers`.", {"Managers": "lift_lab.managers"}),
    ],
    "Terms": [
        Page(
            "api/actions.md",
            "Actions",
            _TERMS,
            {"General terms": "lift_lab.envs.mdp.actions", "Base class": "lift_lab.envs.mdp.actions.stored_action"},
        ),
        _mdp("commands", "Commands", _TERMS, LIFT),
        _mdp("observations", "Observations", _TERMS, LIFT, CABINET),
        _mdp("rewards", "Rewards", _TERMS, LIFT, REACH, CABINET, CARTPOLE),
        _mdp("terminations", "Terminations", _TERMS, LIFT),
        _mdp("events", "Events", _TERMS),
        _mdp("curriculums", "Curriculums", _TERMS, LIFT),
        Page(
            "api/metrics.md",
            "Metrics",
            _TERMS,
            {
                "General terms": "lift_lab.envs.mdp.metrics",
                "Terms of the lift task": f"{LIFT}.mdp.metrics",
                "Terms of the reach task": f"{REACH}.mdp.success",
                "Terms of the cabinet task": f"{CABINET}.mdp.success",
                "Terms of the cartpole task": f"{CARTPOLE}.mdp.success",
            },
        ),
        _mdp("recorders", "Recorders", _TERMS),
        Page(
            "api/mirror.md",
            "Mirror symmetry",
            "Import from `lift_lab.envs.mirror` and `lift_lab.utils.mirror`. [PPO](../ppo.md#symmetry) uses it.",
            {"Tasks": "lift_lab.envs.mirror", "Kinds and maps": "lift_lab.utils.mirror"},
        ),
        Page(
            "api/noise.md",
            "Noise and modifiers",
            "Import from `lift_lab.utils.noise` and `lift_lab.utils.modifiers`. Observation terms take both.",
            {"Noise": "lift_lab.utils.noise", "Modifiers": "lift_lab.utils.modifiers"},
        ),
    ],
    "Scene": [
        Page("api/scene.md", "Scene", "Import from `lift_lab.scene`.", {"Scene": "lift_lab.scene"}),
        Page("api/assets.md", "Assets", "Import from `lift_lab.assets`.", {"Assets": "lift_lab.assets"}),
        Page("api/actuators.md", "Actuators", "Import from `lift_lab.actuators`.", {"Actuators": "lift_lab.actuators"}),
        Page("api/sensors.md", "Sensors", "Import from `lift_lab.sensors`.", {"Sensors": "lift_lab.sensors"}),
        Page("api/terrains.md", "Terrains", "Import from `lift_lab.terrains`.", {"Terrains": "lift_lab.terrains"}),
        Page(
            "api/controllers.md",
            "Controllers",
            "Import from `lift_lab.controllers`.",
            {"Controllers": "lift_lab.controllers"},
        ),
        Page(
            "api/markers.md",
            "Markers",
            "Import from `lift_lab.markers` and `lift_lab.markers.config`.",
            {"Markers": "lift_lab.markers", "Ready-made configurations": "lift_lab.markers.config"},
        ),
        Page(
            "api/robots.md",
            "Robots and files",
            "Import from `lift_lab_assets`.",
            {"Robots": "lift_lab_assets.robots", "Files": "lift_lab_assets.files"},
        ),
    ],
    "Simulation": [
        Page(
            "api/spawners.md",
            "Spawners",
            "Import from `lift_lab.sim`. A spawner is the `spawn` field of an asset's configuration.",
            {
                "Files": "lift_lab.sim.spawners.from_files",
                "Shapes": "lift_lab.sim.spawners.shapes",
                "Meshes": "lift_lab.sim.spawners.meshes",
                "Lights": "lift_lab.sim.spawners.lights",
                "Base classes": "lift_lab.sim.spawners.spawner_cfg",
            },
        ),
        Page(
            "api/materials.md",
            "Materials",
            "Import from `lift_lab.sim`.",
            {"Materials": "lift_lab.sim.spawners.materials"},
        ),
        Page(
            "api/schemas.md",
            "Physics properties",
            "Import from `lift_lab.sim`. Spawners take these. A field that is None keeps the file's value.",
            {"Properties": "lift_lab.sim.schemas"},
        ),
        Page("api/sim.md", "Simulation", "Import from `lift_lab.sim`.", {"Simulation": "lift_lab.sim"}),
        Page(
            "api/physics.md",
            "Physics engines",
            "Import from `lift_lab.sim.physics`.",
            {"Engines": "lift_lab.sim.physics"},
        ),
        Page("api/usd.md", "USD", "Import from `lift_lab.usd`.", {"USD": "lift_lab.usd"}),
    ],
    "Learning": [
        Page("api/rsl_rl.md", "rsl_rl", "Import from `lift_lab_rl.rsl_rl`.", {"rsl_rl": "lift_lab_rl.rsl_rl"}),
        Page(
            "api/libraries.md",
            "skrl, Stable-Baselines3",
            "Import from the module that a section names.",
            {
                "Stable-Baselines3": "lift_lab_rl.sb3",
                "skrl": "lift_lab_rl.skrl",
                "Add a library": "lift_lab_cli.library",
            },
        ),
        Page(
            "api/rl.md",
            "Evaluation, video, viewer",
            "Import from the module that a section names.",
            {
                "Evaluation": "lift_lab_rl.evaluation",
                "Perturbations": "lift_lab_rl.perturbations",
                "Video": "lift_lab_rl.video",
                "Viewer": "lift_lab_rl.viewer",
            },
        ),
    ],
    "Tasks": [
        Page(
            "api/tasks.md",
            "Registry and overrides",
            "Import from the module that a section names.",
            {
                "Registry": "lift_lab_tasks.utils",
                "Overrides": "lift_lab_tasks.utils.hydra",
                "Settings": "lift_lab_tasks.settings",
            },
        ),
        Page("api/task_lift.md", "Lift", f"Import from `{LIFT}` and its modules.", {"": f"{LIFT}.*"}),
        Page("api/task_reach.md", "Reach", f"Import from `{REACH}` and its modules.", {"": f"{REACH}.*"}),
        Page("api/task_cabinet.md", "Cabinet", f"Import from `{CABINET}` and its modules.", {"": f"{CABINET}.*"}),
        Page("api/task_cartpole.md", "Cart-pole", f"Import from `{CARTPOLE}` and its modules.", {"": f"{CARTPOLE}.*"}),
    ],
    "Utilities": [
        Page(
            "api/math.md", "Mathematics", "Import from `lift_lab.utils.math`.", {"Mathematics": "lift_lab.utils.math"}
        ),
        Page(
            "api/utils.md",
            "Utilities",
            "Import from the module that a section names.",
            {
                "Configuration classes": "lift_lab.utils.configclass",
                "Dictionaries": "lift_lab.utils.dict",
                "Strings": "lift_lab.utils.string",
                "Arrays": "lift_lab.utils.array",
                "Buffers": "lift_lab.utils.buffers",
                "Interpolation": "lift_lab.utils.interpolation",
                "Data sets": "lift_lab.utils.datasets",
                "Files": "lift_lab.utils.io",
                "Assets": "lift_lab.utils.assets",
                "Timer": "lift_lab.utils.timer",
                "Random numbers": "lift_lab.utils.seed",
                "Types": "lift_lab.utils.types",
                "Errors": "lift_lab.utils.errors",
                "Checks of parameters": "lift_lab.utils.ranges",
                "Indices": "lift_lab.utils.indexing",
                "Cached values of a step": "lift_lab.utils.step_cache",
                "Saved state": "lift_lab.utils.saved_state",
                "Debug visualisation": "lift_lab.utils.debug_vis",
                "Command lines": "lift_lab.app",
                "Visualisers": "lift_lab.visualizers",
            },
        ),
    ],
}
