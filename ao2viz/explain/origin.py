"""Where a weight comes from: the imagined story that set it, opened step by step.

For the `anticipating` preset; what set a weight of the `paper` preset is in `ledger`.
"""

from dataclasses import dataclass

import numpy as np

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.mind import Mind, Story
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.words import amounts, count, number, percent


@dataclass(frozen=True)
class End:
    """One option near where an imagined story ends."""

    option: int
    share: float
    worth: float  # Of being there: its greatest weight, but for the chance of a slip.


@dataclass(frozen=True)
class Trace:
    """The best real trace that left the option by the action, where traces are kept."""

    reward: float  # Discounted sum.
    discount: float
    end: int  # NO_OPTION: the task ended there.
    worth: float  # All in all, as its end is worth now.


@dataclass(frozen=True, eq=False)
class Origin:
    """Where one weight comes from: reward + discount · Σ share · worth of the ends."""

    option: int
    action: int
    weight: float  # As the agent has it.
    visits: int  # How often the option tried the action itself.
    born: int  # The agent's step at which the option was made.
    story: Story  # Imagined anew from experience as it is now.
    ends: tuple[End, ...]
    imagined: float  # What the story comes to; NaN if it has no step.
    trace: Trace | None  # None: none was kept.
    is_by_trace: bool  # Whether the weight is the real trace's, not the imagined story's.
    has_moved_on: bool  # Experience has changed since the story that set the weight was imagined.
    explained: float  # What the parts come to: the weight, unless something has moved on.
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.


def explain_weight(mind: Mind, option: int, action: int) -> Origin:
    """Opens the weight of an action at an option.

    Raises:
        ValueError: If there is no such living option or action, or the agent imagines nothing.
    """
    view = mind.view
    if not (0 <= option < len(view.is_alive) and view.is_alive[option]):
        raise ValueError(
            f"There is no living option {option}; ids go from 0 to {len(view.is_alive) - 1}, and "
            f"{len(view):,} options are alive."
        )
    if not 0 <= action < view.weights.shape[1]:
        raise ValueError(
            f"Expected an action from 0 to {view.weights.shape[1] - 1}, but got {action}."
        )
    story = mind.retell(option, action)
    known = mind.known
    assert known is not None  # `retell` has asked for it.
    value = known.imagination.value
    ends = tuple(
        End(int(end), float(share), float(value[end]))
        for end, share in zip(story.end_ids, story.end_shares, strict=True)
    )
    imagined = np.nan
    if story.steps:
        after = sum(end.share * end.worth for end in ends)
        imagined = story.reward + story.discount * after
    trace = _trace_of(mind, option, action)
    is_by_trace = trace is not None and not trace.worth <= imagined
    explained = imagined if story.steps else 0.0
    if is_by_trace and trace is not None:
        explained = trace.worth
    return Origin(
        option=option,
        action=action,
        weight=float(view.weights[option, action]),
        visits=int(view.visits[option, action]),
        born=int(view.born[option]),
        story=story,
        ends=ends,
        imagined=float(imagined),
        trace=trace,
        is_by_trace=is_by_trace,
        has_moved_on=not is_as_kept(mind, option, action, story),
        explained=float(explained),
    )


def is_as_kept(mind: Mind, option: int, action: int, story: Story) -> bool:
    """Whether a story imagined now is, to the bit, the one that the weight rests on."""
    assert mind.known is not None
    kept = mind.known.imagination
    if kept.steps[option, action] != len(story.steps):
        return False
    if not story.steps:
        return True
    ids, shares = kept.end_ids[option, action], kept.end_shares[option, action]
    has_say = ids != NO_OPTION
    return bool(
        kept.reward[option, action] == story.reward
        and kept.discount[option, action] == story.discount
        and np.array_equal(ids[has_say], story.end_ids)
        and np.array_equal(shares[has_say], story.end_shares)
    )


def _trace_of(mind: Mind, option: int, action: int) -> Trace | None:
    assert mind.known is not None
    kept = mind.known.imagination
    reward = float(kept.story_reward[option, action])
    if np.isnan(reward):
        return None
    discount, end = float(kept.story_discount[option, action]), int(kept.story_end[option, action])
    worth = reward if end == NO_OPTION else reward + discount * float(kept.value[end])
    return Trace(reward, discount, end, worth)


def tell_origin(origin: Origin, spec: TaskSpec) -> tuple[str, ...]:
    """The explanation in sentences: what it comes to, every step, and where it ends."""
    name = spec.action_names[origin.action]
    head = f"Option {origin.option} expects {number(origin.weight)} of {name}. It has been there "
    head += f"since step {origin.born:,} and tried it {count(origin.visits, 'time')}."
    lines = [head]
    steps = origin.story.steps
    if not steps:
        lines.append(f"What {name} does there is unknown: no option near has tried it.")
    for n, step in enumerate(steps, start=1):
        where = ", ".join(
            f"{feature.name} {shown}"
            for feature, shown in zip(spec.features, amounts(step.after, spec), strict=True)
        )
        text = f"{n}. {name}: earns {number(step.reward)}"
        if step.ending > 0:
            text += f", ends with a chance of {percent(step.ending)}"
        lines.append(f"{text}, to {where}; known from {count(step.visits, 'visit')}.")
    if steps:
        where = ", ".join(
            f"{end.option} ({percent(end.share)}, worth {number(end.worth)})"
            for end in sorted(origin.ends, key=lambda end: -end.share)
        )
        lines.append(f"It ends near {where}.")
        after = number(origin.imagined - origin.story.reward)
        lines.append(
            f"So {number(origin.story.reward)} on the way and {after} after it, both discounted: "
            f"{number(origin.imagined)}."
        )
    if origin.is_by_trace and origin.trace is not None:
        lines.append(
            f"A real trace that earned more is kept beside it, and counts: "
            f"{number(origin.trace.worth)}."
        )
    if origin.has_moved_on:
        lines.append("Experience has moved on since the story that set this weight was imagined.")
    elif not np.isclose(origin.explained, origin.weight, rtol=1e-3):
        lines.append(
            "What its ends are worth has changed since; the weight is renewed when its turn comes."
        )
    return tuple(lines)
