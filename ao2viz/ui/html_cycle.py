"""The stages of a single step as HTML. Escaping as in `html`."""

from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.cycle import explain_stage
from ao2viz.recording.cycle import Stage
from ao2viz.ui.html import esc
from ao2viz.ui.walking import Walk


def cycle_stages(walk: Walk, spec: TaskSpec, view: ForestView) -> str:
    """Which stage it is, and what happened at it."""
    items = []
    for stage in Stage:
        is_now = stage is walk.stage
        state = "now" if is_now else "done" if stage.number < walk.stage.number else "next"
        current = ' aria-current="step"' if is_now else ""
        items.append(f'<li class="ao-stage-{state}"{current}>{esc(stage.value)}</li>')
    said = explain_stage(walk.cycle, walk.stage, spec, view)
    return (
        f'<div class="ao ao-cycle"><h4>The perceptual cycle, step {walk.cycle.n_steps:,}</h4>'
        f'<ol>{"".join(items)}</ol><p role="status">{esc(said)}</p></div>'
    )
