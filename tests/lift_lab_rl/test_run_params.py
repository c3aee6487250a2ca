"""A run's own account of itself is read back from its folder."""

from lift_lab_rl.run_params import read_params
from lift_lab_rl.script_steps import write_configurations


def test_what_a_run_wrote_is_read_and_a_folder_without_says_nothing(tmp_path):
    write_configurations(tmp_path / "run", "Cartpole", {"a": 1}, {"seed": 2}, ("env.a=1",))
    assert read_params(tmp_path / "run", "env") == {"a": 1}
    assert read_params(tmp_path / "run", "agent") == {"seed": 2}
    assert read_params(tmp_path / "run", "run") == {"task": "Cartpole", "overrides": ["env.a=1"]}
    assert read_params(tmp_path / "other", "run") == {}
