"""A contact sensor whose body has more contacts than it has room for says so; with room for all, all count."""

import logging

import pytest
import torch

import lift_lab.sim as sim_utils
from lift_lab.assets import AssetBaseCfg, RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sensors import ContactSensorCfg
from lift_lab.utils import configclass

G = 9.81
LOAD = 0.5
"""Mass in kg of each of the boxes that stand on the tray of four times that."""


def _box(name: str, size: tuple[float, float, float], pos: tuple[float, float, float], mass: float) -> RigidObjectCfg:
    return RigidObjectCfg(
        prim_path=f"{{ENV_REGEX_NS}}/{name}",
        init_state=RigidObjectCfg.InitialStateCfg(pos=pos),
        spawn=sim_utils.CuboidCfg(
            size=size,
            rigid_props=sim_utils.RigidBodyPropertiesCfg(),
            mass_props=sim_utils.MassPropertiesCfg(mass=mass),
            collision_props=sim_utils.CollisionPropertiesCfg(),
        ),
    )


def _load(name: str, x: float, y: float) -> RigidObjectCfg:
    return _box(name, (0.08, 0.08, 0.08), (x, y, 0.14), LOAD)


@configclass
class _SceneCfg(InteractiveSceneCfg):
    ground = AssetBaseCfg(prim_path="/World/ground", spawn=sim_utils.GroundPlaneCfg())
    tray = _box("Tray", (0.3, 0.3, 0.1), (0.0, 0.0, 0.05), 4 * LOAD)
    a = _load("A", 0.08, 0.08)
    b = _load("B", -0.08, 0.08)
    c = _load("C", 0.08, -0.08)
    d = _load("D", -0.08, -0.08)
    contact: ContactSensorCfg | None = None


@pytest.mark.parametrize("engine", ["native", "warp"])
@pytest.mark.parametrize("room", [4, 20])
def test_twenty_contacts_carry_five_boxes_where_there_is_room_for_them(engine, room, caplog):
    contact = ContactSensorCfg(
        prim_path="{ENV_REGEX_NS}/Tray",
        filter_prim_paths_expr=["/World/ground", "{ENV_REGEX_NS}/A"],
        max_contact_data_count_per_prim=room,
    )
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(dt=0.005, device="cpu", physics=engine, num_threads=1))
    scene = InteractiveScene(_SceneCfg(num_envs=2, env_spacing=3.0, contact=contact))
    sim.reset()
    with caplog.at_level(logging.WARNING):
        for _ in range(200):
            sim.step()
            scene.update(0.005)
            net = scene["contact"].data.net_forces_w[:, 0, 2]
    pairs = scene["contact"].data.force_matrix_w[:, 0, :, 2]
    sim.close()
    # four contacts with the ground and with each load: pairs have room for eight
    torch.testing.assert_close(pairs, torch.tensor([[8 * LOAD * G, -LOAD * G]]).repeat(2, 1), atol=0.01, rtol=0)
    told = [text for text in caplog.messages if "contacts at once" in text]
    if room == 20:
        torch.testing.assert_close(net, torch.full((2,), 4 * LOAD * G), atol=0.01, rtol=0)
        assert not told
    else:
        assert net[0] > 4.5 * LOAD * G  # a load is missing
        assert len(told) == 1
        assert told[0].startswith("scene.contact: 'tray/Tray' had 20 contacts at once; the strongest 16 of them count.")
        assert told[0].endswith("max_contact_data_count_per_prim=20 counts all")
