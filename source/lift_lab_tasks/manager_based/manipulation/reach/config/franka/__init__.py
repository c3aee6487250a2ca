"""Registration of the Franka reach tasks."""

import gymnasium as gym

_TASK = "lift_lab_tasks.manager_based.manipulation.reach"
_FRANKA = f"{_TASK}.config.franka"

for _id, _module, _agent in (
    ("Reach-Franka", "joint_pos_env_cfg", "FrankaReachPPORunnerCfg"),
    ("Reach-Franka-IK-Rel", "ik_rel_env_cfg", "FrankaReachIKRelPPORunnerCfg"),
    ("Reach-Franka-IK-Abs", "ik_abs_env_cfg", "FrankaReachIKAbsPPORunnerCfg"),
):
    for _suffix, _env_cfg in (("", "FrankaReachEnvCfg"), ("-Play", "FrankaReachEnvCfg_PLAY")):
        gym.register(
            id=f"{_id}{_suffix}",
            entry_point="lift_lab.envs:ManagerBasedRLEnv",
            vector_entry_point="lift_lab.envs:ManagerBasedRLVectorEnv",
            disable_env_checker=True,
            kwargs={
                "env_cfg_entry_point": f"{_FRANKA}.{_module}:{_env_cfg}",
                "rsl_rl_cfg_entry_point": f"{_FRANKA}.agents.rsl_rl_ppo_cfg:{_agent}",
                "success": f"{_TASK}.mdp:pose_reached",
                "cpu_num_envs": 512,
            },
        )
