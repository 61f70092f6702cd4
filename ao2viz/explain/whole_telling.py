"""What is known of a whole agent, in sentences."""

import numpy as np

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import tell_faithfulness
from ao2viz.explain.whole import (
    Attended,
    Carriers,
    Comparison,
    Coverage,
    Highlight,
    Novelty,
    Overview,
    Roles,
)
from ao2viz.explain.words import capitalised, count, number, percent


def tell_overview(told: Overview, spec: TaskSpec) -> tuple[str, ...]:
    """An agent at a glance."""
    lines = [
        tell_attention(told.attention, spec),
        tell_roles(told.roles),
        tell_coverage(told.coverage),
        *map(tell_highlight, told.highlights),
    ]
    if told.faithfulness is not None:
        lines.append(tell_faithfulness(told.faithfulness))
    return tuple(lines)


def tell_attention(told: Attended, spec: TaskSpec) -> str:
    """What the distances are made of, the greatest share first."""
    parts = [
        f"{spec.features[d].name} {percent(float(told.shares[d]))}"
        for d in np.argsort(-told.shares, kind="stable")
    ]
    return f"What it attends to, over {count(told.states, 'state')}: {', '.join(parts)}."


def tell_roles(told: Roles) -> str:
    """Who decides, who supports, who could be spared."""
    most = ", ".join(
        f"{option} ({percent(times / told.states)})"
        for option, times in zip(told.deciding[:5].tolist(), told.decided[:5].tolist(), strict=True)
    )
    return (
        f"In {count(told.states, 'state')} {count(len(told.deciding), 'option')} had a say, most "
        f"often {most}; {len(told.supporting):,} more only support them, {told.idle:,} had no "
        f"part. {len(told.redundant):,} of {_those_tried(told)} could be left out, one at a time, "
        f"without another action anywhere."
    )


def _those_tried(told: Roles) -> str:
    if told.tried == len(told.deciding):
        return "those that had a say"
    return f"the {told.tried:,} that were tried before it was called off"


def tell_coverage(told: Coverage) -> str:
    """How much of where it goes is known to it."""
    return (
        f"{percent(told.share)} of {count(len(told.distances), 'state')} are within a distance of "
        f"{number(told.radius)} of an option; the farthest, state {told.farthest}, is "
        f"{number(float(told.distances.max(initial=0.0)))} away. The most similar option has "
        f"{number(told.visits)} visits in the median."
    )


def tell_novelty(told: Novelty) -> str:
    """Whether anything like it has been met before."""
    text = f"The most similar option is {number(told.distance)} away and has "
    text += f"{count(told.visits, 'visit')}; {percent(told.rank)} of the recorded states are "
    text += "farther from what is known."
    if told.is_alarm:
        return f"Never seen before: nothing known lies within {number(told.radius)}. {text}"
    return f"Known: an option lies within {number(told.radius)}. {text}"


def tell_highlight(told: Highlight) -> str:
    """Where to look, and how much the choice mattered."""
    return (
        f"Episode {told.episode}, step {told.step} (see steps {told.first} to {told.last}): the "
        f"best action was expected to earn {number(told.importance)} more than the worst."
    )


def tell_carriers(told: Carriers) -> tuple[str, ...]:
    """What is lost without each option that was muted."""
    lines = [f"With all options: {number(told.mean_return)} in {count(told.episodes, 'episode')}."]
    for one in told.muted:
        error = "" if np.isnan(one.standard_error) else f" ± {number(one.standard_error)}"
        lines.append(
            f"Without option {one.option}: {number(one.mean_return)}, a loss of "
            f"{number(one.loss)}{error} (standard error) in the same episodes."
        )
    if not told.is_complete:
        lines.append("Called off before all were muted.")
    return tuple(lines)


def tell_comparison(told: Comparison, spec: TaskSpec) -> tuple[str, ...]:
    """How often two agents differ, and where it matters most."""
    lines = [
        f"They disagree in {len(told.disagreements):,} of {count(len(told.states), 'state')} "
        f"({percent(told.share)})."
    ]
    for moment in told.disagreements[:10]:
        one, other = spec.action_names[moment.one], spec.action_names[moment.other]
        lines.append(
            f"State {moment.place}: {capitalised(one)}, which this one prefers by "
            f"{number(moment.one_cares)}; the other {other}, by {number(moment.other_cares)}."
        )
    return tuple(lines)
