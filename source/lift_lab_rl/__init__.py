"""Reinforcement-learning libraries on lift_lab environments: rsl_rl's wrapper, runner, export and evaluation."""
