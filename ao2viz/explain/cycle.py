"""The stages of one step in words: recorded numbers formatted, nothing guessed."""

from typing import assert_never

import numpy as np

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.core.growth import GrowthKind
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.sentence import explain
from ao2viz.explain.words import amount, amounts, count, number, told_apart
from ao2viz.recording.cycle import Cycle, Stage

TOLD_CHANGES = 3
"""So many of the changed weights are said in full, the biggest changes first."""

_TOLD_OPTIONS = 4


def explain_stage(cycle: Cycle, stage: Stage, spec: TaskSpec, view: ForestView) -> str:
    """What happened at a stage of a step.

    Args:
        cycle: The step.
        stage: Which of its stages.
        spec: Names features and actions.
        view: The forest after the step.
    """
    match stage:
        case Stage.SAMPLE:
            seen = _seen(amounts(cycle.decision.observation, spec), spec)
            return f"Step {cycle.n_steps:,} begins. The agent sees: {seen}."
        case Stage.FIND:
            return _find(cycle)
        case Stage.ACT:
            told = explain(cycle.decision, spec)
            return f"{told.headline.capitalize()}. {told.reason} {_outcome(cycle, spec)}"
        case Stage.ACCOMMODATE:
            return _accommodate(cycle, spec, view)
        case Stage.ASSIMILATE:
            return _assimilate(cycle, spec)
        case Stage.CLEANSE:
            return _cleanse(cycle)
        case _:
            assert_never(stage)


def change_of(cycle: Cycle, row: int) -> str:
    """A change of a weight: "197.2 → 197.4"."""
    return " → ".join(told_apart(float(cycle.before[row]), float(cycle.after[row])))


def _seen(values: list[str], spec: TaskSpec) -> str:
    return ", ".join(f"{f.name} {v}" for f, v in zip(spec.features, values, strict=True))


def _find(cycle: Cycle) -> str:
    decision = cycle.decision
    if len(decision.voters) == 0:
        return "There were no options yet, so there was none to find."
    path = [int(option) for option in decision.path]
    said = (
        f"The most similar of {count(cycle.n_options, 'option')} is {path[-1]}, at distance "
        f"{number(decision.distance)}"
    )
    if len(path) > 1:
        said += f", by way of {' → '.join(map(str, path[:-1]))}"
    if decision.runner_up_option != NO_OPTION:
        second = number(decision.runner_up_distance)
        said += f"; the second is {decision.runner_up_option}, at {second}"
    return f"{said}."


def _outcome(cycle: Cycle, spec: TaskSpec) -> str:
    gaps = np.abs(cycle.observation - cycle.decision.observation)
    moved = int(np.argmax(gaps / spec.ranges))
    feature = spec.features[moved]
    was = amount(float(cycle.decision.observation[moved]), feature)
    now = amount(float(cycle.observation[moved]), feature)
    said = f"It earned {number(cycle.reward)}, and {feature.name} went from {was} to {now}"
    if cycle.terminated:
        return f"{said}; the task ended."
    return f"{said}; the time limit was reached." if cycle.truncated else f"{said}."


def _accommodate(cycle: Cycle, spec: TaskSpec, view: ForestView) -> str:
    made = cycle.of(GrowthKind.CREATED)
    if not made:
        alone = "an option that is similar enough is there already"
        if cycle.n_options == 0:
            alone = "the agent is still watching, before it grows its forest"
        elif cycle.terminated:
            alone = "a state in which the task has ended is no option, or one was similar enough"
        return f"No option was made: {alone}."
    said = []
    for event in made[:_TOLD_OPTIONS]:
        where = "a root" if event.parent == NO_OPTION else f"a child of {event.parent}"
        value = _seen(amounts(view.values[event.option], spec), spec)
        said.append(f"Option {event.option} was made, {where}; it stands for {value}.")
    if len(made) > _TOLD_OPTIONS:
        said.append(f"So were {count(len(made) - _TOLD_OPTIONS, 'other option')}.")
    links = cycle.of(GrowthKind.LINKED)
    if links:
        parents = "further parent" if len(links) == 1 else "further parents"
        told = ", ".join(f"{event.parent} of {event.option}" for event in links[:_TOLD_OPTIONS])
        said.append(f"{len(links)} {parents} beside the tree: {told}.")
    return " ".join(said)


def _assimilate(cycle: Cycle, spec: TaskSpec) -> str:
    changed = len(cycle.options)
    said = []
    if cycle.visits:
        option, action = int(cycle.decision.voters[0]), spec.action_names[cycle.decision.action]
        said.append(f"Option {option} knows {action} from {count(cycle.visits, 'visit')} now.")
    if not changed:
        return " ".join(["No weight of an option that was there before changed.", *said])
    told = [
        f"option {cycle.options[row]}, {spec.action_names[cycle.actions[row]]}: "
        f"{change_of(cycle, row)}"
        for row in range(min(TOLD_CHANGES, changed))
    ]
    lead = f"{count(changed, 'weight')} changed" + (", the most: " if changed > 1 else ": ")
    said.insert(0, f"{lead}{'; '.join(told)}.")
    if cycle.of(GrowthKind.ATTENTION):
        said.append("Attention changed, too, and with it how all options are compared.")
    return " ".join(said)


def _cleanse(cycle: Cycle) -> str:
    gone = cycle.of(GrowthKind.REMOVED)
    if not gone:
        return "No option was let go in this step."
    told = []
    for event in gone[:_TOLD_OPTIONS]:
        into = f" into {event.parent}" if event.parent != NO_OPTION else ""
        told.append(f"{event.option}{into}")
    more = f" and {len(gone) - _TOLD_OPTIONS:,} more" if len(gone) > _TOLD_OPTIONS else ""
    return f"{count(len(gone), 'option')} let go or merged: {', '.join(told)}{more}."
