"""The settings of the next run as they are typed, checked and told apart from defaults; pure."""

import json
from dataclasses import dataclass
from typing import Any

from ao2viz.core.config import Config, Preset, change_config, config_to_dict, make_config, preset_of
from ao2viz.core.settings import Plain, Setting, TakesEffect, settings_of
from ao2viz.ui.session import Form


@dataclass(frozen=True)
class SettingRow:
    """One setting as it stands in the dialog."""

    setting: Setting
    default: Plain  # For this environment.
    text: str  # What is typed, or the default.
    problem: str  # Why that cannot be; empty if it can.
    differs: bool  # From the default.
    in_run: Plain | None  # What the run under way has, if that is something else.


def setting_rows(form: Form, defaults: Config | None, run: Config | None) -> tuple[SettingRow, ...]:
    """Every setting of the form's preset.

    Args:
        form: What is typed.
        defaults: What a run of the form's environment has; None: as the preset has it.
        run: What the run under way has; None while there is none.
    """
    usual = _usual(form.preset, defaults)
    plain = config_to_dict(usual)
    running = {}
    if run is not None and preset_of(run) is form.preset:
        running = config_to_dict(run)
    rows = []
    for setting in settings_of(form.preset):
        default = plain[setting.name]
        typed = form.settings.get(setting.name)
        value, problem = default, ""
        if typed is not None:
            value, problem = _check(usual, setting.name, typed)
        has = running.get(setting.name)
        rows.append(
            SettingRow(
                setting,
                default,
                told(default) if typed is None else typed,
                problem,
                not problem and value != default,
                None if problem or has == value else has,
            )
        )
    return tuple(rows)


def find_overrides(form: Form, defaults: Config | None) -> tuple[dict[str, Any], str]:
    """What a new run differs in from its defaults, and what is wrong with that, in one line."""
    usual = _usual(form.preset, defaults)
    found = {}
    for row in setting_rows(form, defaults, None):
        if row.problem:
            return {}, row.problem
        if row.differs:
            found[row.setting.name] = _check(usual, row.setting.name, row.text)[0]
    return found, ""


def find_changes(form: Form, run: Config | None) -> tuple[dict[str, Any], str]:
    """What would change in the run under way, and why nothing can, in one line."""
    if run is None:
        return {}, "There is no run to change."
    if preset_of(run) is not form.preset:
        return {}, f"The run under way is of the {preset_of(run).value} preset."
    rows = {row.setting.name: row for row in setting_rows(form, run, run)}
    found = {}
    for name in form.settings:
        if name not in rows:
            continue
        if rows[name].problem:
            return {}, rows[name].problem
        if rows[name].differs and rows[name].setting.takes_effect is not TakesEffect.NEW_RUN:
            found[name] = _check(run, name, rows[name].text)[0]
    return found, "" if found else "Nothing that is typed would change the run under way."


def told(value: Plain) -> str:
    """A value as people type it."""
    return value if isinstance(value, str) else json.dumps(value)


def _usual(preset: Preset, defaults: Config | None) -> Config:
    return make_config(preset, {}) if defaults is None else defaults


def _check(config: Config, name: str, text: str) -> tuple[Plain, str]:
    """The value that a text means, and what is wrong with it."""
    value = read(text)
    try:
        checked = change_config(config, {name: value})
    except ValueError as error:
        return told(value), str(error)
    return config_to_dict(checked)[name], ""


def read(text: str) -> Any:
    """A typed value: JSON where it can be, else plain words, as `--set` reads it."""
    try:
        return json.loads(text.strip().replace("−", "-"))
    except (ValueError, RecursionError):  # No JSON, or a number of thousands of digits.
        return text.strip()
