"""The words of the settings dialog as HTML. Escaping as in `html`."""

from ao2viz.core.settings import TakesEffect
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.html import esc
from ao2viz.ui.session import Form
from ao2viz.ui.settings import SettingRow, told


def introduction(form: Form, run: RunUpdate) -> str:
    """What these settings are for."""
    env = form.env_id or "an environment"
    words = (
        f"For the next run of {env} with the {form.preset.value} preset. Empty a field to get its "
        "default back."
    )
    if run.config is not None:
        words += " “Change the run” gives the run under way what can still change in it."
    return f'<div class="ao"><p class="ao-dim">{esc(words)}</p></div>'


def caption(row: SettingRow) -> str:
    """What a setting does, what it may be, and when it takes effect."""
    setting = row.setting
    facts = [f"default {told(row.default)}"]
    if setting.range is not None:
        facts.append(f"{_limit(setting.range[0])} to {_limit(setting.range[1])}")
    if setting.takes_effect is TakesEffect.NEW_RUN:
        facts.append(setting.takes_effect.value)
    else:
        facts.append(f"also in a run: {setting.takes_effect.value}")
    if row.in_run is not None:
        facts.append(f"the run has {told(row.in_run)}")
    mark = '<span class="ao-mark">changed</span>' if row.differs else ""
    problem = f'<p class="ao-error" role="alert">{esc(row.problem)}</p>' if row.problem else ""
    meaning = setting.meaning[0].upper() + setting.meaning[1:]
    return (
        f'<div class="ao ao-setting">{mark}{problem}<p>{esc(meaning)}.</p>'
        f'<p class="ao-dim">{esc(" · ".join(facts))}</p></div>'
    )


def _limit(value: float) -> str:
    """A limit without powers of ten."""
    return f"{value:,.9f}".rstrip("0").rstrip(".")
