"""Registration of the cart-pole: balance a pole on a cart."""

import gymnasium as gym

_TASK = "lift_lab_tasks.manager_based.classic.cartpole"

for _id, _env_cfg in (("Cartpole", "CartpoleEnvCfg"), ("Cartpole-Play", "CartpoleEnvCfg_PLAY")):
    gym.register(
        id=_id,
        entry_point="lift_lab.envs:ManagerBasedRLEnv",
        vector_entry_point="lift_lab.envs:ManagerBasedRLVectorEnv",
        disable_env_checker=True,
        kwargs={
            "env_cfg_entry_point": f"{_TASK}.cartpole_env_cfg:{_env_cfg}",
            "rsl_rl_cfg_entry_point": f"{_TASK}.agents.rsl_rl_ppo_cfg:CartpolePPORunnerCfg",
            "skrl_cfg_entry_point": f"{_TASK}.agents:skrl_ppo_cfg.yaml",
            "sb3_cfg_entry_point": f"{_TASK}.agents:sb3_ppo_cfg.yaml",
            "success": f"{_TASK}.mdp:pole_balanced",
        },
    )
