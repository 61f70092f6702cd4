"""The right dock, above: what to train, and the buttons of the run that all browsers share."""

from functools import partial
from typing import Any

import viser
from viser._messages import HotkeyKey, LiteralColor

from ao2viz.core.config import Preset
from ao2viz.core.decision import DecideBy
from ao2viz.explain.words import count, number
from ao2viz.training.states import RunStatus
from ao2viz.training.updates import RunUpdate
from ao2viz.ui import html
from ao2viz.ui.commands import (
    ChooseDecideBy,
    ConfirmOverwrite,
    Edit,
    Field,
    Press,
    RunButton,
    SetTrainingSpeed,
)
from ao2viz.ui.dialog_commands import ChooseShare, Dialog, NextStage, OpenDialog
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_trigger
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.panels.page import ThemeButton
from ao2viz.ui.session import OTHER_ENV
from ao2viz.ui.view import View

_SPEEDS: dict[str, float | None] = {
    "full": None,
    "1000/s": 1000.0,
    "300/s": 300.0,
    "100/s": 100.0,
    "30/s": 30.0,
    "10/s": 10.0,
    "3/s": 3.0,
}
_STAGE = "Takes a step and shows its stages one by one: sample, find, act, accommodate, …"
_TRAIN_ON = "So many more steps with the agent that is watched, a file's or that of an ended run."
_SHARES: dict[str, float] = {"99 %": 0.99, "95 %": 0.95, "80 %": 0.8, "50 %": 0.5}
_BUTTONS: tuple[tuple[RunButton, str, viser.IconName, LiteralColor, HotkeyKey | None], ...] = (
    (RunButton.START, "Start", viser.Icon.PLAYER_PLAY, "green", "T"),
    (RunButton.TRAIN_ON, "Train on", viser.Icon.SCHOOL, "gray", "T"),
    (RunButton.PAUSE, "Pause", viser.Icon.PLAYER_PAUSE, "gray", "H"),
    (RunButton.STOP, "Stop", viser.Icon.PLAYER_STOP, "gray", None),
    (RunButton.STEP, "Step", viser.Icon.PLAYER_SKIP_FORWARD, "gray", "N"),
    (RunButton.EPISODE, "Episode", viser.Icon.PLAYER_TRACK_NEXT, "gray", "B"),
    (RunButton.SAVE, "Save", viser.Icon.DEVICE_FLOPPY, "gray", "S"),
)
_LARGEST_SEED = 2**31 - 1
_MOST_STEPS = 10_000_000


class ControlPanel:
    """Starts, steers and saves training."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._fields: dict[Field, Any] = {}
        self._shown: tuple[object, ...] = ()
        self._fields[Field.ENV] = gui.add_dropdown("Environment", (OTHER_ENV,))
        self._fields[Field.CUSTOM_ENV] = gui.add_text("Gymnasium id", "", visible=False)
        presets = tuple(p.value for p in (Preset.ANTICIPATING, Preset.PAPER))
        self._fields[Field.PRESET] = gui.add_dropdown("Preset", presets)
        gui.add_html(html.row(2))
        self._fields[Field.SEED] = gui.add_number("Seed", 0, min=0, max=_LARGEST_SEED, step=1)
        self._fields[Field.STEPS] = gui.add_number("Steps", 20_000, min=1, max=_MOST_STEPS, step=1)
        self._buttons: dict[RunButton, viser.GuiButtonHandle] = {}
        self._keys: dict[RunButton, viser.CommandHandle] = {}
        for i, (button, label, icon, color, key) in enumerate(_BUTTONS):
            if i in (0, 4):
                gui.add_html(html.row(4))
            hint = _TRAIN_ON if button is RunButton.TRAIN_ON else None
            self._buttons[button] = handle = gui.add_button(
                label, icon=icon, color=color, hint=hint
            )
            on_click(handle, Press(button), client_id, inbox)
            command = gui.add_command(
                f"Training: {button.value}",
                hotkey=key,
                modifier="shift" if button is RunButton.TRAIN_ON else None,
                icon=icon,
            )
            on_trigger(command, Press(button), client_id, inbox)
            self._keys[button] = command
            if button is RunButton.STEP:
                self._stage = gui.add_button(
                    "Stage", icon=viser.Icon.STAIRS, color="gray", hint=_STAGE
                )
                on_click(self._stage, NextStage(), client_id, inbox)
                self._stage_key = gui.add_command(
                    "Training: one stage of a step", hotkey="N", modifier="shift"
                )
                on_trigger(self._stage_key, NextStage(), client_id, inbox)
        self._fields[Field.FILE_NAME] = gui.add_text("File name", "")
        self._question = gui.add_html("", visible=False)
        self._replace = gui.add_button("Replace it", color="orange", visible=False)
        on_click(self._replace, ConfirmOverwrite(True), client_id, inbox)
        self._keep = gui.add_button("Keep the old one", color="gray", visible=False)
        on_click(self._keep, ConfirmOverwrite(False), client_id, inbox)
        gui.add_html(html.row(2))
        self._speed = gui.add_dropdown("Speed", tuple(_SPEEDS), hint="Steps a second, at most.")
        on_change(self._speed, lambda s: SetTrainingSpeed(_SPEEDS[s]), client_id, inbox)
        self._decide_by = gui.add_dropdown(
            "Decide by",
            (DecideBy.PATH.value, DecideBy.VOTE.value),  # The first is how a new run begins.
            hint="path: the most similar option alone; vote: the most similar options together.",
        )
        on_change(self._decide_by, lambda v: ChooseDecideBy(DecideBy(v)), client_id, inbox)
        gui.add_html(html.row(2))
        self._share = gui.add_dropdown(
            "Learning",
            tuple(_SHARES),
            initial_value="95 %",
            hint="How much of the time is for learning, at least; the rest may go into showing it: "
            "less learning, more pictures a second. What is learned stays the same.",
        )
        on_change(self._share, lambda v: ChooseShare(_SHARES[v]), client_id, inbox)
        self._settings = gui.add_button("Settings", icon=viser.Icon.ADJUSTMENTS, color="gray")
        on_click(self._settings, OpenDialog(Dialog.SETTINGS), client_id, inbox)
        gui.add_html(html.row(3))
        for label, icon, dialog in (
            ("Library", viser.Icon.BOOKS, Dialog.LIBRARY),
            ("Help", viser.Icon.HELP, Dialog.HELP),
        ):
            button = gui.add_button(label, icon=icon, color="gray")
            on_click(button, OpenDialog(dialog), client_id, inbox)
        self._theme = ThemeButton(gui, client_id, inbox)
        self._progress = gui.add_progress_bar(0.0)
        self._status = gui.add_html("")
        self._mirrors = {field: Mirror(handle) for field, handle in self._fields.items()}
        self._decide_by_shown = Mirror(self._decide_by)
        self._share_shown = Mirror(self._share)
        self._speed_shown = Mirror(self._speed)
        for field, handle in self._fields.items():
            on_change(handle, partial(Edit, field), client_id, inbox)

    def sync(self, view: View) -> None:
        """Shows the view. Assigning an unchanged value sends nothing."""
        form, run = view.form, view.run
        self._mirrors[Field.ENV].show_among((*view.env_ids, OTHER_ENV), form.env)
        values = (form.env, form.custom_env, form.preset.value, form.seed, form.steps)
        for field, value in zip(Field, (*values, form.file_name), strict=True):
            self._mirrors[field].show(value)
        self._fields[Field.CUSTOM_ENV].visible = form.env == OTHER_ENV
        for button, handle in self._buttons.items():
            handle.disabled = self._keys[button].disabled = button not in view.enabled
        self._theme.sync(view)
        self._stage.disabled = self._stage_key.disabled = not view.can_walk
        pause = self._buttons[RunButton.PAUSE]
        is_held = run.status in (RunStatus.PAUSED, RunStatus.FAILED)
        label = "Go on" if is_held else "Pause"
        if pause.label != label:
            pause.label = label
            pause.icon = viser.Icon.PLAYER_PLAY if is_held else viser.Icon.PLAYER_PAUSE
        self._decide_by.disabled = not view.can_choose_decide_by
        if view.can_choose_decide_by:
            self._decide_by_shown.show(run.decide_by.value)
        told = {value: words for words, value in _SHARES.items()}
        self._share_shown.show(told.get(run.learning_share, "95 %"))
        speeds = {value: words for words, value in _SPEEDS.items()}
        self._speed_shown.show(speeds.get(run.speed, "full"))
        self._progress.value = 100 * _progress(run)
        self._question.visible = self._replace.visible = self._keep.visible = (
            view.overwrite is not None
        )
        if view.overwrite is not None:
            self._question.content = (
                f'<div class="ao"><p>There is a file {html.esc(view.overwrite.name)} already. '
                "Replace it?</p></div>"
            )
        facts = (run.n_steps, run.steps_per_s, run.eta_s, run.run_id)
        shown = (view.status, view.is_error, *facts, view.settings)
        if shown != self._shown:
            self._shown = shown
            self._status.content = _status(view)


def _progress(run: RunUpdate) -> float:
    if run.total_steps <= 0:
        return 0.0
    return min(1.0, max(0.0, (run.n_steps - run.first_step) / run.total_steps))


def _status(view: View) -> str:
    run = view.run
    kind = ' class="ao-error"' if view.is_error else ""
    lines = [f"<p{kind} role='status'>{html.esc(view.status)}</p>"]
    if run.spec is not None and run.status not in (RunStatus.IDLE, RunStatus.PREPARING):
        done, planned = run.n_steps - run.first_step, run.total_steps
        facts = [f"{html.esc(run.spec.env_id)}, {done:,} of {count(planned, 'step')}"]
        if run.status is RunStatus.RUNNING and run.steps_per_s > 0:
            facts.append(f"{number(run.steps_per_s)} steps/s")
            if run.eta_s is not None:
                facts.append(f"{_duration(run.eta_s)} to go")
        if len(run.history):
            facts.append(f"{count(len(run.history), 'episode')}")
        lines.append(f'<p class="ao-dim ao-run">{" · ".join(facts)}</p>')
    differing = [f"{row.setting.name} {row.text}" for row in view.settings if row.differs]
    if differing:
        told = html.esc(", ".join(differing))
        lines.append(f'<p class="ao-dim">A new run differs from the defaults: {told}</p>')
    return f'<div class="ao">{"".join(lines)}</div>'


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{max(1, round(seconds))} s"
    if seconds < 5400:
        return f"{round(seconds / 60)} min"
    return f"{seconds / 3600:.1f} h"
