"""Command lines that are wrong, and what the one line of their error has to say.

:data:`WRONG_INPUTS` is data. :func:`run` runs one in this process, :func:`problem` says what an answer lacks. A right
answer is exit status 2, one line on standard error that holds every expected word, and no new file.
"""

from __future__ import annotations

import contextlib
import io
import random
import runpy
import sys
from dataclasses import dataclass
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class WrongInput:
    """A command line that has to be refused."""

    script: str
    """Path below ``scripts``."""
    args: tuple[str, ...]
    """Arguments."""
    says: tuple[str, ...]
    """Words that the error has to hold."""

    def __str__(self) -> str:
        return " ".join([self.script, *map(repr, self.args)])


@dataclass(frozen=True)
class Answer:
    """What a script did."""

    status: int | None
    """Exit status; None where an exception left it."""
    error: str
    """Standard error, or the exception."""
    written: tuple[str, ...]
    """New entries of the folder."""


def run(wrong: WrongInput, folder: Path) -> Answer:
    """Run a script in this process.

    Args:
        wrong: the command line.
        folder: current directory while it runs.
    """
    before, argv, path = set(folder.rglob("*")), sys.argv, list(sys.path)
    sys.argv = [wrong.script, *wrong.args]
    sys.path[:0] = [str(SCRIPTS), str((SCRIPTS / wrong.script).parent)]
    error, status = io.StringIO(), None
    try:
        with contextlib.chdir(folder), contextlib.redirect_stderr(error), contextlib.redirect_stdout(io.StringIO()):
            runpy.run_path(str(SCRIPTS / wrong.script), run_name="__main__")
    except SystemExit as ended:
        status = ended.code if isinstance(ended.code, int) else 0 if ended.code is None else 1
    except Exception as left:
        error.write(f"{type(left).__name__}: {left}")
    finally:
        sys.argv, sys.path[:] = argv, path
    written = sorted(str(entry.relative_to(folder)) for entry in set(folder.rglob("*")) - before)
    return Answer(status, error.getvalue(), tuple(written))


def problem(wrong: WrongInput, answer: Answer) -> str | None:
    """What is wrong with an answer, None if nothing is."""
    lines = [line for line in answer.error.splitlines() if line.strip()]
    if answer.status != 2:
        return f"exit status {answer.status}: {' '.join(lines)[-300:]}"
    if len(lines) != 1 or not lines[0].startswith("error: "):
        return f"{len(lines)} lines: {answer.error[:300]}"
    missing = [word for word in wrong.says if word not in lines[0]]
    if missing:
        return f"{missing} not in: {lines[0]}"
    if answer.written:
        return f"written: {', '.join(answer.written[:3])}"
    return None


def shuffled(count: int | None = None, seed: int = 0) -> list[WrongInput]:
    """Some of the wrong inputs in a random order that the seed fixes; None for all."""
    return random.Random(seed).sample(WRONG_INPUTS, len(WRONG_INPUTS) if count is None else count)


##
# The inputs
##

_CARTPOLE = ("--task", "Cartpole", "--device", "cpu", "--num_envs", "4")
_LIFT = ("--task", "Lift-Cube-Franka", "--device", "cpu", "--num_envs", "4")
_PRETRAINED = ("--checkpoint", "pretrained")
_TRAIN, _PLAY, _EVALUATE = "rsl_rl/train.py", "rsl_rl/play.py", "rsl_rl/evaluate.py"

_NUMBERS = {
    "agent.algorithm.gamma": "nan inf -0.1 1.5",
    "agent.algorithm.lam": "nan -0.5 2",
    "agent.algorithm.learning_rate": "nan inf 0 -0.001",
    "agent.algorithm.clip_param": "nan inf 0 -0.2",
    "agent.algorithm.entropy_coef": "nan inf -0.1",
    "agent.algorithm.value_loss_coef": "nan inf -1",
    "agent.algorithm.max_grad_norm": "nan 0 -1",
    "agent.algorithm.desired_kl": "nan 0 -0.01",
    "agent.algorithm.num_learning_epochs": "0 -5",
    "agent.algorithm.num_mini_batches": "0 -4",
    "agent.algorithm.mean_reg_coef": "nan -1",
    "agent.algorithm.advantage_clip": "nan 0",
    "agent.policy.init_noise_std": "nan inf 0 -1",
    "agent.policy.actor_hidden_dims": "[] [0] [32,-1] [null]",
    "agent.policy.critic_hidden_dims": "[] [-8]",
    "agent.policy.noise_std_range": "[-1,2] [nan,1]",
    "agent.num_steps_per_env": "0 -1",
    "agent.max_iterations": "0 -10",
    "agent.save_interval": "0 -1",
    "agent.keep_resume_states": "0 -2",
    "agent.clip_actions": "nan 0 -1",
    "agent.average_share": "nan 1 -0.1",
    "agent.seed": "-2 4294967296",
    "agent.num_threads": "0 -1",
    "env.decimation": "0 -2 1e20",
    "env.episode_length_s": "nan inf 0 -5",
    "env.sim.dt": "nan inf 0 -0.01 1e-300",
    "env.sim.gravity": "[0,0,nan] [0,inf,0] [0,0,null]",
    "env.sim.render_interval": "0",
    "env.sim.mujoco.iterations": "0 -1",
    "env.sim.mujoco.ls_iterations": "-1",
    "env.sim.mujoco.impratio": "nan 0 -1",
    "env.sim.mujoco.tolerance": "nan -0.1",
    "env.sim.mujoco.nconmax": "0 -1",
    "env.scene.env_spacing": "nan -1 inf",
    "env.rewards.alive.weight": "nan inf -inf",
    "env.rewards.pole_pos.params.target": "nan",
    "env.events.reset_cart_position.params.position_range": "[nan,1] [1,-1] [1] [-inf,inf] null",
    "env.events.reset_cart_position.params.velocity_range": "[0,inf] [2,1]",
    "env.terminations.cart_out_of_bounds.params.bounds": "[nan,1] [1,-1] [1,2,3]",
    "env.observations.policy.joint_pos_rel.clip": "[1.0] [2.0,1.0] [nan,1.0] 5",
    "env.observations.policy.joint_pos_rel.scale": "nan inf big [1.0,nan]",
    "env.actions.joint_effort.clip": "{slider_to_cart:[1,-1]} {slider_to_cart:[1]}",
    "env.scene.robot.init_state.rot": "[0,0,0,nan] [0,0,0]",
    "env.scene.ground.spawn.size": "[0,0]",
    "env.sim.mujoco.integrator": "Leapfrog",
    "env.viewer.origin_type": "moon",
    "agent.logger": "csv neptune",
    "agent.policy.noise_std_type": "linear",
    "agent.algorithm.anneal_iterations": "[5,3] [1] [-1,2]",
    "agent.algorithm.anneal_at_success": "-0.1 1.5 high",
    "agent.evaluation.min_success": "-0.1 1.5",
    "agent.evaluation.max_share": "0 1.5 nan",
    "agent.evaluation.consecutive": "0 1.5",
    "env.viewer.resolution": "[0,10] [-1,5]",
    "env.viewer.eye": "[nan,0,0]",
    "env.actions.joint_effort.scale": "nan inf",
    "env.observations.policy.history_length": "-1",
}
"""Settings of the task Cartpole and values that they do not take."""

_LIFT_NUMBERS = {
    "env.commands.object_pose.resampling_time_range": "[nan,5] [-1,5] [5,1]",
    "env.commands.object_pose.ranges.pos_x": "[1,0] [nan,1] [0,inf]",
    "env.curriculum.action_rate.params.weight": "nan",
    "env.rewards.reaching_object.params.std": "nan 0 -1 inf",
    "env.rewards.lifting_object.params.minimal_height": "nan inf",
    "env.terminations.object_dropping.params.minimum_height": "nan -inf",
    "env.scene.robot.actuators.panda_hand.stiffness": "nan -1",
    "env.scene.robot.soft_joint_pos_limit_factor": "0 nan",
    "env.scene.object.init_state.pos": "[0,nan,0]",
}
"""Settings of the task Lift-Cube-Franka and values that they do not take."""

_NULLS = (
    *("env.sim", "env.scene", "env.viewer", "env.sim.mujoco", "env.sim.dt", "env.decimation", "env.episode_length_s"),
    *("agent.policy", "agent.algorithm", "agent.algorithm.gamma"),
    *("agent.policy.actor_hidden_dims", "agent.max_iterations", "agent.experiment_name", "env.rewards.alive.weight"),
)

_NAMES = ("../out", "/tmp/out", "a/../../b", "..", "a\nb", "a\tb", "\x1b[31mred", "x" * 300)


def _all() -> list[WrongInput]:
    found = []

    def add(script: str, args: tuple[str, ...], *says: str) -> None:
        found.append(WrongInput(script, args, says))

    for task, numbers in ((_CARTPOLE, _NUMBERS), (_LIFT, _LIFT_NUMBERS)):
        for path, values in numbers.items():
            for value in values.split():
                add(_TRAIN, (*task, f"{path}={value}"), path)
    for path in _NULLS:
        add(_TRAIN, (*_CARTPOLE, f"{path}=null"), path)
    for name in ("actions", "observations"):
        add(_TRAIN, (*_CARTPOLE, f"env.{name}=null"), f"no {name}")
    for name in _NAMES:
        add(_TRAIN, (*_CARTPOLE, "--experiment_name", name), "experiment_name")
        add(_TRAIN, (*_CARTPOLE, "--run_name", name), "run_name")
    add(_TRAIN, (*_CARTPOLE, "--run_name", "a/b"), "run_name")
    add(_TRAIN, (*_CARTPOLE, "agent.experiment_name=''"), "experiment_name")
    add(_PLAY, (*_CARTPOLE, "--experiment_name", "../out"), "experiment_name")
    add("sb3/train.py", (*_CARTPOLE, "--experiment_name", "../out"), "experiment_name")
    add("skrl/train.py", (*_CARTPOLE, "--run_name", "a\nb"), "run_name")
    for device in ("gpu", "cuda:99", "cuda:-1", "cpu:3", "meta", "mps", "", "0", "cuda:x"):
        add(_TRAIN, ("--task", "Cartpole", "--num_envs", "4", "--device", device), "device")
    for script in (_PLAY, _EVALUATE, "benchmark.py", "sb3/train.py", "sb3/play.py", "skrl/train.py", "skrl/play.py"):
        add(script, ("--task", "Cartpole", "--num_envs", "4", "--device", "tpu"), "'tpu'", "cpu")
    add("rsl_rl/study.py", ("--tasks", "Cartpole", "--device", "tpu"), "'tpu'", "cpu")
    add(_TRAIN, ("--task", "Cartpole", "--num_envs", "4", "agent.device=gpu"), "'gpu'", "cpu")
    add(_TRAIN, ("--task", "Cartpole", "--num_envs", "4", "env.sim.device=gpu"), "'gpu'", "cpu")
    add(_TRAIN, (*_CARTPOLE, "env.sim.physics=bullet"), "physics", "native", "warp")

    # What can only be found when the environment is there.
    add(_TRAIN, (*_CARTPOLE, "agent.success_metric=Metrics/sucess"), "success_metric", "Metrics/sucess")
    add(_TRAIN, (*_CARTPOLE, "env.actions.joint_effort=null"), "env.actions")
    for path in ("env.sim", "env.scene", "agent.policy", "agent.algorithm", "env.sim.mujoco"):
        add(_TRAIN, (*_CARTPOLE, f"~{path}"), path.rpartition(".")[2])
    for path in ("env.scene.robot.actuators", "env.rewards.pole_pos.params.asset_cfg", "env.scene.robot.init_state"):
        add(_TRAIN, (*_CARTPOLE, f"{path}=null"), path)
    for path in ("env.scene.robot.actuators", "env.scene.robot.init_state.joint_pos", "env.rewards.pole_pos.params"):
        add(_TRAIN, (*_CARTPOLE, path + "={}"), path)
    add(_TRAIN, (*_CARTPOLE, "env.scene.robot=null"), "'robot'")
    add(_TRAIN, (*_CARTPOLE, "env.scene.robot.spawn.usd_path=no/such.usda"), "no/such.usda")
    add(_TRAIN, (*_CARTPOLE, "env.actions.joint_effort.joint_names=[elbow]"), "elbow", "slider_to_cart")
    add(_TRAIN, (*_CARTPOLE, "env.actions.joint_effort.joint_names=[]"), "env.actions")
    add(_TRAIN, (*_CARTPOLE, "env.actions.joint_effort.asset_name=robo"), "'robo'", "'robot'")
    add(_TRAIN, (*_CARTPOLE, "env.rewards.pole_pos.params.asset_cfg.joint_names=[elbow]"), "elbow", "cart_to_pole")
    add(_TRAIN, (*_CARTPOLE, "env.rewards.alive.params={foo:1}"), "'foo'")
    add(_TRAIN, (*_CARTPOLE, "env.rewards.alive.func=no.such:thing"), "no.such")
    add(_TRAIN, (*_CARTPOLE, "env.observations.policy.concatenate_dim=7"), "'policy'", "dimension 7")
    add(_TRAIN, (*_CARTPOLE, "env.observations.policy.concatenate_terms=false"), "'policy'", "concatenate_terms")
    add(_TRAIN, (*_CARTPOLE, "agent.policy.actor_hidden_dims=[100000000,100000000]"), "actor_hidden_dims", "memory")
    add(_TRAIN, (*_CARTPOLE, "agent.num_steps_per_env=100000000000"), "num_steps_per_env", "memory")
    add(_TRAIN, (*_LIFT, "env.scene.object=null"), "'object'")
    add(_TRAIN, (*_LIFT, "env.scene.ee_frame=null"), "'ee_frame'")
    add(_TRAIN, (*_LIFT, "env.scene.ee_frame.target_frames=[]"), "target_frames")
    add(_TRAIN, (*_LIFT, "env.commands=null"), "'object_pose'")
    add(_TRAIN, (*_LIFT, "env.commands.object_pose.ranges=null"), "env.commands.object_pose.ranges")
    add(_TRAIN, (*_LIFT, "env.commands.object_pose.body_name=thumb"), "'thumb'", "panda_hand")
    add(_TRAIN, (*_LIFT, "env.scene.robot.actuators.panda_hand.joint_names_expr=[x]"), "'x'", "panda_joint1")
    add(_TRAIN, (*_LIFT, "env.scene.object.spawn.scale=[0,0,0]"), "scale")
    add(_TRAIN, (*_LIFT, "env.actions.gripper_action.open_command_expr={}"), "open_command_expr")
    add(_TRAIN, (*_CARTPOLE, "env.observations.policy=null"), "env.observations")
    nothing = ("env.observations.policy.joint_pos_rel=null", "env.observations.policy.joint_vel_rel=null")
    add(_TRAIN, (*_CARTPOLE, *nothing), "env.observations.policy")
    add(_TRAIN, (*_CARTPOLE, "env.events.reset_cart_position.mode=rest"), "mode", "'rest'", "'reset'")
    add(_TRAIN, (*_CARTPOLE, "env.events.reset_cart_position.mode=interval"), "interval_range_s")
    add(_TRAIN, (*_CARTPOLE, "env.events.reset_cart_position.mode=''"), "mode")
    add(_TRAIN, (*_CARTPOLE, "agent.algorithm.num_mini_batches=1000"), "num_mini_batches")
    add(_TRAIN, (*_CARTPOLE, "agent.policy.init_noise_std=[1.0,1.0,1.0]"), "init_noise_std")
    add(_TRAIN, (*_CARTPOLE, "agent.policy.activation=swishy"), "activation", "swishy")
    add(_TRAIN, (*_CARTPOLE, "agent.policy.class_name=Transformer"), "class_name", "ActorCritic")
    add(_TRAIN, (*_CARTPOLE, "agent.algorithm.class_name=SAC"), "class_name", "SAC")
    add(_TRAIN, (*_CARTPOLE, "agent.algorithm.class_name=os:getcwd"), "class_name", "os:getcwd")
    add(_TRAIN, (*_LIFT, "agent.algorithm.class_name=PPO"), "class_name", "agent.algorithm.mean_reg_coef=0")
    add(_TRAIN, (*_CARTPOLE, "agent.algorithm.schedule=cosine"), "schedule", "adaptive")
    add(_TRAIN, (*_CARTPOLE, "agent.algorithm.optimizer=lion"), "optimizer", "adam")
    add(_TRAIN, (*_CARTPOLE, "agent.class_name=Runner"), "class_name", "OnPolicyRunner")
    add(_TRAIN, (*_CARTPOLE, "agent.obs_groups={policy:[polcy]}"), "obs_groups", "'policy'")
    add(_TRAIN, (*_CARTPOLE, "agent.obs_groups={policy:[]}"), "obs_groups")
    for number in ("2000000000", "100000000000000"):
        add(_TRAIN, ("--task", "Cartpole", "--device", "cpu", "--num_envs", number), "memory")
    for script, more in (("benchmark.py", ()), ("sb3/train.py", ()), ("skrl/train.py", ()), (_EVALUATE, _PRETRAINED)):
        add(script, ("--task", "Lift-Cube-Franka", "--device", "cpu", "--num_envs", "2000000000", *more), "memory")

    # A kind of value that cannot be meant.
    add(_TRAIN, (*_CARTPOLE, "env.scene.robot.spawn.rigid_props=5"), "rigid_props", "RigidBodyPropertiesCfg")
    add(_TRAIN, (*_CARTPOLE, "env.scene.robot.class_type=null"), "class_type")
    add(_TRAIN, (*_CARTPOLE, "env.scene.robot.actuators.cart_actuator=null"), "actuators.cart_actuator")
    add(_TRAIN, (*_CARTPOLE, "env.actions.joint_effort.clip=[0,1]"), "env.actions.joint_effort.clip")
    add(_TRAIN, (*_CARTPOLE, "env.observations.policy.joint_pos_rel.noise=5"), "joint_pos_rel.noise", "NoiseCfg")
    add(_TRAIN, (*_CARTPOLE, "env.observations.policy.joint_pos_rel.modifiers=[1]"), "modifier must be")
    add(_TRAIN, (*_CARTPOLE, "env.commands=5"), "env.commands")
    add(_TRAIN, (*_CARTPOLE, "agent.algorithm.rnd_cfg=5"), "rnd_cfg", "RslRlRndCfg")
    add(_TRAIN, (*_CARTPOLE, "env.events.reset_cart_position.mode=prestartup"), "prestartup", "'startup'")

    # Flags that need another, and words that are none.
    for flag in (("--video_length", "9"), ("--video_interval", "9"), ("--video_envs", "2"), ("--video_camera", "eye")):
        add(_TRAIN, (*_CARTPOLE, *flag), flag[0], "--video")
    add(_TRAIN, (*_CARTPOLE, "--checkpoint", "latest"), "--resume")
    add(_TRAIN, (*_CARTPOLE, "--load_run", ".*"), "--resume")
    add(_TRAIN, (*_CARTPOLE, "--log_project_name", "lift"), "--logger")
    add(_TRAIN, (*_CARTPOLE, "--distributed"), "torchrun")
    add(_TRAIN, (*_CARTPOLE, "--resume"), "no runs")
    add(_TRAIN, (*_CARTPOLE, "--max_iterations", "0"), "--max_iterations")
    add(_TRAIN, (*_CARTPOLE, "--max_iterations", "nan"), "--max_iterations")
    add(_TRAIN, (*_CARTPOLE, "--seed", "-7"), "seed")
    add(_TRAIN, (*_CARTPOLE, "--seed", "99999999999"), "seed")
    add(_TRAIN, (*_CARTPOLE, "--num_threads", "0"), "--num_threads")
    add(_TRAIN, (*_CARTPOLE, "--num_env", "8"), "--num_env")
    add(_TRAIN, ("--task", "Cartpol"), "'Cartpole'")
    add(_TRAIN, ("--task", "Cartpole", "--agent", "ppo"), "rsl_rl_cfg_entry_point")
    add(_TRAIN, ("--task", ""), "task")
    add(_TRAIN, (), "--task")
    add(_TRAIN, (*_CARTPOLE, "env.sim.dtt=0.01"), "env.sim.dt")
    add(_TRAIN, (*_CARTPOLE, "env.sim.dt=fast"), "env.sim.dt")
    add(_TRAIN, (*_CARTPOLE, "env.scene.num_envs=8"), "--num_envs", "env.scene.num_envs")
    add(_TRAIN, (*_CARTPOLE, "env.sim.dt=0.01,0.02"), "--multirun")
    add(_TRAIN, (*_CARTPOLE, "env.sim.dt=[0.01"), "env.sim.dt")
    add(_TRAIN, (*_CARTPOLE, "more"), "'more'")
    add(_PLAY, (*_CARTPOLE, "--video_length", "9"), "--video")
    add(_PLAY, (*_CARTPOLE, "--port", "80"), "--viewer")
    add(_PLAY, (*_CARTPOLE, "--checkpoint", "no/such.pt"), "no/such.pt")
    add(_PLAY, (*_CARTPOLE, "--checkpoint", "pretrained", "--load_run", "x"), "--load_run")
    add(_PLAY, (*_CARTPOLE, "--steps", "0"), "--steps")
    add(_PLAY, (*_CARTPOLE, "--video", "film.avi"), ".mp4")
    add(_PLAY, (*_CARTPOLE, "--replay", "page.txt"), ".html")
    add(_PLAY, (*_CARTPOLE, "--viewer", "--port", "-1"), "port -1")
    add(_PLAY, (*_CARTPOLE, "--viewer", "--port", "70000"), "port 70000")
    add(_PLAY, (*_CARTPOLE, "--checkpoint", "pretrained", "env.sim.dt=nan"), "env.sim.dt")
    add(_EVALUATE, (*_LIFT, "--checkpoint", "pretrained", "env.sim.dt=-1"), "env.sim.dt")
    add(_EVALUATE, (*_LIFT, "--checkpoint", "pretrained", "--episodes", "0"), "--episodes")
    add(_EVALUATE, (*_LIFT, "--checkpoint", "pretrained", "--perturb", "mass=nan"), "mass")
    add(_EVALUATE, (*_LIFT, "--checkpoint", "pretrained", "--perturb", "wind=2"), "wind")
    add(_EVALUATE, (*_LIFT, "--checkpoint", "pretrained", "--success", "no.module:f"), "no.module")
    add(_EVALUATE, (*_LIFT, "--checkpoint", "pretrained", "--json", "."), "'.'")
    add("rsl_rl/study.py", ("--tasks", "Cartpole", "--name", "../x"), "--name")
    add("rsl_rl/study.py", ("--tasks", "Cartpole", "--seeds", "-1"), "--seeds")
    add("rsl_rl/study.py", ("--tasks", "Cartpole", "agent.algorithm.gamma=nan"), "agent.algorithm.gamma")
    add("rsl_rl/study.py", ("--tasks", "Cartpole", "env.sim.dt=0"), "env.sim.dt")
    add("rsl_rl/study.py", ("--tasks", "Cartpole", "--perturb_episodes", "5"), "--perturb")
    add("benchmark.py", ("--task", "Cartpole", "--num_envs", "0"), "--num_envs")
    add("benchmark.py", ("--task", "Cartpole", "--device", "cpu", "env.sim.dt=nan"), "env.sim.dt")
    add("benchmark.py", ("--task", "Cartpole", "--sizes", "1,0"), "--sizes")
    add("benchmark.py", ("--task", "Cartpole", "--seed", "-5"), "seed")
    add("list_envs.py", ("--keyword", "zebra"), "zebra")
    add("list_envs.py", ("--describe", "Cartpol"), "'Cartpole'")
    add("list_envs.py", ("--describe", "Cartpole", "env.sim.dt=nan"), "env.sim.dt")
    add("list_envs.py", ("env.sim.dt=0.1",), "env.sim.dt")
    for library in ("sb3", "skrl"):
        add(f"{library}/train.py", (*_CARTPOLE, "env.sim.dt=nan"), "env.sim.dt")
        add(f"{library}/train.py", (*_CARTPOLE, "--video_length", "9"), "--video")
        add(f"{library}/train.py", (*_CARTPOLE, "--checkpoint", "no.zip"), "no.zip")
        add(f"{library}/play.py", _CARTPOLE, "no runs")
        add(
            f"{library}/play.py",
            (*_CARTPOLE, "--checkpoint", "x.zip", "--use_last_checkpoint"),
            "--use_last_checkpoint",
        )
    add("sb3/train.py", (*_CARTPOLE, "agent.policy=Foo"), "Foo")
    add("skrl/train.py", (*_CARTPOLE, "agent.models.policy.class=Foo"), "skrl", "Foo")
    add("skrl/train.py", (*_CARTPOLE, "agent.agent.learning_rate_scheduler=Foo"), "skrl", "Foo")
    for path, values in _SB3.items():
        for value in values.split():
            add("sb3/train.py", (*_CARTPOLE, f"{path}={value}"), path)
    for path, values in _SKRL.items():
        for value in values.split():
            add("skrl/train.py", (*_CARTPOLE, f"{path}={value}"), path)
    return found


_SB3 = {
    "agent.gamma": "nan 1.5 -1",
    "agent.gae_lambda": "nan 2",
    "agent.learning_rate": "nan -1 0",
    "agent.n_steps": "0 -1 null",
    "agent.n_epochs": "0",
    "agent.clip_range": "nan 0",
    "agent.ent_coef": "nan inf",
    "agent.max_grad_norm": "nan -1",
}
"""Settings of Stable-Baselines3's agent of the task Cartpole and values that they do not take."""

_SKRL = {
    "agent.agent.rollouts": "0 -1 null",
    "agent.agent": "null",
    "agent.memory": "null",
    "agent.agent.experiment": "null",
    "agent.agent.learning_rate": "nan 0 -1",
    "agent.agent.discount_factor": "nan 2",
    "agent.agent.gae_lambda": "nan -1",
    "agent.agent.learning_epochs": "0",
    "agent.agent.mini_batches": "0 null 1000",
    "agent.trainer.timesteps": "0 -1",
}
"""Settings of skrl's agent of the task Cartpole and values that they do not take."""

WRONG_INPUTS = _all()
