"""docs/logging.md names every scalar that a training of each library writes, and none that no training writes."""

import re
import runpy
from pathlib import Path
from types import SimpleNamespace

import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from lift_lab.envs import ManagerBasedRLEnv
from lift_lab_rl.evaluation import Episode, Evaluation
from lift_lab_rl.rsl_rl import RslRlEvaluationCfg, RslRlRndCfg, RslRlSymmetryCfg, RslRlVecEnvWrapper, to_rsl_rl
from lift_lab_rl.rsl_rl.runner import LiftLabRunner
from lift_lab_rl.rsl_rl.training_evaluation import TrainingEvaluation
from lift_lab_rl.scalar_names import GROUPS, SB3_NAMES, SKRL_NAMES
from lift_lab_rl.study.curves import read_scalars
from lift_lab_tasks.manager_based.classic.cartpole.cartpole_env_cfg import CartpoleEnvCfg
from lift_lab_tasks.utils.parse_cfg import load_cfg_from_registry

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "logging.md").read_text(encoding="utf-8")
POINTS = runpy.run_path(str(ROOT / "tests" / "lift_lab_rl" / "point_task.py"))


def rows(section, columns):
    """First cell without its marks and last cell of the rows of tables with so many columns."""
    found = []
    for line in section.splitlines():
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        if len(cells) == columns and cells[0].startswith("`"):
            found.append((cells[0].strip("`"), cells[-1]))
    return found


SCALARS = PAGE.split("## Scalars")[1].split("## Names in")[0]
DOCUMENTED = {tag: set(libraries.split(", ")) for tag, libraries in rows(SCALARS, 5)}


def row_of(tag):
    """The documented tag or pattern that a scalar belongs to; an exact name goes before a pattern."""
    if tag in DOCUMENTED:
        return tag
    for pattern in DOCUMENTED:
        if "<" in pattern and re.fullmatch(re.sub(r"<\w+>", r"[\\w.-]+", pattern), tag):
            return pattern
    return None


def block(word):
    """The Python example of the page that has a word in it."""
    (text,) = [code for code in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL) if word in code]
    return text


@pytest.fixture(scope="module")
def poles():
    """Four cart-poles with the metrics of the page and a curriculum that returns two numbers."""
    from lift_lab.managers import CurriculumTermCfg
    from lift_lab.utils import configclass

    names = {"__name__": "page"}
    exec(block("class MetricsCfg"), names)

    @configclass
    class Curricula:
        weights = CurriculumTermCfg(func=lambda env, env_ids: {"first": 1.0, "second": 2.0})
        stage = CurriculumTermCfg(func=lambda env, env_ids: 1.0)

    cfg = CartpoleEnvCfg()
    success = cfg.metrics.success
    cfg.metrics, cfg.curriculum = names["MetricsCfg"](), Curricula()
    cfg.metrics.success = success
    cfg.scene.num_envs, cfg.episode_length_s, cfg.sim.device, cfg.seed = 4, 0.1, "cpu", 1
    env = ManagerBasedRLEnv(cfg)
    yield env
    env.close()


@pytest.fixture(scope="module")
def written(poles, tmp_path_factory):
    """Scalars that short trainings write, by library."""
    folder = tmp_path_factory.mktemp("runs")
    threads = torch.get_num_threads()
    rsl_rl(poles, folder / "rsl_rl")
    tags = {"rsl_rl": read_scalars(folder / "rsl_rl") | evaluated()}
    for k, change in enumerate((curious, mirrored)):
        cfg = POINTS["AgentCfg"]()
        change(cfg)
        LiftLabRunner(Points(), to_rsl_rl(cfg), log_dir=folder / f"points{k}").learn(3)
        tags["rsl_rl"] |= read_scalars(folder / f"points{k}")
    for library, train in (("sb3", sb3), ("skrl", skrl)):
        pytest.importorskip({"sb3": "stable_baselines3"}.get(library, library))
        train(poles, folder / library)
        tags[library] = read_scalars(folder / library)
    torch.set_num_threads(threads)
    return SimpleNamespace(folder=folder, tags=tags)


def evaluated():
    """Scalars of an evaluation during a training."""
    cfg = RslRlEvaluationCfg(from_success=None, max_share=1.0, episodes=1, consecutive=1).to_dict()
    policy = SimpleNamespace(get_policy=lambda: torch.nn.Identity())
    evaluation = TrainingEvaluation(cfg, policy, Points(), None, 20)
    found = Evaluation(0.02, [Episode(1.0, 20, 1, "time_out")], {"Metrics/some": 1.0, "Metrics/physics/overflow": 0.0})
    evaluation._evaluate = lambda: found
    return evaluation.after_iteration(1, 20, None).scalars


class Points(POINTS["PointEnv"]):
    """Logs an entry without a slash, too."""

    def step(self, actions):
        obs, reward, done, extras = super().step(actions)
        extras["log"] |= {"plain": 1.0} if extras["log"] else {}
        return obs, reward, done, extras


def curious(cfg):
    cfg.algorithm.rnd_cfg = RslRlRndCfg(weight=1.0, num_outputs=4)
    cfg.obs_groups = {"policy": ["policy"], "rnd_state": ["policy"]}


def mirrored(cfg):
    cfg.algorithm.symmetry_cfg = RslRlSymmetryCfg(data_augmentation_func=mirror, use_mirror_loss=True)


def mirror(env, obs, actions, **_):
    """Points and their mirror images."""
    if obs is not None:
        other = obs.clone()
        other["policy"] = obs["policy"] * torch.tensor([-1.0, 1.0])
        obs = torch.cat([obs, other])
    return obs, None if actions is None else torch.cat([actions, -actions])


def rsl_rl(env, folder):
    cfg = POINTS["AgentCfg"]()
    LiftLabRunner(RslRlVecEnvWrapper(env), to_rsl_rl(cfg), log_dir=folder).learn(2)


def sb3(env, folder):
    from lift_lab_rl.sb3 import LogCallback, Sb3VecEnvWrapper
    from lift_lab_rl.sb3_runs import build, log_to

    cfg = load_cfg_from_registry("Cartpole", "sb3_cfg_entry_point")
    cfg |= {"n_steps": 8, "n_timesteps": 64, "clip_range_vf": 0.2, "device": "cpu"}
    agent, _, timesteps = build(Sb3VecEnvWrapper(env), cfg)
    log_to(agent, folder)
    agent.learn(timesteps, callback=[LogCallback()], log_interval=1)
    agent.logger.close()


def skrl(env, folder):
    from lift_lab_rl.skrl import SkrlVecEnvWrapper
    from lift_lab_rl.skrl_runs import make_runner

    cfg = load_cfg_from_registry("Cartpole", "skrl_cfg_entry_point")
    cfg["agent"] |= {"rollouts": 8, "entropy_loss_scale": 0.01}
    cfg["agent"]["experiment"] |= {"directory": str(folder.parent), "experiment_name": folder.name}
    cfg["agent"]["experiment"] |= {"write_interval": 8, "checkpoint_interval": 0}
    cfg["trainer"] |= {"timesteps": 24, "close_environment_at_exit": False, "disable_progressbar": True}
    make_runner(SkrlVecEnvWrapper(env), cfg).run()


def test_every_scalar_that_a_library_writes_is_on_the_page(written):
    for library, tags in written.tags.items():
        unknown = [tag for tag in tags if library not in DOCUMENTED.get(row_of(tag) or "", ())]
        assert not unknown, (library, unknown)


def test_every_scalar_on_the_page_is_written_by_the_libraries_it_names(written):
    hit = {library: {row_of(tag) for tag in tags} for library, tags in written.tags.items()}
    named = {library: {tag for tag, names in DOCUMENTED.items() if library in names} for library in hit}
    assert hit == named


def test_a_group_of_scalars_has_a_title_and_a_place_in_the_order():
    assert {tag.partition("/")[0] for tag in DOCUMENTED} == set(GROUPS)


def test_the_metrics_of_the_lift_tasks_are_those_of_the_page():
    from lift_lab_tasks.manager_based.manipulation.lift.lift_env_cfg import MetricsCfg

    own = {f"Metrics/{term.log_as}" for term in vars(MetricsCfg()).values() if term.log_as != "success_rate"}
    of_command = {f"Metrics/object_pose/{name}" for name in ("position_error", "orientation_error")}
    assert {tag for tag, _ in rows(SCALARS, 4)} == own | of_command


def test_the_pages_names_of_other_libraries_are_those_that_are_renamed():
    table = PAGE.split("## Names in")[1].split("## Read")[0]
    for line in table.splitlines():
        cells = re.findall(r"`([^`]*)`|\|", line)
        if not line.startswith("| `"):
            continue
        here, sb3_name, skrl_name = (re.search(r"`(.*?)`", cell) for cell in line.split("|")[1:4])
        for name, known in ((sb3_name, SB3_NAMES), (skrl_name, SKRL_NAMES)):
            assert name is None or known[name[1]][0] == here[1], cells


@pytest.mark.parametrize("library", ["rsl_rl", "sb3", "skrl"])
def test_a_run_tells_tensorboard_to_show_success_first(written, library):
    from tensorboard.plugins.custom_scalar.layout_pb2 import Layout

    events = EventAccumulator(str(written.folder / library))
    events.Reload()
    (tensor,) = events.Tensors("custom_scalars__config__")
    layout = Layout.FromString(tensor.tensor_proto.string_val[0])
    first = layout.category[0].chart[0]
    assert [re.fullmatch(tag, "Metrics/success_rate") is not None for tag in first.multiline.tag] == [True]
    patterns = [tag for category in layout.category for chart in category.chart for tag in chart.multiline.tag]
    assert all(any(re.match(p, tag) for p in patterns) for tag in written.tags[library])


def test_both_ways_to_read_scalars_give_all_points(written):
    names = {"folder": str(written.folder / "rsl_rl")}
    exec(block("EventAccumulator"), names)
    exec(block("read_scalars"), names)
    assert [step for step, _ in names["success"]] == names["steps"].tolist() == [1, 2]
    assert [value for _, value in names["success"]] == names["values"].tolist()


@pytest.mark.parametrize("library", ["rsl_rl", "sb3", "skrl"])
def test_the_pages_metric_is_in_the_log(written, library):
    assert {"Metrics/cart_distance_m", "Metrics/cart/error"} <= set(written.tags[library])
