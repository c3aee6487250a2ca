"""The page's controls. They only note what was asked; the session acts on it between steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .goals import GoalControl
from .keys import Key, add_keys, key_table
from .plots import ALL, LivePlot
from .scene import ViewerScene

SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4", "as fast as possible")
FOLLOW_NOTHING = "nothing"
FORCE_SCALES = (0.01, 50.0)
"""Shortest and longest arrow in cm for each N."""

SWITCHES = {
    "only_env": ("Only this environment", "Hide all other environments, with their markers."),
    "visuals": ("Visual meshes", "The shapes that a camera sees."),
    "colliders": ("Colliders", "The shapes that collide, in orange. A mesh collides as its convex hull."),
    "frames": ("Frames", "Axes of moving bodies, and shorter ones of sites: x red, y green, z blue."),
    "commands": ("Command markers", "Markers of commands, such as the goal."),
    "actions": ("Action markers", "Markers of actions, such as the target of the hand."),
    "sensors": ("Sensor markers", "Markers of sensors, such as the frames that a frame transformer measures."),
    "contact_points": ("Contact points", "A pink ball wherever two bodies touch."),
    "contact_forces": (
        "Contact forces",
        "A green arrow for the force at each contact point. The tab Values lists the forces in N.",
    ),
}
"""Label and hint of everything that can be shown and hidden (see :attr:`ViewerScene.shown`)."""


class Panel:
    """Buttons, sliders, charts and tables. viser calls back on its own threads: nothing here touches the task."""

    def __init__(
        self,
        server: Any,
        post: Callable[..., None],
        num_envs: int,
        goals: GoalControl,
        choices: list[str],
        scene: ViewerScene,
        plot: LivePlot,
    ):
        """Make the controls.

        Args:
            server: the viser server.
            post: called as ``post(name, *values)`` for everything that the session has to do.
            num_envs: number of environments.
            goals: what sliders may set.
            choices: versions of the policy.
            scene: what can be shown.
            plot: what can be plotted.
        """
        self._post = post
        self._told = choices[-1]
        self._gui = gui = server.gui
        self._goals: list[Any] = []
        self._last_followed: str | None = None
        self.switches: dict[str, Any] = {}
        """Checkbox of everything that can be shown and hidden."""
        gui.configure_theme(show_share_button=False)
        self.status = gui.add_markdown("")
        tabs = gui.add_tab_group()
        with tabs.add_tab("Run"):
            if goals.ranges:
                self._add_goals(goals)
            self._add_run()
            self._add_policy(choices)
            self.episode = gui.add_html("")
            self._keys = gui.add_folder("Keys and mouse", expand_by_default=False)
        with tabs.add_tab("View"):
            self._add_view(num_envs, scene)
        with tabs.add_tab("Plots"):
            self._add_plots(plot)
        with tabs.add_tab("Values"):
            self.figures = gui.add_html("")
        self._add_keys(num_envs, scene)

    def _add_goals(self, goals: GoalControl) -> None:
        gui = self._gui
        with gui.add_folder("Goal"):
            self._by_hand = gui.add_checkbox(
                "Set by hand",
                False,
                hint="On: the sliders set the goal of every environment. Off: the task draws goals again.",
            )
            self._by_hand.on_update(lambda _: self._post_goal())
            for goal in goals.ranges:
                step = (goal.high - goal.low) / 100
                slider = gui.add_slider(
                    f"{goal.term}.{goal.field}",
                    goal.low,
                    goal.high,
                    step,
                    goal.middle,
                    disabled=False,
                    hint="Move it: every environment gets this goal, and keeps it over resets.",
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

    def _add_run(self) -> None:
        gui, post = self._gui, self._post
        with gui.add_folder("Simulation"):
            self.pause = gui.add_button("Pause", hint="Stop, or go on.")
            self.pause.on_click(lambda _: post("pause"))
            step = gui.add_button("Step", hint="Take one environment step, then pause.")
            step.on_click(lambda _: post("step"))
            reset = gui.add_button("Reset", hint="Start a new episode in every environment.")
            reset.on_click(lambda _: post("reset"))
            speed = gui.add_dropdown("Speed", SPEEDS, initial_value="1", hint="Simulated seconds per second.")
            speed.on_update(lambda event: post("speed", event.target.value))

    def _add_policy(self, choices: list[str]) -> None:
        gui, post = self._gui, self._post
        with gui.add_folder("Policy"):
            self.policy = gui.add_dropdown(
                "Checkpoint",
                choices,
                initial_value=self._told,
                hint="Which checkpoint of the run acts. The list grows while training writes more.",
            )
            self.policy.on_update(lambda event: post("policy", event.target.value))
            self.newest = gui.add_checkbox("Newest", False, hint="Change to each new checkpoint of the run.")
            self.newest.on_update(lambda event: post("newest", event.target.value))
            self.newest.visible = len(choices) > 1

    def _add_view(self, num_envs: int, scene: ViewerScene) -> None:
        gui, post = self._gui, self._post
        with gui.add_folder("Camera"):
            if num_envs > 1:
                self.env = gui.add_number(
                    "Environment",
                    0,
                    min=0,
                    max=num_envs - 1,
                    step=1,
                    hint="The selected environment: plots, values, frames and contacts are of this one.",
                )
                self.env.on_update(lambda event: post("env", event.target.value))
                self._add_switches(scene, ("only_env",))
            self.follow = gui.add_dropdown(
                "Follow",
                (FOLLOW_NOTHING, *scene.moving),
                initial_value=FOLLOW_NOTHING,
                hint="Keep a body of the selected environment in the middle of the picture.",
            )
            self.follow.on_update(lambda event: post("follow", event.target.value))
            reset = gui.add_button("Reset view", hint="Move the camera back to the selected environment.")
            reset.on_click(lambda _: post("view"))
        with gui.add_folder("Show"):
            self._add_switches(scene, ("visuals", "colliders", "frames", "commands", "actions", "sensors"))
        with gui.add_folder("Contacts"):
            self._add_switches(scene, ("contact_points", "contact_forces"))
            scale = gui.add_slider(
                "Arrow, cm per N",
                *FORCE_SCALES,
                0.01,
                min(max(scene.contacts.cm_per_n, FORCE_SCALES[0]), FORCE_SCALES[1]),
                hint="Length of the arrow of a force of 1 N. An arrow ends after 1 m.",
            )
            scale.on_update(lambda event: post("force_scale", event.target.value))

    def _add_keys(self, num_envs: int, scene: ViewerScene) -> None:
        post = self._post
        keys = [
            Key("space", "Pause or go on", lambda: post("pause")),
            Key("O", "One step", lambda: post("step")),
            Key("R", "Reset all environments", lambda: post("reset")),
            Key("F", "Follow the robot, or stop following", lambda: self._toggle_follow(scene)),
            Key("V", "Reset the view", lambda: post("view")),
        ]
        if num_envs > 1:
            keys += [
                Key("N", "Next environment", lambda: self._change_env(1, num_envs)),
                Key("P", "Previous environment", lambda: self._change_env(-1, num_envs)),
            ]
        switches = {
            "I": ("Show only this environment", ("only_env",)),
            "C": ("Show contact points and forces", ("contact_points", "contact_forces")),
            "L": ("Show colliders", ("colliders",)),
            "X": ("Show frames", ("frames",)),
            "M": ("Show markers", ("commands", "actions", "sensors")),
        }
        for key, (label, names) in switches.items():
            here = [self.switches[name] for name in names if name in self.switches]
            if here:
                keys.append(Key(key, label, lambda here=here: _toggle(here)))
        add_keys(self._gui, keys)
        with self._keys:
            self._gui.add_html(key_table(keys))

    def _change_env(self, by: int, num_envs: int) -> None:
        self.env.value = (int(self.env.value) + by) % num_envs  # its own callback posts the environment

    def _toggle_follow(self, scene: ViewerScene) -> None:
        if self.follow.value == FOLLOW_NOTHING:
            self.follow.value = self._last_followed or scene.default_body or FOLLOW_NOTHING
        else:
            self._last_followed = self.follow.value
            self.follow.value = FOLLOW_NOTHING

    def _add_switches(self, scene: ViewerScene, names: tuple[str, ...]) -> None:
        for name in names:
            if name in scene.shown:
                label, hint = SWITCHES[name]
                switch = self._gui.add_checkbox(label, scene.shown[name], hint=hint)
                switch.on_update(lambda event, name=name: self._post("show", name, event.target.value))
                self.switches[name] = switch

    def _add_plots(self, plot: LivePlot) -> None:
        gui, post = self._gui, self._post
        self.plot_group = gui.add_dropdown(
            "Plot",
            plot.groups,
            initial_value=plot.group,
            hint="What to plot of the selected environment. Rewards are weighted, for each second.",
        )
        self.plot_group.on_update(lambda event: post("plot", event.target.value))
        self.plot_term = gui.add_dropdown(
            "Term", plot.terms(plot.group), initial_value=plot.term, hint="One term, or all of them together."
        )
        self.plot_term.on_update(lambda event: post("plot_term", event.target.value))
        plot.put_into(gui, gui.add_folder(None))

    def show_plot(self, plot: LivePlot) -> None:
        """Show the plotted quantities in the controls."""
        self.plot_group.value = plot.group
        terms = plot.terms(plot.group)
        if tuple(terms) != tuple(self.plot_term.options):
            self.plot_term.options = terms
        self.plot_term.value = plot.term
        self.plot_term.visible = terms != [ALL]

    def show_choices(self, choices: list[str], current: str) -> None:
        """Update the list of checkpoints and which of them acts."""
        if tuple(choices) != tuple(self.policy.options):
            self.policy.options = choices
            self.newest.visible = len(choices) > 1
        if current != self._told:  # what the user has just chosen stays until it acts or fails
            self._told = self.policy.value = current


def _toggle(switches: list[Any]) -> None:
    """Turn all on, or off if one is on."""
    shown = not any(switch.value for switch in switches)
    for switch in switches:
        switch.value = shown
