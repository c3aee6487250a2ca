"""What the warp engine promises about speed, checked on warp's CPU device: few graphs, nothing read back."""

from __future__ import annotations

import logging
from collections.abc import Callable

import mujoco
import pytest
import torch

from lift_lab.sim.physics import Physics, make_physics

warp = pytest.importorskip("warp")


@pytest.fixture(scope="module")
def physics(make: Callable[..., Physics]) -> Physics:
    """An engine of its own: these tests count its graphs and randomise its model."""
    engine = make("warp-cpu")
    for name in ("qpos", "xpos", "cvel", "qacc", "sensordata"):
        engine.field(name)
    return engine


@pytest.fixture
def read_backs(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the calls that bring a value to the host or wait for the device."""
    seen: list[str] = []

    def note(owner: object, name: str) -> None:
        original = getattr(owner, name)

        def call(*args, **kwargs):
            seen.append(name)
            return original(*args, **kwargs)

        monkeypatch.setattr(owner, name, call)

    for name in ("item", "tolist", "cpu", "numpy", "nonzero", "__bool__", "__int__", "__float__", "__index__"):
        note(torch.Tensor, name)
    for owner, name in ((warp.array, "numpy"), (warp.array, "list"), (warp, "synchronize"), (torch, "nonzero")):
        note(owner, name)
    for name in ("synchronize_device", "synchronize_stream"):
        note(warp, name)
    return seen


def use(engine: Physics, envs: torch.Tensor) -> None:
    """What an environment step asks of an engine."""
    engine.write("ctrl", 0.03)
    engine.step(4)
    engine.health()
    engine.reset(envs)
    engine.write("qpos", 0.05, env_ids=envs, cols=slice(2, 3))
    engine.refresh(envs)


def test_a_step_reads_nothing_back(physics: Physics, read_backs: list[str]):
    envs = torch.tensor([1, 3])
    use(physics, envs)
    read_backs.clear()
    use(physics, envs)
    assert read_backs == []


def test_all_substeps_and_the_refresh_are_one_graph_and_each_call_keeps_its_own(physics: Physics, monkeypatch):
    launched = []
    launch = warp.capture_launch
    monkeypatch.setattr(warp, "capture_launch", lambda graph, stream=None: (launched.append(graph), launch(graph)))
    envs = torch.tensor([0])
    use(physics, envs)
    captured = dict(physics._graphs)
    launched.clear()
    physics.step(4)
    assert len(launched) == 1
    for _ in range(3):
        use(physics, envs)
    assert physics._graphs == captured


def test_a_field_is_expanded_once_and_then_written_without_another_capture(make: Callable[..., Physics]):
    engine = make("warp-cpu")
    mass = engine.randomizable("body_mass")
    envs = torch.tensor([2])
    for scale in (1.0, 2.0):  # the first time compiles and captures
        mass[:, 1] = scale
        engine.recompute_constants()
        use(engine, envs)
    captured = dict(engine._graphs)
    before = engine.randomizable("body_mass").data_ptr()
    for scale in (3.0, 4.0):
        engine.randomizable("body_mass")[:, 1] = scale
        engine.recompute_constants()
        use(engine, envs)
    assert engine._graphs == captured
    assert engine.randomizable("body_mass").data_ptr() == before


def test_constants_from_a_graph_are_those_that_mujoco_derives(make: Callable[..., Physics], model: mujoco.MjModel):
    engine = make("warp-cpu", num_envs=2)
    for scale in (1.0, 3.0, 5.0):  # eager, captured, replayed
        engine.randomizable("body_mass")[1, 1] = scale
        engine.recompute_constants()
        own = model.__copy__()
        own.body_mass[1] = scale
        mujoco.mj_setConst(own, mujoco.MjData(own))
        for name in ("dof_invweight0", "body_subtreemass"):
            derived = warp.to_torch(getattr(engine._m, name))[1]
            expected = torch.tensor(getattr(own, name), dtype=torch.float32)
            if name.startswith("dof"):
                # MuJoCo weighs a body that only slides on the world as 1 / mass, without its armature
                derived, expected = derived[:13], expected[:13]
            torch.testing.assert_close(derived, expected, atol=1e-5, rtol=1e-4)


def test_a_first_compile_is_announced_once_and_a_cached_one_not(model: mujoco.MjModel, caplog, monkeypatch):
    from lift_lab.sim.physics.warp_kernels import say_when_compiling

    with caplog.at_level(logging.WARNING):
        with say_when_compiling(warp.get_device("cpu")):
            for outcome in ("(cached)", "(compiled)", "(compiled)"):
                warp.get_logger().info(f"Module a load on device 'cpu' took 3.00 ms  {outcome}")
        assert [record.getMessage().partition(":")[0] for record in caplog.records] == [
            "compiling MuJoCo-Warp kernels for cpu"
        ]
        assert warp.config.log_level >= warp.LOG_WARNING
        caplog.clear()
        make_physics(model, 4, kind="warp")  # all its kernels are in the cache by now
    assert not caplog.records


@pytest.mark.parametrize("arch", [75, 90])
def test_our_own_kernels_compile_for_gpus_on_a_machine_without_one(arch: int, tmp_path):
    """75 is the oldest architecture that warp compiles for, 90 that of an H100 or H200."""
    from lift_lab.sim.physics import warp_kernels

    warp.init()
    if arch not in warp.get_cuda_supported_archs():
        pytest.skip("this warp compiles nothing for CUDA")
    warp.compile_aot_module(warp_kernels, arch=arch, module_dir=tmp_path, use_ptx=True)
    (code,) = tmp_path.glob(f"*.sm{arch}.ptx")
    names = {name for name, kernel in vars(warp_kernels).items() if isinstance(kernel, warp.Kernel)}
    assert names
    assert all(f"{name}_" in code.read_text() for name in names)
