"""Registration of the Franka cabinet task."""

import gymnasium as gym

_TASK = "lift_lab_tasks.manager_based.manipulation.cabinet"
_FRANKA = f"{_TASK}.config.franka"

for _id, _env_cfg in (
    ("Open-Drawer-Franka", "FrankaCabinetEnvCfg"),
    ("Open-Drawer-Franka-Play", "FrankaCabinetEnvCfg_PLAY"),
):
    gym.register(
        id=_id,
        entry_point="lift_lab.envs:ManagerBasedRLEnv",
        vector_entry_point="lift_lab.envs:ManagerBasedRLVectorEnv",
        disable_env_checker=True,
        kwargs={
            "env_cfg_entry_point": f"{_FRANKA}.joint_pos_env_cfg:{_env_cfg}",
            "rsl_rl_cfg_entry_point": f"{_FRANKA}.agents.rsl_rl_ppo_cfg:CabinetPPORunnerCfg",
            "success": f"{_TASK}.mdp:drawer_is_open",
            "cpu_num_envs": 512,
        },
    )
