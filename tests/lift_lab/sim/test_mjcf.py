"""A scene as MJCF is the model that the simulation runs."""

import mujoco
import numpy as np
import pytest

import lift_lab.sim as sim_utils
from lift_lab.assets import ArticulationCfg, AssetBaseCfg, RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import FileError, PhysicsError
from lift_lab_assets import CARTPOLE_CFG


@configclass
class SceneCfg(InteractiveSceneCfg):
    robot: ArticulationCfg = CARTPOLE_CFG.replace(
        prim_path="{ENV_REGEX_NS}/Robot",
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={"slider_to_cart": 0.5, "cart_to_pole": -0.25}),
    )
    box = RigidObjectCfg(
        prim_path="{ENV_REGEX_NS}/Box",
        init_state=RigidObjectCfg.InitialStateCfg(pos=(1.0, 2.0, 0.5)),
        spawn=sim_utils.CuboidCfg(
            size=(0.2, 0.2, 0.2),
            rigid_props=sim_utils.RigidBodyPropertiesCfg(),
            mass_props=sim_utils.MassPropertiesCfg(mass=0.7),
            collision_props=sim_utils.CollisionPropertiesCfg(),
        ),
    )
    ground = AssetBaseCfg(prim_path="/World/Ground", spawn=sim_utils.GroundPlaneCfg())


@pytest.fixture(params=["native", "warp"])
def sim(request):
    cfg = sim_utils.SimulationCfg(device="cpu", dt=0.004, physics=request.param)
    cfg.mujoco.integrator, cfg.mujoco.iterations = "implicitfast", 7
    simulation = sim_utils.SimulationContext(cfg)
    InteractiveScene(SceneCfg(num_envs=2, env_spacing=3.0))
    yield simulation
    simulation.close()


def test_plain_mujoco_loads_the_model_and_its_initial_state(sim, tmp_path):
    with pytest.raises(PhysicsError, match=r"call sim\.reset"):
        sim.export_mjcf(tmp_path / "scene.xml")
    sim.reset()
    sim.step()
    (path,) = sim.export_mjcf(tmp_path / "new" / "scene.xml")
    model = mujoco.MjModel.from_xml_path(str(path))
    for field in ("body_mass", "body_inertia", "jnt_range", "geom_size", "actuator_gainprm", "actuator_biasprm"):
        np.testing.assert_allclose(getattr(model, field), getattr(sim.model, field), atol=1e-5)
    assert (model.opt.timestep, model.opt.iterations) == (0.004, 7)
    assert model.opt.integrator == int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("initial").id)
    assert data.joint("robot/slider_to_cart").qpos == pytest.approx([0.5])
    assert data.joint("robot/cart_to_pole").qpos == pytest.approx([-0.25])
    mujoco.mj_kinematics(model, data)
    (box,) = (model.body(i).name for i in range(model.nbody) if model.body(i).name.startswith("box/"))
    assert data.body(box).xpos == pytest.approx([1.0, 2.0, 0.5])


def test_a_folder_that_cannot_be_made_is_an_error(sim, tmp_path):
    sim.reset()
    (tmp_path / "file").write_text("")
    with pytest.raises((FileError, OSError)):
        sim.export_mjcf(tmp_path / "file" / "scene.xml")
