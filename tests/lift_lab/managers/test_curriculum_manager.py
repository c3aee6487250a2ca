"""Curricula: computed at resets, their last state logged."""

import torch

from lift_lab.managers import CurriculumManager, CurriculumTermCfg, ManagerTermBase, RewardManager, RewardTermCfg


def level(env, env_ids, step=1.0):
    env.calls.append(env_ids)
    return step * len(env.calls)


def silent(env, env_ids):
    return None


def by_terrain(env, env_ids):
    return {"flat": torch.tensor(1.5), "stairs": 0.5, "unseen": None}


def test_the_terms_get_the_environments_about_to_reset(env):
    manager = CurriculumManager({"level": CurriculumTermCfg(func=level)}, env)
    manager.compute([1, 2])
    manager.compute()
    assert env.calls == [[1, 2], slice(None)]


def test_the_last_state_is_logged_and_none_is_not(env):
    manager = CurriculumManager(
        {
            "level": CurriculumTermCfg(func=level, params={"step": 2.0}),
            "silent": CurriculumTermCfg(func=silent),
            "terrain": CurriculumTermCfg(func=by_terrain),
        },
        env,
    )
    assert manager.reset() == {}
    manager.compute()
    manager.compute()
    log = {"Curriculum/level": 4.0, "Curriculum/terrain/flat": 1.5, "Curriculum/terrain/stairs": 0.5}
    assert manager.reset() == log
    assert manager.reset() == log
    assert manager.get_active_iterable_terms(0) == [("level", [4.0]), ("terrain", [1.5, 0.5])]


def test_a_logged_tensor_does_not_follow_the_terms_state(env):
    state = torch.zeros(())
    manager = CurriculumManager({"live": CurriculumTermCfg(func=lambda env, env_ids: state)}, env)
    manager.compute()
    log = manager.reset()
    state += 1
    assert log["Curriculum/live"] == 0.0


def test_class_terms_are_reset_with_the_environments(env):
    class Memory(ManagerTermBase):
        def __call__(self, env, env_ids):
            return 1.0

        def reset(self, env_ids=None):
            self._env.calls.append(env_ids)

    CurriculumManager({"memory": CurriculumTermCfg(func=Memory)}, env).reset([3])
    assert env.calls == [[3]]


def test_a_curriculum_changes_a_reward_but_not_the_environments_config(env):
    """modify_reward_weight as Isaac Lab defines it: a strict common_step_counter > num_steps."""

    def modify(env, env_ids, term_name, weight, num_steps):
        cfg = env.reward_manager.get_term_cfg(term_name)
        if env.common_step_counter > num_steps:
            cfg.weight = weight
            env.reward_manager.set_term_cfg(term_name, cfg)
        return cfg.weight

    rewards = {"rate": RewardTermCfg(func=lambda env: torch.ones(4), weight=-1e-4)}
    env.reward_manager = RewardManager(rewards, env)
    params = {"term_name": "rate", "weight": -0.1, "num_steps": 10}
    manager = CurriculumManager({"rate": CurriculumTermCfg(func=modify, params=params)}, env)
    env.common_step_counter = 10
    manager.compute([0])
    assert manager.reset()["Curriculum/rate"] == -1e-4
    env.common_step_counter = 11
    manager.compute([0])
    assert manager.reset()["Curriculum/rate"] == -0.1
    assert torch.allclose(env.reward_manager.compute(1.0), torch.full((4,), -0.1))
    assert rewards["rate"].weight == -1e-4


def test_the_table_lists_the_terms(env):
    assert "| level " in str(CurriculumManager({"level": CurriculumTermCfg(func=level)}, env))
