"""What is told about the replay: remarks, branches, links; as HTML, escaping as in `html`."""

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.words import count, number, say_outcome
from ao2viz.ui.branches import Branch
from ao2viz.ui.html import esc
from ao2viz.ui.html_past import say_back
from ao2viz.ui.view import View


def line(view: View) -> str:
    """What must not be missed about what is watched: that it is a branch, and the last remark."""
    replay, lines = view.replay, []
    if view.back is not None:
        lines.append(f'<p class="ao-banner">{esc(say_back(view.back))}</p>')
    if replay.branch is not None and view.spec is not None:
        lines.append(f'<p class="ao-banner">{esc(say_branch(replay.branch, view.spec))}</p>')
    if replay.branching is not None:
        steps = count(replay.branching.steps, "step")
        lines.append(f'<p class="ao-dim">Playing the branch: {steps} so far …</p>')
    if replay.remark:
        lines.append(f'<p class="ao-warn">{esc(replay.remark)}</p>')
    return f'<div class="ao">{"".join(lines)}</div>' if lines else ""


def say_branch(branch: Branch, spec: TaskSpec) -> str:
    """Where a branch leaves the main line, and by whose choice."""
    chosen = [
        f"step {takeover.step:,}: you chose {spec.action_names[takeover.action]}"
        for takeover in branch.takeovers
    ]
    return f"Branch from {'; '.join(chosen)}."


def branch_facts(view: View) -> str:
    """What a branch came to, beside the main line; or how to make one."""
    branch, spec = view.replay.branch, view.spec
    if branch is None or spec is None:
        words = (
            "Choose the action of the step that is shown yourself. The agent goes on from there, "
            "in a branch that can be stepped through like any episode. Nothing of the agent "
            "changes."
        )
        if not view.replay.can_take_over:
            words = "Watch a step of a recorded episode, or pause the run, to take over there."
        return f'<div class="ao"><p class="ao-dim">{words}</p></div>'
    here, main = branch.episode, branch.main
    gap = here.total_reward - main.total_reward
    rows = "".join(
        f'<tr><td>{name}</td><td class="ao-num">{number(episode.total_reward)}</td>'
        f'<td class="ao-num">{len(episode):,}</td></tr>'
        for name, episode in (("this branch", here), ("main line", main))
    )
    more = "as much" if gap == 0 else f"{number(abs(gap))} {'more' if gap > 0 else 'less'}"
    return (
        f'<div class="ao">'
        f"<table><tr><th></th><th>return</th><th>steps</th></tr>{rows}</table>"
        f'<p class="ao-gaps">The branch earns {more}: {esc(say_outcome(here))}.</p></div>'
    )


def taken_over(view: View) -> str:
    """That a person chose this step's action, above what the agent decided; or nothing."""
    branch, spec = view.replay.branch, view.spec
    if branch is None or spec is None:
        return ""
    takeover = branch.takeover_at(view.transport.position)
    if takeover is None:
        return ""
    chosen = esc(spec.action_names[takeover.action])
    words = f"You chose {chosen} here. Below is what the agent decided."
    if view.decision is not None and view.decision.action == takeover.action:
        words = f"You chose {chosen} here, and so did the agent:"
    return f'<div class="ao"><p class="ao-banner">{words}</p></div>'


def links(view: View) -> str:
    """What opens this moment again; a click selects it, to be copied."""
    if not view.replay.link:
        words = "Only a recorded episode of an agent file can be linked to."
        return f'<div class="ao"><p class="ao-dim">{words}</p></div>'
    return (
        f'<div class="ao"><code class="ao-copy">{esc(view.replay.link)}</code>'
        f'<code class="ao-copy">{esc(view.replay.command)}</code>'
        '<p class="ao-dim">Both count episodes from 0.</p></div>'
    )


def stops(view: View) -> str:
    """How many steps meet the condition, or what is wrong with what was typed."""
    replay = view.replay
    if replay.stop_problem:
        return f'<div class="ao"><p class="ao-error">{esc(replay.stop_problem)}</p></div>'
    if not replay.stop_text:
        words = "margin &lt; 0.1 · action = 0 · explored or step = 100"
        if view.spec is not None:
            feature, action = view.spec.features[-1], view.spec.action_names[0]
            words = esc(f"margin < 0.1 · {feature.name} > 0.5 and not explored · action = {action}")
        return f'<div class="ao"><p class="ao-dim">For example: {words}</p></div>'
    return (
        f'<div class="ao"><p class="ao-dim">{count(replay.n_stops, "step")} of this episode, '
        f"where playing holds. Live training does not hold there.</p></div>"
    )
