"""Profile of an environment step: CPU time of this process by part of the step."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator, Mapping
from typing import Any

MANAGERS = ("observation", "action", "reward", "metrics", "curriculum", "command", "event", "termination", "recorder")


def step_parts(env: Any) -> list[tuple[Any, str, str]]:
    """(object, method, name of the part); time inside a part that lies within another counts for the inner one."""
    inner = env.unwrapped
    managers = {name: getattr(inner, f"{name}_manager") for name in MANAGERS}
    return [
        (inner.sim.physics, "step", "physics"),
        (inner.sim.physics, "health", "search for failures"),
        (managers["action"], "process_action", "actions"),
        (managers["action"], "apply_action", "actions"),
        (inner.scene, "write_data_to_sim", "targets to the engine"),
        (managers["termination"], "compute", "terminations"),
        (managers["reward"], "compute", "rewards"),
        (managers["metrics"], "compute", "metrics"),
        (inner, "_reset_idx", "resets"),
        (inner, "_refresh", "resets: kinematics"),
        (inner, "_reset_scene", "resets: scene and events"),
        (managers["metrics"], "reset", "resets: metrics"),
        (managers["command"], "reset", "resets: commands"),
        (managers["curriculum"], "compute", "resets: curricula"),
        (managers["command"], "compute", "commands"),
        (managers["event"], "apply", "events"),
        (managers["observation"], "compute", "observations"),
    ]


class Clock:
    """Sums CPU time by the innermost part that runs."""

    def __init__(self):
        self.seconds: dict[str, float] = {}
        self._running = ["the rest"]
        self.restart()

    def restart(self) -> None:
        """Forget what was measured so far."""
        self.seconds.clear()
        self._since = time.process_time()

    @property
    def running(self) -> str:
        """The innermost part that runs."""
        return self._running[-1]

    @contextlib.contextmanager
    def part(self, name: str) -> Iterator[None]:
        self.tick()
        self._running.append(name)
        try:
            yield
        finally:
            self.tick()
            self._running.pop()

    def tick(self) -> None:
        now = time.process_time()
        name = self._running[-1]
        self.seconds[name] = self.seconds.get(name, 0.0) + now - self._since
        self._since = now


def profile_steps(env: Any, steps: int, seed: int) -> dict[str, float]:
    """CPU seconds an environment step by part, the largest first; with random actions and episodes of all ages.

    Args:
        env: environment on the CPU, after a reset.
        steps: environment steps to measure.
        seed: seed of the actions.
    """
    import torch

    inner = env.unwrapped
    generator = torch.Generator(device=inner.device).manual_seed(seed)
    inner.episode_length_buf = torch.randint(
        0, inner.max_episode_length, (inner.num_envs,), generator=generator, device=inner.device
    )
    shape = (inner.num_envs, inner.action_manager.total_action_dim)
    actions = [torch.randn(shape, generator=generator, device=inner.device) for _ in range(steps)]
    with torch.inference_mode(), contextlib.ExitStack() as stack:
        env.step(actions[0])
        clock = Clock()
        for owner, method, name in step_parts(env):
            stack.enter_context(measured(clock, owner, method, name))
        clock.restart()
        for action in actions:
            env.step(action)
        clock.tick()
    return dict(sorted(((k, v / steps) for k, v in clock.seconds.items()), key=lambda item: -item[1]))


@contextlib.contextmanager
def measured(clock: Clock, owner: Any, method: str, name: str | Mapping[str, str]) -> Iterator[None]:
    """Count the time in a method of an object, or of all objects of a class, while the body runs.

    Args:
        clock: what counts.
        owner: the object or class.
        method: name of the method.
        name: of the part, or names by the part that calls it, with the empty string for all others.
    """
    original, own = getattr(owner, method), method in vars(owner)
    names = {"": name} if isinstance(name, str) else name

    def call(*args: Any, **kwargs: Any) -> Any:
        with clock.part(names.get(clock.running, names[""])):
            return original(*args, **kwargs)

    setattr(owner, method, call)
    try:
        yield
    finally:
        if own:
            setattr(owner, method, original)
        else:
            delattr(owner, method)


def show_profile(seconds: dict[str, float], title: str) -> None:
    """Print a profile as a table."""
    from rich.console import Console
    from rich.table import Table

    table = Table("part", "us", "share", title=title, title_justify="left")
    total = sum(seconds.values())
    for name, value in seconds.items():
        table.add_row(name, f"{value * 1e6:,.0f}", f"{value / total:.1%}")
    Console().print(table)
