"""Registration of the Franka lift tasks."""

import gymnasium as gym

_LIFT = "lift_lab_tasks.manager_based.manipulation.lift"
_FRANKA = f"{_LIFT}.config.franka"
_JOINT_POS = f"{_FRANKA}.joint_pos_env_cfg"
_PPO = f"{_FRANKA}.agents.rsl_rl_ppo_cfg:LiftCubePPORunnerCfg"
_IK_PPO = f"{_FRANKA}.agents.rsl_rl_ppo_ik_cfg"

_CURRICULA = {
    "explore": f"{_JOINT_POS}:ExplorationCfg",
    "step": f"{_JOINT_POS}:CurriculumCfg",
    "linear": f"{_FRANKA}.curricula:LinearCurriculumCfg",
    "success": f"{_FRANKA}.curricula:SuccessCurriculumCfg",
    "none": None,
}
_IK_CURRICULA = {
    "explore": f"{_FRANKA}.ik_curricula:ExplorationCfg",
    "step": f"{_FRANKA}.ik_curricula:StepCurriculumCfg",
    "linear": f"{_FRANKA}.ik_curricula:LinearCurriculumCfg",
    "success": f"{_FRANKA}.ik_curricula:SuccessCurriculumCfg",
    "none": None,
}
_REWARDS = {
    "gated": f"{_LIFT}.lift_env_cfg:RewardsCfg",
    "ungated": f"{_FRANKA}.reward_sets:UngatedRewardsCfg",
}
_EVENTS = {
    "plain": f"{_LIFT}.lift_env_cfg:EventCfg",
    "randomized": f"{_FRANKA}.event_sets:RandomizedEventCfg",
}

_SOFT_EVENTS = {
    "plain": f"{_FRANKA}.event_sets:SoftEventCfg",
    "randomized": f"{_FRANKA}.event_sets:RandomizedSoftEventCfg",
}

for _id, _env_cfg, _agent in (
    ("Lift-Cube-Franka", f"{_JOINT_POS}:FrankaCubeLiftEnvCfg", _PPO),
    ("Lift-Cube-Franka-CL", f"{_JOINT_POS}:FrankaCubeLiftCurriculumEnvCfg", _PPO),
    (
        "Lift-Soft-Cube-Franka",
        f"{_FRANKA}.soft_cube_env_cfg:FrankaSoftCubeLiftEnvCfg",
        f"{_FRANKA}.agents.rsl_rl_ppo_cfg:LiftSoftCubePPORunnerCfg",
    ),
    (
        "Lift-Cube-Franka-IK-Rel",
        f"{_FRANKA}.ik_rel_env_cfg:FrankaCubeLiftEnvCfg",
        f"{_IK_PPO}:LiftCubeIKRelPPORunnerCfg",
    ),
    (
        "Lift-Cube-Franka-IK-Abs",
        f"{_FRANKA}.ik_abs_env_cfg:FrankaCubeLiftEnvCfg",
        f"{_IK_PPO}:LiftCubeIKAbsPPORunnerCfg",
    ),
):
    for _suffix, _cfg in (("", _env_cfg), ("-Play", f"{_env_cfg}_PLAY")):
        gym.register(
            id=f"{_id}{_suffix}",
            entry_point="lift_lab.envs:ManagerBasedRLEnv",
            vector_entry_point="lift_lab.envs:ManagerBasedRLVectorEnv",
            disable_env_checker=True,
            kwargs={
                "env_cfg_entry_point": _cfg,
                "rsl_rl_cfg_entry_point": _agent,
                "skrl_cfg_entry_point": f"{_FRANKA}.agents:skrl_ppo_cfg.yaml",
                "sb3_cfg_entry_point": f"{_FRANKA}.agents:sb3_ppo_cfg.yaml",
                "success": f"{_LIFT}.mdp:object_reached_goal",
                "cpu_num_envs": 512,
                "presets": {
                    "env.curriculum": _IK_CURRICULA if "IK" in _id else _CURRICULA,
                    "env.rewards": _REWARDS,
                    "env.events": _SOFT_EVENTS if "Soft" in _id else _EVENTS,
                },
            },
        )
