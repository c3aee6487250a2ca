"""A run's own account of itself is read back from its folder."""

from lift_lab_rl.run_params import read_params, write_params


def test_what_a_run_wrote_is_read_and_a_folder_without_says_nothing(tmp_path):
    write_params(tmp_path / "run", "Cartpole", {"a": 1}, {"seed": 2}, ("env.a=1",))
    assert {path.name for path in (tmp_path / "run" / "params").iterdir()} == {"env.yaml", "agent.yaml", "run.yaml"}
    assert read_params(tmp_path / "run", "env") == {"a": 1}
    assert read_params(tmp_path / "run", "agent") == {"seed": 2}
    assert read_params(tmp_path / "run", "run") == {"task": "Cartpole", "overrides": ["env.a=1"]}
    assert read_params(tmp_path / "other", "run") == {}
    write_params(tmp_path / "next", "Cartpole", {}, {}, (), tmp_path / "run" / "model_5.pt")
    assert read_params(tmp_path / "next", "run")["continues"] == "run/model_5.pt"
