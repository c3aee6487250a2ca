"""Registration of the Franka lift tasks."""

import gymnasium as gym

_CFG = "lift_lab_tasks.manager_based.manipulation.lift.config.franka.joint_pos_env_cfg"
_AGENT = "lift_lab_tasks.manager_based.manipulation.lift.config.franka.agents.rsl_rl_ppo_cfg:LiftCubePPORunnerCfg"

for _id, _env_cfg in (
    ("Lift-Cube-Franka", "FrankaCubeLiftEnvCfg"),
    ("Lift-Cube-Franka-Play", "FrankaCubeLiftEnvCfg_PLAY"),
    ("Lift-Cube-Franka-CL", "FrankaCubeLiftCurriculumEnvCfg"),
    ("Lift-Cube-Franka-CL-Play", "FrankaCubeLiftCurriculumEnvCfg_PLAY"),
):
    gym.register(
        id=_id,
        entry_point="lift_lab.envs:ManagerBasedRLEnv",
        disable_env_checker=True,
        kwargs={"env_cfg_entry_point": f"{_CFG}:{_env_cfg}", "rsl_rl_cfg_entry_point": _AGENT},
    )
