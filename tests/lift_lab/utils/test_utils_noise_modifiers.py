"""Noise and modifiers."""

import pytest
import torch
from scipy import signal

from lift_lab.utils import modifiers, noise


@pytest.fixture(autouse=True)
def _seed():
    torch.manual_seed(0)


@pytest.mark.parametrize(("operation", "expected"), [("add", 5.0), ("scale", 6.0), ("abs", 3.0)])
def test_an_operation_says_what_noise_does_to_the_data(operation, expected):
    cfg = noise.ConstantNoiseCfg(bias=3.0, operation=operation)
    assert torch.equal(cfg.func(torch.full((4, 2), 2.0), cfg), torch.full((4, 2), expected))


def test_an_unknown_operation_is_refused():
    cfg = noise.ConstantNoiseCfg(operation="ad")
    with pytest.raises(ValueError, match="unknown noise operation 'ad'; did you mean 'add'"):
        cfg.func(torch.zeros(1), cfg)


def test_uniform_noise_stays_in_its_range_for_each_component():
    cfg = noise.AdditiveUniformNoiseCfg(n_min=torch.tensor([-1.0, 10.0]), n_max=torch.tensor([1.0, 20.0]))
    noisy = cfg.func(torch.zeros(5000, 2), cfg)
    torch.testing.assert_close(noisy.min(dim=0).values, torch.tensor([-1.0, 10.0]), atol=0.01, rtol=0)
    torch.testing.assert_close(noisy.max(dim=0).values, torch.tensor([1.0, 20.0]), atol=0.01, rtol=0)


def test_gaussian_noise_has_its_mean_and_deviation():
    cfg = noise.AdditiveGaussianNoiseCfg(mean=2.0, std=0.5)
    noisy = cfg.func(torch.ones(20000, 1), cfg)
    assert float(noisy.mean()) == pytest.approx(3.0, abs=0.02)
    assert float(noisy.std()) == pytest.approx(0.5, abs=0.02)


def test_noise_leaves_its_input_untouched():
    data = torch.zeros(3, 2)
    cfg = noise.GaussianNoiseCfg()
    cfg.func(data, cfg)
    assert torch.equal(data, torch.zeros(3, 2))


@pytest.mark.parametrize("per_component", [True, False])
def test_a_bias_stays_until_the_reset_of_its_environment(per_component):
    cfg = noise.NoiseModelWithAdditiveBiasCfg(
        noise_cfg=noise.ConstantNoiseCfg(bias=0.0),
        bias_noise_cfg=noise.UniformNoiseCfg(n_min=1.0, n_max=2.0, operation="abs"),
        sample_bias_per_component=per_component,
    )
    model = cfg.class_type(cfg, num_envs=3, device="cpu")
    model.reset()
    first = model(torch.zeros(3, 4))
    assert torch.equal(model(torch.zeros(3, 4)), first)
    assert bool(((first >= 1.0) & (first < 2.0)).all())
    assert (len(first[0].unique()) == 4) is per_component
    model.reset([1])
    second = model(torch.zeros(3, 4))
    assert torch.equal(second[[0, 2]], first[[0, 2]])
    assert not torch.equal(second[1], first[1])


def test_a_noise_model_without_state_draws_at_every_call():
    cfg = noise.NoiseModelCfg(noise_cfg=noise.GaussianNoiseCfg())
    model = cfg.class_type(cfg, num_envs=2, device="cpu")
    model.reset([0])
    assert not torch.equal(model(torch.zeros(2, 3)), model(torch.zeros(2, 3)))


def test_function_modifiers_scale_clip_and_shift():
    data = torch.tensor([-2.0, 0.0, 2.0])
    assert modifiers.scale(data, 2.0).tolist() == [-4.0, 0.0, 4.0]
    assert modifiers.bias(data, 1.0).tolist() == [-1.0, 1.0, 3.0]
    cfg = modifiers.ModifierCfg(func=modifiers.clip, params={"bounds": (None, 1.0)})
    assert cfg.func(data, **cfg.params).tolist() == [-2.0, 0.0, 1.0]
    assert modifiers.clip(data, (None, None)).tolist() == data.tolist()


def test_the_digital_filter_is_the_difference_equation():
    a, b = [-0.5, 0.1], [0.2, 0.3, 0.4]
    cfg = modifiers.DigitalFilterCfg(A=a, B=b)
    filtering = cfg.func(cfg, (2, 3), "cpu")
    data = torch.randn(20, 2, 3)
    outputs = torch.stack([filtering(x) for x in data])
    expected = signal.lfilter(b, [1.0, *a], data.numpy(), axis=0)
    torch.testing.assert_close(outputs, torch.as_tensor(expected, dtype=torch.float32), atol=1e-5, rtol=0)


def test_a_filter_forgets_on_reset_for_some_environments():
    cfg = modifiers.DigitalFilterCfg(A=[0.0], B=[0.0, 1.0])
    delay = modifiers.DigitalFilter(cfg, (2, 1), "cpu")
    delay(torch.tensor([[1.0], [1.0]]))
    delay.reset([0])
    assert delay(torch.zeros(2, 1)).flatten().tolist() == [0.0, 1.0]


def test_a_filter_without_coefficients_is_refused():
    with pytest.raises(ValueError, match="A and B must be set"):
        modifiers.DigitalFilter(modifiers.DigitalFilterCfg(A=None, B=None), (1,), "cpu")  # type: ignore[arg-type]


def test_the_integrator_sums_trapezia():
    cfg = modifiers.IntegratorCfg(dt=0.1)
    integrate = cfg.func(cfg, (2, 1), "cpu")
    values = [integrate(torch.full((2, 1), x)) for x in (1.0, 3.0, 5.0)]
    assert [float(v[0]) for v in values] == pytest.approx([0.05, 0.25, 0.65])
    integrate.reset([1])
    assert integrate(torch.full((2, 1), 5.0)).flatten().tolist() == pytest.approx([1.15, 0.25])
