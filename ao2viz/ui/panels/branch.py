"""The left dock, below: choosing an action oneself, and the branch that comes of it."""

from functools import partial

import numpy as np
import viser

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.words import capitalised
from ao2viz.ui import html_replay
from ao2viz.ui.commands import Command
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_press, on_trigger
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.panels.links import Links
from ao2viz.ui.replay_commands import CancelBranch, LimitBranch, Rejoin, TakeOver
from ao2viz.ui.replaying import MAX_BRANCH_LIMIT
from ao2viz.ui.view import View

_LISTED = 9


class BranchPanel:
    """Takes over for a step, and comes back."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._spec: TaskSpec | None = None
        self._offered: tuple[object, ...] = ()
        press = partial(on_click, client_id=client_id, inbox=inbox)
        trigger = partial(on_trigger, client_id=client_id, inbox=inbox)
        self._gui, self._client_id, self._inbox = gui, client_id, inbox
        self._keys: list[viser.CommandHandle] = []  # One for each action that the task has.
        self._line = gui.add_html("")
        self._facts = gui.add_html("")
        self._rejoin = gui.add_button(
            "Back to the main line", icon=viser.Icon.ARROW_MERGE, visible=False
        )
        press(self._rejoin, Rejoin())
        self._rejoin_key = gui.add_command(
            "Branch: back to the main line", hotkey="B", modifier="shift"
        )
        trigger(self._rejoin_key, Rejoin())
        self._actions = Links(gui, "What will you do here?", client_id, inbox, _LISTED)
        self._number = gui.add_number("Number", 0.0, step=0.01, visible=False)
        self._take_number = gui.add_button("Take over with this number", visible=False)
        on_press(self._take_number, self._nearest, client_id, inbox)
        self._limit = gui.add_number(
            "Steps (0: all)",
            0,
            min=0,
            max=MAX_BRANCH_LIMIT,
            step=1,
            hint="How far the agent goes on; 0: to the end.",
        )
        on_change(self._limit, lambda value: LimitBranch(int(value)), client_id, inbox)
        self._limit_shown = Mirror(self._limit)
        self._cancel = gui.add_button("Cancel", icon=viser.Icon.X, color="gray", visible=False)
        press(self._cancel, CancelBranch())
        trigger(gui.add_command("Branch: cancel the one under way"), CancelBranch())

    def sync(self, view: View) -> None:
        """Shows the branch, and what can be done at this step."""
        replay = view.replay
        self._line.content = html_replay.line(view)
        self._facts.content = html_replay.branch_facts(view)
        self._rejoin.visible = replay.branch is not None
        self._rejoin_key.disabled = replay.branch is None
        self._cancel.visible = replay.branching is not None
        self._limit_shown.show(replay.branch_limit)
        offered = (view.spec, replay.can_take_over)
        if offered == self._offered:
            return
        self._offered = offered
        spec = view.spec if replay.can_take_over else None
        self._spec = view.spec
        self._name_keys(view.spec, replay.can_take_over)
        links: list[tuple[str, Command]] = []
        if spec is not None:
            links = [(capitalised(name), TakeOver(i)) for i, name in enumerate(spec.action_names)]
        self._actions.sync(links)
        grid = spec.action_grid if spec is not None else None
        is_number = grid is not None and grid.shape[1] == 1
        self._number.visible = self._take_number.visible = is_number
        if grid is not None and is_number:
            told = ", ".join(f"{value:g}" for value in grid[:, 0])
            self._number.hint = f"The nearest of the agent's own actions is taken: {told}."

    def _nearest(self) -> TakeOver | None:
        """The action whose number is nearest to the one that was typed."""
        grid = self._spec.action_grid if self._spec is not None else None
        if grid is None:
            return None
        return TakeOver(int(np.argmin(np.abs(grid[:, 0] - self._number.value))))

    def _name_keys(self, spec: TaskSpec | None, can_take_over: bool) -> None:
        """Has a command in the palette for each action of the task, by its name."""
        names = spec.action_names[:_LISTED] if spec is not None else ()
        while len(self._keys) > len(names):
            key = self._keys.pop()
            self._inbox.drop_key(self._client_id, key)
            key.remove()
        for i, name in enumerate(names):
            label = f"Branch: take over with {name}"
            if i == len(self._keys):
                self._keys.append(self._gui.add_command(label))
                on_trigger(self._keys[i], TakeOver(i), self._client_id, self._inbox)
            self._keys[i].label = label
            self._keys[i].disabled = not can_take_over
