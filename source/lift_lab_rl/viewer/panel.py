"""The page's controls. They only note what was asked; the session acts on it between steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .goals import GoalControl

SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4", "as fast as possible")


class Panel:
    """Buttons, sliders and tables of a page. viser calls back on its own threads, so nothing here touches the task."""

    def __init__(self, server: Any, post: Callable[..., None], num_envs: int, goals: GoalControl, choices: list[str]):
        """Make the controls.

        Args:
            server: the viser server.
            post: called as ``post(name, *values)`` for everything that the session has to do.
            num_envs: number of environments.
            goals: what sliders may set.
            choices: versions of the policy.
        """
        self._post = post
        self._told = choices[-1]
        gui = server.gui
        gui.configure_theme(show_share_button=False)
        self.status = gui.add_markdown("")
        with gui.add_folder("Run"):
            self.pause = gui.add_button("Pause")
            self.pause.on_click(lambda _: post("pause"))
            gui.add_button("Step").on_click(lambda _: post("step"))
            gui.add_button("Reset").on_click(lambda _: post("reset"))
            speed = gui.add_dropdown("Speed", SPEEDS, initial_value="1")
            speed.on_update(lambda event: post("speed", event.target.value))
        with gui.add_folder("Policy"):
            self.policy = gui.add_dropdown("Checkpoint", choices, initial_value=self._told)
            self.policy.on_update(lambda event: post("policy", event.target.value))
            self.newest = gui.add_checkbox("Newest", False, hint="change to each new checkpoint of the run")
            self.newest.on_update(lambda event: post("newest", event.target.value))
            self.newest.visible = len(choices) > 1
        with gui.add_folder("View"):
            if num_envs > 1:
                chosen = gui.add_number("Environment", 0, min=0, max=num_envs - 1, step=1)
                chosen.on_update(lambda event: post("env", event.target.value))
            shown = gui.add_checkbox("Commands", True)
            shown.on_update(lambda event: post("show_commands", event.target.value))
            frames = gui.add_checkbox("Sensor frames", False)
            frames.on_update(lambda event: post("show_sensors", event.target.value))
        self._goals: list[Any] = []
        if goals.ranges:
            self._add_goals(gui, goals)
        with gui.add_folder("Figures"):
            self.figures = gui.add_html("")

    def _add_goals(self, gui: Any, goals: GoalControl) -> None:
        with gui.add_folder("Goal"):
            self._by_hand = gui.add_checkbox("Set by hand", False, hint="the same goal in every environment")
            self._by_hand.on_update(lambda _: self._post_goal())
            for goal in goals.ranges:
                step = (goal.high - goal.low) / 100
                slider = gui.add_slider(
                    f"{goal.term}.{goal.field}", goal.low, goal.high, step, goal.middle, disabled=False
                )
                slider.on_update(self._on_slider)
                self._goals.append(slider)

    def _on_slider(self, _: Any) -> None:
        if self._by_hand.value:
            self._post_goal()
        else:
            self._by_hand.value = True  # its own callback posts the goal

    def _post_goal(self) -> None:
        self._post("goal", [slider.value for slider in self._goals] if self._by_hand.value else None)

    def show_choices(self, choices: list[str], current: str) -> None:
        """Update the list of checkpoints and which of them acts."""
        if tuple(choices) != tuple(self.policy.options):
            self.policy.options = choices
            self.newest.visible = len(choices) > 1
        if current != self._told:  # what the user has just chosen stays until it acts or fails
            self._told = self.policy.value = current
