"""Configuration of the simulation: time step, engine and solver."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

from lift_lab.utils import ConfigBase, configclass
from lift_lab.utils.ranges import (
    COUNT,
    COUNT_OR_ZERO,
    FINITE,
    INT32_COUNT,
    NOT_NEGATIVE,
    POSITIVE,
    Choices,
    Range,
    Ranges,
)

from .engines import engine_names
from .spawners.materials import RigidBodyMaterialCfg

__all__ = ["MujocoCfg", "PhysxCfg", "RenderCfg", "SimulationCfg"]


@configclass
class PhysxCfg(ConfigBase):
    """PhysX solver settings. Kept so that Isaac Lab task files run; every value set is reported as ignored."""

    solver_type: Literal[0, 1] = 1
    solve_articulation_contact_last: bool = False
    min_position_iteration_count: int = 1
    max_position_iteration_count: int = 255
    min_velocity_iteration_count: int = 0
    max_velocity_iteration_count: int = 255
    enable_ccd: bool = False
    enable_stabilization: bool = False
    enable_external_forces_every_iteration: bool = False
    enable_enhanced_determinism: bool = False
    bounce_threshold_velocity: float = 0.5
    friction_offset_threshold: float = 0.04
    friction_correlation_distance: float = 0.025
    gpu_max_rigid_contact_count: int = 2**23
    gpu_max_rigid_patch_count: int = 5 * 2**15
    gpu_found_lost_pairs_capacity: int = 2**21
    gpu_found_lost_aggregate_pairs_capacity: int = 2**25
    gpu_total_aggregate_pairs_capacity: int = 2**21
    gpu_collision_stack_size: int = 2**26
    gpu_heap_capacity: int = 2**26
    gpu_temp_buffer_capacity: int = 2**24
    gpu_max_num_partitions: int = 8
    gpu_max_soft_body_contacts: int = 2**20
    gpu_max_particle_contacts: int = 2**20

    _ranges: ClassVar[Ranges] = {
        (
            "min_position_iteration_count max_position_iteration_count "
            "min_velocity_iteration_count max_velocity_iteration_count "
            "gpu_max_rigid_contact_count gpu_max_rigid_patch_count "
            "gpu_found_lost_pairs_capacity gpu_found_lost_aggregate_pairs_capacity "
            "gpu_total_aggregate_pairs_capacity gpu_collision_stack_size gpu_heap_capacity "
            "gpu_temp_buffer_capacity gpu_max_num_partitions gpu_max_soft_body_contacts "
            "gpu_max_particle_contacts"
        ): COUNT_OR_ZERO,
        "bounce_threshold_velocity friction_offset_threshold friction_correlation_distance": NOT_NEGATIVE,
    }


@configclass
class RenderCfg(ConfigBase):
    """Omniverse renderer settings. Kept so that Isaac Lab task files run; every value set is reported as ignored."""

    enable_translucency: bool | None = None
    enable_reflections: bool | None = None
    enable_global_illumination: bool | None = None
    antialiasing_mode: Literal["Off", "FXAA", "DLSS", "TAA", "DLAA"] | None = None
    enable_dlssg: bool | None = None
    enable_dl_denoiser: bool | None = None
    dlss_mode: Literal[0, 1, 2, 3] | None = None
    enable_direct_lighting: bool | None = None
    samples_per_pixel: int | None = None
    enable_shadows: bool | None = None
    enable_ambient_occlusion: bool | None = None
    dome_light_upper_lower_strategy: Literal[0, 3, 4] | None = None
    carb_settings: dict[str, Any] | None = None
    rendering_mode: Literal["performance", "balanced", "quality"] | None = None

    _ranges: ClassVar[Ranges] = {"samples_per_pixel": COUNT}


@configclass
class MujocoCfg(ConfigBase):
    """MuJoCo's own options (``mjOption``). A None keeps MuJoCo's default."""

    integrator: Literal["Euler", "RK4", "implicit", "implicitfast", "discrete"] = "implicitfast"
    """Integrator. ``implicitfast`` treats actuator and joint damping implicitly, as PhysX drives are; ``discrete``
    treats stiffness so too, and deformable objects need it."""
    cone: Literal["pyramidal", "elliptic"] = "pyramidal"
    """Friction cone."""
    impratio: float = 1.0
    """Ratio of frictional to normal constraint impedance."""
    solver: Literal["PGS", "CG", "Newton"] = "Newton"
    """Constraint solver (the warp engine has CG and Newton)."""
    iterations: int = 10
    """Most solver iterations a step."""
    ls_iterations: int = 20
    """Most line-search iterations a solver iteration."""
    tolerance: float | None = None
    """Solver tolerance at which iterations end early. None: MuJoCo's 1e-8, and 1e-6 on the warp engine, whose float32
    allows no less: a smaller value is an error there."""
    eulerdamp: bool = True
    """Whether the Euler integrator treats joint damping implicitly."""
    island: bool = True
    """Whether constraints that share no moving body are solved separately. This is faster where many bodies touch, and
    slower where all contacts belong to one group. The warp engine never does."""
    warmstart: bool = True
    """Whether the solver starts from the accelerations of the last step. The solution is the same up to the solver's
    tolerance. Where contacts change from step to step, a fresh start can be faster (docs/performance.md)."""
    nconmax: int | None = None
    """Contacts an environment may have at once on the warp engine; None sizes it from the model."""
    njmax: int | None = None
    """Constraint rows an environment may have at once on the warp engine; None sizes it from the model."""

    _ranges: ClassVar[Ranges] = {
        "impratio": POSITIVE,
        "iterations ls_iterations nconmax njmax": INT32_COUNT,
        "tolerance": NOT_NEGATIVE,
    }


@configclass
class SimulationCfg(ConfigBase):
    """Configuration of the simulation, with Isaac Lab's names; :attr:`mujoco` and :attr:`physics` are ours."""

    physics_prim_path: str = "/physicsScene"
    """Isaac Lab's prim path of the physics scene. A label here."""
    device: str = "auto"
    """Torch device of every tensor: ``"cpu"``, ``"cuda:N"``, or ``"auto"`` (a GPU where there is one)."""
    physics: str | None = None
    """Engine: ``native`` (MuJoCo on CPU threads), ``warp`` (mujoco-warp) or one that a package adds
    (:mod:`lift_lab.sim.engines`). None: native on cpu, warp on cuda."""
    num_threads: int | None = None
    """Threads of the native engine's pool. None uses every CPU this process may run on."""
    dt: float = 1.0 / 60.0
    """Physics step in seconds."""
    render_interval: int = 1
    """Physics steps between two rendered frames (Isaac Lab). Frames here are drawn on request."""
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    """Gravity in the world frame in m/s^2."""
    mujoco: MujocoCfg = MujocoCfg()
    """MuJoCo options."""
    enable_scene_query_support: bool = False
    use_fabric: bool = True
    physx: PhysxCfg = PhysxCfg()
    """PhysX settings: accepted and reported as ignored."""
    physics_material: RigidBodyMaterialCfg = RigidBodyMaterialCfg()
    """Isaac Lab's material of shapes that have none: accepted and reported as ignored. Here those have MuJoCo's
    friction of 1, ground planes that of their own material."""
    render: RenderCfg = RenderCfg()
    """Renderer settings: accepted and reported as ignored."""
    create_stage_in_memory: bool = False
    logging_level: Literal["DEBUG", "INFO", "WARNING", "ERROR", "CRITICAL"] = "WARNING"
    save_logs_to_file: bool = True
    log_dir: str | None = None

    _ranges: ClassVar[Ranges] = {
        "physics": Choices(engine_names),
        "num_threads render_interval": COUNT,
        "dt": Range(1e-9),
        "gravity": FINITE,
    }
