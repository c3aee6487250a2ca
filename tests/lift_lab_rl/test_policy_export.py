"""An exported policy acts like the policy that it was made from, and one that would act otherwise is an error."""

from pathlib import Path

import pytest
import torch
from point_task import AgentCfg, PointEnv, train
from tensordict import TensorDict

from lift_lab_rl.rsl_rl import (
    LiftLabRunner,
    RslRlPpoActorCriticRecurrentCfg,
    export_policy_as_jit,
    export_policy_as_onnx,
    to_rsl_rl,
)
from lift_lab_rl.rsl_rl.exporter import ExportError, check_export


def test_exported_policies_act_like_the_policy_and_bring_its_normaliser(tmp_path):
    runner, _ = train(None, iterations=2)
    policy = runner.get_inference_policy()
    obs = torch.randn(3, 2) * 5.0
    with torch.no_grad():
        expected = policy(TensorDict({"policy": obs}, batch_size=[3]))
    scripted = torch.jit.load(export_policy_as_jit(policy, None, tmp_path))
    torch.testing.assert_close(scripted(obs), expected)
    onnx = pytest.importorskip("onnxruntime")
    session = onnx.InferenceSession(str(export_policy_as_onnx(policy, tmp_path)))
    for row, action in zip(obs, expected, strict=True):
        found = torch.as_tensor(session.run(["actions"], {"obs": row[None].numpy()})[0])
        torch.testing.assert_close(found[0], action, atol=1e-5, rtol=1e-4)
    assert {f.name for f in tmp_path.iterdir()} == {"policy.pt", "policy.onnx"}
    # torch notes the folders of this machine's packages at every node
    assert str(Path(torch.__file__).parents[1]).encode() not in (tmp_path / "policy.onnx").read_bytes()


def test_an_export_that_acts_otherwise_is_an_error():
    runner, _ = train(None, iterations=1)
    policy = runner.get_inference_policy()
    model = policy.as_jit().eval()
    check_export("ONNX", policy, None, model)
    with pytest.raises(ExportError, match="differs"):
        check_export("ONNX", policy, None, lambda obs: model(obs) + 0.01)


@pytest.mark.parametrize("kind", ["gru", "lstm"])
def test_the_memory_of_an_exported_policy_is_compared_too(tmp_path, kind):
    cfg = AgentCfg()
    settings = {k: v for k, v in vars(cfg.policy).items() if k != "class_name"}
    cfg.policy = RslRlPpoActorCriticRecurrentCfg(**settings, rnn_type=kind, rnn_hidden_dim=6, rnn_num_layers=1)
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    policy = runner.alg.get_policy()
    assert export_policy_as_onnx(policy, tmp_path).is_file()
    scripted = torch.jit.load(export_policy_as_jit(policy, None, tmp_path))

    def forgetful(obs):
        scripted.reset()
        return scripted(obs)

    with pytest.raises(ExportError, match="differs"):
        check_export("TorchScript", policy, None, forgetful)
