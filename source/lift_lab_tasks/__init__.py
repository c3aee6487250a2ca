"""Tasks. Importing this package registers their ids with gymnasium and does nothing else.

A task is registered with the places of its configurations, ``"module:Class"``, which are imported when it is made::

    gym.register(
        id="Lift-Cube-Franka",
        entry_point="lift_lab.envs:ManagerBasedRLEnv",
        disable_env_checker=True,
        kwargs={
            "env_cfg_entry_point": f"{__name__}.joint_pos_env_cfg:FrankaCubeLiftEnvCfg",
            "rsl_rl_cfg_entry_point": f"{__name__}.agents.rsl_rl_ppo_cfg:LiftCubePPORunnerCfg",
        },
    )

Other keys that are understood: ``cpu_num_envs`` (environments on a CPU unless asked otherwise), ``presets`` (see
:mod:`lift_lab_tasks.utils.hydra`) and ``success`` (see :mod:`lift_lab_rl.evaluation`).
"""

from .utils import import_packages

import_packages(__name__, ["utils", ".mdp", ".agents"])
