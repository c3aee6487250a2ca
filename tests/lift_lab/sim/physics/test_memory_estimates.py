"""Environments that cannot fit into memory are refused, and those that fit are not."""

import mujoco
import pytest

from lift_lab.sim.physics import make_physics, memory
from lift_lab.utils.errors import ConfigError

CHAIN = """<mujoco><worldbody><body><joint/><geom size=".1"/><body pos=".3 0 0"><joint/><geom size=".1"/></body></body>
</worldbody></mujoco>"""


@pytest.fixture
def model():
    return mujoco.MjModel.from_xml_string(CHAIN)


@pytest.mark.parametrize("kind", ["native", "warp"])
def test_what_needs_more_than_the_free_memory_is_refused(model, kind, monkeypatch):
    monkeypatch.setattr(memory, "free_bytes", lambda device: 100_000)
    with pytest.raises(ConfigError, match=r"scene.num_envs is 500: .* cpu has .* GiB free; at most \d+ fit"):
        make_physics(model, 500, "cpu", kind)


@pytest.mark.parametrize("kind", ["native", "warp"])
def test_the_number_that_is_said_to_fit_is_accepted(model, kind, monkeypatch):
    monkeypatch.setattr(memory, "free_bytes", lambda device: 300_000)
    with pytest.raises(ConfigError) as caught:
        make_physics(model, 500, "cpu", kind)
    fits = int(str(caught.value).rpartition("at most ")[2].split()[0])
    assert 0 < fits < 500
    assert make_physics(model, fits, "cpu", kind).num_envs == fits
    with pytest.raises(ConfigError):
        make_physics(model, fits + 1, "cpu", kind)


def test_the_limit_of_a_container_counts(tmp_path, monkeypatch):
    monkeypatch.setattr(memory, "_CGROUP", tmp_path)
    (tmp_path / "memory.max").write_text("5000000\n")
    (tmp_path / "memory.current").write_text("4000000\n")
    assert memory.free_bytes("cpu") == 1_000_000
    (tmp_path / "memory.max").write_text("max\n")
    assert memory.free_bytes("cpu") > 10_000_000


def test_nothing_is_refused_where_the_system_does_not_tell(monkeypatch):
    monkeypatch.setattr(memory, "free_bytes", lambda device: None)
    memory.check_fits("scene.num_envs", 10**15, 1024, "cpu")
