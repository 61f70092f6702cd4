"""The whole agent: what it attends to, how well it knows where it goes, its telling moments.

Global explanations, over recorded states: they say what the agent did there, not everywhere.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.config import Config, PaperConfig
from ao2viz.core.decision import DecideBy, Decision
from ao2viz.core.mind import Mind
from ao2viz.explain.agreement import Faithfulness
from ao2viz.recording.episode import Episode

# As many states are asked at the most where every one takes many decisions.
MOST_STATES = 400
# As many are looked at where every one takes a search for the most similar options only.
MOST_SEARCHED = 20_000

Asking = Callable[[float], bool | None]
"""Told the share that is done; returning False ends it."""


@dataclass(frozen=True, eq=False)
class Attended:
    """What the distances of decisions were made of."""

    shares: NDArray[np.float64]  # [D] mean share of each feature in the distance that decided.
    runner_up_shares: NDArray[np.float64]  # [D] the same in the distance to the runner-up.
    states: int


def measure_attention(mind: Mind, states: NDArray[np.float64]) -> Attended:
    """Which features the distances to the two most similar options are made of, on average.

    A feature with a large share keeps what is seen and what is known apart; states [S, D] that
    are exactly an option's value have no distance and do not count.
    """
    totals, counted = np.zeros((2, len(mind.view.attention))), np.zeros(2)
    for state in states:
        for rank, option in enumerate(mind.forest.nearest(state, 2)[0]):
            parts = mind.view.attention * np.abs(state - mind.view.values[option])
            if parts.sum() > 0:
                totals[rank] += parts / parts.sum()
                counted[rank] += 1
    shares = totals / np.maximum(counted, 1)[:, None]
    return Attended(shares[0], shares[1], int(counted[0]))


@dataclass(frozen=True, eq=False)
class Roles:
    """Which options have a part in the decisions at some states, and which could be spared."""

    deciding: NDArray[np.int64]  # Options that spoke, the most frequent first.
    decided: NDArray[np.int64]  # How often each did.
    supporting: NDArray[np.int64]  # Options that never spoke, but that planes of others rest on.
    idle: int  # Living options that have no part in any of these decisions.
    redundant: NDArray[np.int64]
    """Of those that spoke: without one of them, no action at these states would be another."""
    states: int  # At which it was asked; fewer than were given if called off.
    tried: int  # Of those that spoke, the most frequent first: muted to see if they are redundant.


def find_roles(mind: Mind, states: NDArray[np.float64], on_progress: Asking | None = None) -> Roles:
    """Who decides at states [S, D], and who could be left out, one at a time.

    An option is muted and the agent is asked again wherever the option had a part. That several
    are redundant does not mean that all of them together are. Called off, it tells of the states
    that were asked, and of the options that were muted.
    """
    heard: dict[int, list[int]] = {}
    parts: dict[int, set[int]] = {}
    actions: list[int] = []

    def goes_on(share: float) -> bool:
        return on_progress is None or on_progress(share) is not False

    for place, state in enumerate(states):
        if not goes_on(0.5 * place / len(states)):
            break
        decision = mind.decide(state)
        actions.append(decision.action)
        for option in decision.voters[decision.shares > 0].tolist():
            heard.setdefault(option, []).append(place)
        for option in _with_a_part(mind, decision):
            parts.setdefault(option, set()).add(place)
    order = sorted(heard, key=lambda option: (-len(heard[option]), option))
    redundant, tried = [], 0
    for option in order if len(actions) == len(states) else []:
        if not goes_on(0.5 + 0.5 * tried / len(order)):
            break
        if _is_redundant(mind, states, actions, option, parts[option]):
            redundant.append(option)
        tried += 1
    supporting = sorted(set(parts) - set(heard))
    return Roles(
        deciding=np.array(order, np.int64),
        decided=np.array([len(heard[option]) for option in order], np.int64),
        supporting=np.array(supporting, np.int64),
        idle=len(mind.view) - len(parts),
        redundant=np.array(sorted(redundant), np.int64),
        states=len(actions),
        tried=tried,
    )


def _with_a_part(mind: Mind, decision: Decision) -> set[int]:
    """The options without which this decision could come out otherwise."""
    found = set(decision.voters.tolist())
    if decision.decide_by is DecideBy.PATH:
        for option in decision.voters:
            found |= set(mind.neighbours(int(option)).tolist())
    return found


def _is_redundant(
    mind: Mind,
    states: NDArray[np.float64],
    actions: Sequence[int],
    option: int,
    places: set[int],
) -> bool:
    with mind.muted(option):
        return all(mind.act(states[place]) == actions[place] for place in places)


@dataclass(frozen=True, eq=False)
class Coverage:
    """How well an agent knows where it goes."""

    radius: float  # Distance up to which an option stands for what is seen.
    distances: NDArray[np.float64]  # [S] from each state to the most similar option.
    share: float  # Of the states within the radius.
    farthest: int  # The state that is least like anything known, by its place.
    visits: float  # Median experiences of the most similar option.


@dataclass(frozen=True)
class Novelty:
    """How new an observation is to the agent."""

    distance: float  # To the most similar option.
    radius: float
    is_alarm: bool  # Farther than the radius: it has never met anything like it.
    visits: int  # Experiences of the most similar option.
    rank: float  # Share of the recorded states that are farther from what is known; 0: none is.
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.


def radius_of(mind: Mind) -> float:
    """Up to which distance a state belongs to an option: beyond, learning would make a new one."""
    return radius_in(mind.config)


def radius_in(config: Config) -> float:
    """The same, by an agent's settings alone."""
    if isinstance(config, PaperConfig):
        return 1.0 - config.threshold
    return 0.5**config.levels


def measure_coverage(mind: Mind, states: NDArray[np.float64]) -> Coverage:
    """How far states [S, D] are from the most similar options, and how well those are known."""
    found = [mind.forest.nearest(state) for state in states]
    distances = np.array([near[0] if len(near) else np.inf for _, near in found])
    visits = [int(mind.view.visits[ids[0]].sum()) if len(ids) else 0 for ids, _ in found]
    radius = radius_of(mind)
    return Coverage(
        radius=radius,
        distances=distances,
        share=float((distances <= radius).mean()) if len(distances) else 0.0,
        farthest=int(distances.argmax()) if len(distances) else 0,
        visits=float(np.median(visits)) if visits else 0.0,
    )


def measure_novelty(
    mind: Mind, observation: NDArray[np.float64], states: NDArray[np.float64]
) -> Novelty:
    """How new an observation [D] is, compared with recorded states [S, D]; raises the alarm."""
    ids, distances = mind.forest.nearest(observation)
    distance, radius = float(distances[0]) if len(ids) else np.inf, radius_of(mind)
    others = measure_coverage(mind, states).distances
    return Novelty(
        distance=distance,
        radius=radius,
        is_alarm=distance > radius,
        visits=int(mind.view.visits[ids[0]].sum()) if len(ids) else 0,
        rank=float((others > distance).mean()) if len(others) else 0.0,
    )


@dataclass(frozen=True)
class Highlight:
    """A moment that shows the agent's behaviour well, with what happened around it."""

    episode: int  # Recorded, counted from 0.
    step: int
    first: int  # Steps of the episode to be shown: from `first` to `last`, both included.
    last: int
    importance: float  # Of the choice: the greatest expectation less the least.


def find_highlights(
    episodes: Sequence[Episode], count: int = 5, around: int = 10
) -> tuple[Highlight, ...]:
    """The moments in which the choice matters most, the most important first.

    HIGHLIGHTS (Amir and Amir, Highlights: Summarizing agent behavior to people, AAMAS 2018): a
    state is as important as the best action is better than the worst. Moments whose surroundings
    overlap show the same twice, so only the more important of them is kept.
    """
    moments = [
        (float(np.ptp(decision.action_values)), n, t)
        for n, episode in enumerate(episodes)
        for t, decision in enumerate(episode.decisions)
    ]
    found: list[Highlight] = []
    for importance, n, t in sorted(moments, key=lambda moment: (-moment[0], *moment[1:])):
        first, last = max(0, t - around), min(len(episodes[n]) - 1, t + around)
        if any(h.episode == n and first <= h.last and h.first <= last for h in found):
            continue
        found.append(Highlight(n, t, first, last, importance))
        if len(found) == count:
            break
    return tuple(found)


@dataclass(frozen=True)
class Muted:
    """What the return is without one option."""

    option: int
    mean_return: float
    loss: float  # Mean over the episodes of the return with it less that without it.
    standard_error: float  # Of the loss, the episodes being the same; NaN for a single one.


@dataclass(frozen=True)
class Carriers:
    """What the options that were muted are worth to the return, the dearest first."""

    mean_return: float  # With all of them.
    episodes: int
    seed: int  # Episode i begins as evaluation episode i of this seed.
    muted: tuple[Muted, ...]
    is_complete: bool  # False: called off before all were muted.
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.


@dataclass(frozen=True)
class Disagreement:
    """A state at which two agents choose differently."""

    place: int  # Of the state in those that were compared.
    one: int  # The first agent's action.
    other: int  # The second's.
    one_cares: float  # By how much the first prefers its own over the other's action.
    other_cares: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """Where two agents disagree, those moments first that matter most to both."""

    states: NDArray[np.float64]  # [S, D] at which both were asked.
    disagreements: tuple[Disagreement, ...]
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.

    @property
    def share(self) -> float:
        """Of the states at which they disagree."""
        return len(self.disagreements) / max(len(self.states), 1)


def compare_minds(one: Mind, other: Mind, states: NDArray[np.float64]) -> Comparison:
    """Asks two agents at states [S, D].

    Raises:
        ValueError: If they do not see the same features or have the same actions.
    """
    shapes = [(mind.forest.n_features, mind.forest.n_actions) for mind in (one, other)]
    if shapes[0] != shapes[1]:
        raise ValueError(
            f"Expected two agents of the same task, but one has {shapes[0][0]} features and "
            f"{shapes[0][1]} actions, the other {shapes[1][0]} and {shapes[1][1]}."
        )
    found = []
    for place, state in enumerate(states):
        mine, theirs = one.decide(state), other.decide(state)
        if mine.action == theirs.action:
            continue
        found.append(
            Disagreement(
                place,
                mine.action,
                theirs.action,
                float(mine.action_values[mine.action] - mine.action_values[theirs.action]),
                float(theirs.action_values[theirs.action] - theirs.action_values[mine.action]),
            )
        )
    found.sort(key=lambda moment: (-min(moment.one_cares, moment.other_cares), moment.place))
    return Comparison(states, tuple(found))


@dataclass(frozen=True, eq=False)
class Overview:
    """An agent at a glance, over its recorded states."""

    attention: Attended
    roles: Roles
    coverage: Coverage
    highlights: tuple[Highlight, ...]
    faithfulness: Faithfulness | None  # None: nothing is recorded.


def states_of(mind: Mind, episodes: Sequence[Episode]) -> NDArray[np.float64]:
    """[S, D] the states in which recorded decisions were made; the options' values if none."""
    recorded = [episode.observations[:-1] for episode in episodes if len(episode)]
    return np.concatenate(recorded) if recorded else mind.view.values[mind.view.is_alive]


def moment_of(place: int, episodes: Sequence[Episode]) -> tuple[int, int] | None:
    """Episode and step of a recorded state by its place in `states_of`; None: there is none."""
    for number, episode in enumerate(episodes):
        if place < len(episode):
            return number, place
        place -= len(episode)
    return None


def sample_states(states: NDArray[np.float64], most: int = MOST_STATES) -> NDArray[np.float64]:
    """States [S, D] spread evenly over those given, no more than so many."""
    return states[sample_places(len(states), most)]


def sample_places(count: int, most: int) -> NDArray[np.int64]:
    """Places from 0 on, spread evenly over so many, no more than `most`."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(np.int64))
