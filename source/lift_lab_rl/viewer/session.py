"""The live viewer: one loop that steps the task, draws it, and handles the page's requests."""

from __future__ import annotations

import queue
import signal
import time
from typing import Any

import torch

from lift_lab.app import endings
from lift_lab.utils.errors import ConfigError, LiftLabError, suggest

from . import tables
from .drag import MODIFIER, BodyPuller
from .goals import GoalControl
from .panel import FOLLOW_NOTHING, FORCE_SCALES, SPEEDS, Panel
from .plots import LivePlot
from .policies import CheckpointPolicy, ViewedPolicy
from .scene import ViewerScene
from .success import SuccessCounter

MAX_DRAWS_PER_S = 60.0
"""Poses are sent at most this often."""
FIGURES_EVERY_S = 0.25
"""Time between updates of the panel's values and plots."""
CHECKPOINTS_EVERY_S = 1.0
"""Time between looks into the run's folder."""
_CHANGE_THE_TASK = {"goal", "reset"}
"""What changes observations when the page asks for it."""
_LONGEST_DELAY_S = 0.25
"""A simulation slower than real time forgets what it is behind beyond this."""


class ViewerSession:
    """Live view of a policy."""

    def __init__(self, env: Any, policy: ViewedPolicy, server: Any, title: str):
        """Draw the environments and make the controls.

        Args:
            env: wrapped environment.
            policy: acts.
            server: the viser server.
            title: heads the panel.
        """
        self._env, self._policy, self._server, self._title = env, policy, server, title
        self._inner: Any = env.unwrapped
        self._asked: queue.SimpleQueue[tuple[str, tuple[Any, ...]]] = queue.SimpleQueue()
        self._success = SuccessCounter(self._inner)
        self._goals = GoalControl(self._inner.command_manager)
        self._scene = ViewerScene(self._inner, server)
        self._plot = LivePlot(self._inner)
        self._puller = BodyPuller(self._inner)
        self._listen_to_drags()
        self._panel = Panel(
            server, self._post, env.num_envs, self._goals, self._policy.choices(), self._scene, self._plot
        )
        self._do_plot(self._plot.groups[min(1, len(self._plot.groups) - 1)])
        self._paused, self._speed, self._follow_newest = False, 1.0, False
        self._single_steps = 0
        self._stopping = False
        self._problem: str | None = None
        self._problem_of = ""
        self.steps = 0
        """Environment steps taken."""
        self.draws = 0
        """Times that poses were sent."""

    @property
    def problem(self) -> str | None:
        """Last error, as the page shows it."""
        return self._problem

    def _post(self, name: str, *values: Any) -> None:
        """Called on viser's threads."""
        self._asked.put((name, values))

    def run(self, max_steps: int | None = None) -> None:
        """Step and draw until :meth:`stop` is called, as from the handler of a signal.

        Args:
            max_steps: end after as many environment steps; None for never.
        """
        with torch.inference_mode():
            obs, _ = self._env.reset()
            self._draw()
            due = drawn = time.perf_counter()
            figures = checkpoints = -1e9
            pending = False
            while not self._stopping and (max_steps is None or self.steps < max_steps):
                now = time.perf_counter()
                if asked := self._answer():
                    pending = True
                    obs = self._env.get_observations() if asked & _CHANGE_THE_TASK else obs
                if (not self._paused and now >= due) or self._single_steps:
                    obs, pending, self._single_steps = self._step(obs), True, max(self._single_steps - 1, 0)
                    pace = self._inner.step_dt / self._speed if self._speed else 0.0
                    due = max(due + pace, now - _LONGEST_DELAY_S)
                if pending and now - drawn >= 1.0 / MAX_DRAWS_PER_S:
                    self._draw()
                    drawn, pending = now, False
                if now - figures >= FIGURES_EVERY_S:
                    self._show_figures()
                    figures = now
                if now - checkpoints >= CHECKPOINTS_EVERY_S:
                    self._look_for_checkpoints()
                    checkpoints = now
                self._wait(min(due, drawn + 1.0 / MAX_DRAWS_PER_S) if pending else due)
            if pending:
                self._draw()

    def stop(self, number: int = signal.SIGINT, _: Any = None) -> None:
        """End :meth:`run` after the running step. Takes a signal's number, so that it can be the signal's handler.

        Raises:
            KeyboardInterrupt: it was called before, and this is not SIGHUP, which may come several times.
        """
        if self._stopping and number != endings.HANGUP:
            raise endings.Interrupted(number)
        self._stopping = True

    def _wait(self, due: float) -> None:
        """Sleep until there is something to do, but not for long: the page wants answers."""
        longest = 1.0 / MAX_DRAWS_PER_S
        left = longest if self._paused else due - time.perf_counter()
        if left > 0:
            time.sleep(min(left, longest))

    def _step(self, obs: Any) -> Any:
        self._puller.before_step()
        obs, _, dones, _ = self._env.step(self._policy.act(obs).to(self._env.device))
        self._puller.after_step(dones)
        self._policy.reset(dones)
        self._success.note(dones)
        self._plot.record()
        self.steps += 1
        return obs

    def _draw(self) -> None:
        self._scene.draw()
        self.draws += 1

    def _listen_to_drags(self) -> None:
        handles = self._scene.bodies.moving_bodies
        for body_id in self._puller.body_ids:
            if body_id in handles:
                self._listen_to(handles[body_id], body_id)

    def _listen_to(self, handle: Any, body_id: int) -> None:
        async def note(event: Any) -> None:  # a coroutine, so that viser keeps the order of events
            if event.phase == "start":
                self._post("grab", event.instance_index or 0, body_id, event.start_position)
            if event.phase == "end":
                self._post("let_go")
            else:
                self._post("pull", event.end_position)

        handle.on_drag("left", modifier=MODIFIER)(note)

    # -- what the page asked for

    def _answer(self) -> set[str]:
        """Do everything that was asked; returns the names of what it was."""
        asked = []
        while not self._asked.empty():
            asked.append(self._asked.get())
        for i, (name, values) in enumerate(asked):
            is_latest = all(later != name for later, _ in asked[i + 1 :])
            if is_latest or name not in ("goal", "pull"):  # only the last position of a slider or of the mouse counts
                try:
                    getattr(self, f"_do_{name}")(*values)
                except LiftLabError as error:
                    self._report(str(error), name)
                else:
                    if name == self._problem_of:  # what was wrong is now right
                        self._problem, self._problem_of = None, ""
        return {name for name, _ in asked}

    def _do_pause(self) -> None:
        self._paused = not self._paused
        self._panel.pause.label = "Go on" if self._paused else "Pause"
        self._single_steps = 0

    def _do_step(self) -> None:
        if not self._paused:
            self._do_pause()
        self._single_steps += 1

    def _do_reset(self) -> None:
        self._env.reset()
        self._policy.reset(torch.ones(self._env.num_envs, dtype=torch.bool, device=self._env.device))
        self._puller.forget_motion()
        self._success.forget()

    def _report(self, problem: str, what: str = "") -> None:
        """Show a problem until what was asked succeeds, or for an empty name until a policy is chosen."""
        self._problem, self._problem_of = problem, what
        print(f"viewer: {problem}")

    def _do_speed(self, text: str) -> None:
        if text not in SPEEDS:
            raise ConfigError(f"speed '{text}'; {suggest(text, SPEEDS)}")
        self._speed = float(text) if text[0].isdigit() else 0.0

    def _do_env(self, number: float) -> None:
        self._scene.select(number)  # type: ignore[arg-type]  # it refuses what is no environment
        self._plot.select(self._scene.env_id)

    def _do_view(self) -> None:
        self._scene.camera.show(self._scene.env_id)

    def _do_follow(self, name: str) -> None:
        self._scene.follow(None if name == FOLLOW_NOTHING else name)

    def _do_show(self, what: str, shown: bool) -> None:
        self._scene.show(what, shown)

    def _do_force_scale(self, cm_per_n: float) -> None:
        low, high = FORCE_SCALES
        if not low <= cm_per_n <= high:
            raise ConfigError(f"{cm_per_n} cm per N is not between {low} and {high}")
        self._scene.contacts.cm_per_n = float(cm_per_n)

    def _do_plot(self, group: str) -> None:
        if group != self._plot.group:
            self._plot.choose(group)
        self._panel.show_plot(self._plot)

    def _do_plot_term(self, term: str) -> None:
        if term != self._plot.term:
            self._plot.choose(self._plot.group, term)

    def _do_grab(self, instance: int, body_id: int, point: tuple[float, float, float]) -> None:
        shown = self._scene.bodies.shown_envs
        if instance in range(len(shown)):
            self._puller.grab(shown[instance], body_id, self._scene.world.from_drawn(point))

    def _do_pull(self, point: tuple[float, float, float]) -> None:
        self._puller.move(self._scene.world.from_drawn(point))

    def _do_let_go(self) -> None:
        self._puller.let_go()

    def _do_goal(self, values: list[float] | None) -> None:
        self._goals.release() if values is None else self._goals.fix(values)

    def _do_newest(self, follow: bool) -> None:
        self._follow_newest = follow

    def _do_policy(self, name: str) -> None:
        if name == self._policy.current:
            return
        try:
            self._policy.choose(name)
            self._problem = None
        except LiftLabError as error:
            self._report(str(error))
            self._panel.policy.value = self._policy.current
        self._success.forget()

    # -- what the page shows

    def _look_for_checkpoints(self) -> None:
        policy = self._policy
        if self._follow_newest and isinstance(policy, CheckpointPolicy) and policy.newest() != policy.current:
            self._do_policy(policy.newest())
        self._panel.show_choices(policy.choices(), policy.current)

    def _show_figures(self) -> None:
        env, env_id = self._inner, self._scene.env_id
        self._panel.episode.content = tables.join(
            tables.episode(env, env_id, self._success), tables.commands(env, env_id)
        )
        self._plot.push()
        contacts = tables.contacts(self._scene.last_contacts, self._scene.body_names)
        self._panel.figures.content = tables.join(contacts, tables.rewards(env, env_id), tables.curriculum(env))
        lines = [f"**{self._title}** · {self._policy.current} · environment {env_id} of {self._env.num_envs}"]
        if (pull := self._puller.pull) is not None:
            name, force_n = self._scene.body_names[pull.body_id], float(self._puller.force.norm())
            lines.append(f"pulling {name} of environment {pull.env_id} with {force_n:.1f} N")
        lines += [f"⚠ {text}" for text in (self._problem, self._policy.warning()) if text]
        self._panel.status.content = "\n\n".join(lines)
