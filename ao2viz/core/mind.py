"""A mind: what an agent has learned, as a copy that can be asked anything and taught nothing."""

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.columns import Columns
from ao2viz.core.compiled import compiled
from ao2viz.core.config import AnticipatingConfig, Config
from ao2viz.core.decision import DecideBy, Decision
from ao2viz.core.experience import Experience, count_visits, predict
from ao2viz.core.forest import Forest, ForestView
from ao2viz.core.imagination import Imagination, Rules, allocate_trail, repeat, rules_of
from ao2viz.core.index import forget_option, index_option
from ao2viz.core.inference import (
    Reading,
    act,
    count_ends,
    count_speakers,
    decide,
    find_shares,
    look_around,
)
from ao2viz.core.local_linear import Workspace, make_workspace
from ao2viz.core.memory import memory_from_arrays
from ao2viz.core.thinking import Horizon, standing_clock, think_over


class Planes(NamedTuple):
    """What options expect around their values: `n` options, A actions, D features.

    At an observation an option expects level + Σ slope · (scaled observation − scaled value).
    """

    levels: NDArray[np.float64]  # [n, A] at the option's value.
    slopes: NDArray[np.float64]  # [n, A, D] per unit of scaled distance.


class Known(NamedTuple):
    """What the `anticipating` preset knows beside its forest; see the two types."""

    experience: Experience
    imagination: Imagination
    rules: Rules


@dataclass(frozen=True, eq=False)
class Step:
    """What an agent expects of one step of the environment."""

    after: NDArray[np.float64]  # [D] environment units.
    reward: float
    ending: float  # Chance that the task ends in this step.
    visits: int  # How often the action was tried by the options that this rests on.


@dataclass(frozen=True, eq=False)
class Story:
    """What repeating an action at an option is imagined to lead to; see `imagination`."""

    steps: tuple[Step, ...]  # Empty: what the action does is unknown.
    reward: float  # Discounted sum.
    discount: float  # Of what comes after.
    end_ids: NDArray[np.int64]  # [K] options where it ends.
    end_shares: NDArray[np.float64]  # [K] their say there, as it is kept: in single precision.


class Mind:
    """An agent's mind at one moment. It decides exactly as the agent did then.

    Every explanation asks a mind and not the agent: whatever the agent learns meanwhile, what is
    explained stays what it was. It has work space of its own, so it belongs to one thread;
    `copy` makes another.
    """

    def __init__(self, config: Config, state: Mapping[str, NDArray]) -> None:
        """Takes what `Learner.get_state` gave, or what a file holds.

        Raises:
            ValueError: If the arrays describe no forest.
        """
        self.config = config
        self._state = state
        n_actions, n_features = state["weights"].shape[1], state["values"].shape[1]
        self.known: Known | None = None
        if isinstance(config, AnticipatingConfig) and "experience_reward" in state:
            ends = count_ends(config.voters, n_features)
            memory = memory_from_arrays(dict(state), n_features, n_actions, ends, config)
            self.forest = memory.forest
            self.known = Known(memory.experience, memory.imagination, rules_of(config))
        else:
            self.forest = Forest(n_features, n_actions, np.zeros(n_features))
            self.forest.set_state(state)
        self.view: ForestView = self.forest.view()
        self.work: Workspace = make_workspace(config.voters, n_features, n_actions)
        n = self.forest.n_rows
        self._is_fitted = np.zeros(n, np.bool_)
        self._planes = Planes(np.empty((n, n_actions)), np.empty((n, n_actions, n_features)))

    @classmethod
    def from_view(cls, view: ForestView, config: Config) -> Self:
        """The mind of a forest alone: it decides, but knows nothing of what follows.

        It cannot think ahead either: if the config says so, the mind goes by the outlook.
        """
        return cls(config, state_of(view))

    def copy(self) -> "Mind":
        """Another mind of the same contents, for another thread."""
        return Mind(self.config, self._state)

    @property
    def reading(self) -> Reading:
        """How its forest is read to decide."""
        has_outlook = isinstance(self.config, AnticipatingConfig)
        return Reading(self.config.decide_by, self.config.share_ridge, has_outlook)

    @property
    def thinks_ahead(self) -> bool:
        """Whether its decisions rest on imagined sequences of actions."""
        return self.known is not None and vars(self.config).get("think_ahead", 0) > 0

    @property
    def is_piecewise_linear(self) -> bool:
        """Whether one option decides by its plane, so that flips can be told exactly."""
        return self.config.decide_by is DecideBy.PATH and not self.thinks_ahead

    def decide(self, observation: NDArray[np.float64]) -> Decision:
        """What the agent decides, seeing this [D]; thinking ahead takes as long as it takes."""
        decision = decide(self.forest, observation, self.reading, self.work)
        if not self.thinks_ahead:
            return decision
        config, known = self.config, self.known
        assert isinstance(config, AnticipatingConfig)
        assert known is not None
        horizon = Horizon(config.think_ahead, 0.0, standing_clock)
        mind = self.forest, known.experience, known.imagination
        return think_over(decision, *mind, horizon, known.rules, self.work)

    def act(self, observation: NDArray[np.float64]) -> int:
        """The action of `decide`."""
        if self.thinks_ahead:
            return self.decide(observation).action
        return act(self.forest, observation, self.reading, self.work)

    def planes(self, options: Sequence[int] | NDArray[np.integer]) -> Planes:
        """The planes by which these options decide when they are the most similar; kept.

        Without outlooks a plane is level: the option's own weights.
        """
        options = np.asarray(options, np.int64)
        missing = options[~self._is_fitted[options]]
        if len(missing):
            if self.reading.has_outlook:
                _find_planes(
                    self.forest.columns, missing, self.reading.ridge, self.work, *self._planes
                )
            else:
                self._planes.levels[missing] = self.view.weights[missing]
                self._planes.slopes[missing] = 0.0
            self._is_fitted[missing] = True
        return Planes(self._planes.levels[options], self._planes.slopes[options])

    def neighbours(self, option: int) -> NDArray[np.int64]:
        """The options whose weights an option's plane rests on, itself among them."""
        if not self.reading.has_outlook:
            return np.array([option], np.int64)
        wanted = count_speakers(self.config.voters, self.forest.n_features)
        return self.forest.nearest(self.view.values[option], wanted)[0]

    def expect(self, observation: NDArray[np.float64], action: int) -> Step | None:
        """What an action would do at an observation [D]; None if it does not know.

        Raises:
            ValueError: If this mind has not learned what follows an action.
        """
        known = self._known()
        columns, rules, work = self.forest.columns, known.rules, self.work
        state = self.view.attention * observation
        count = predict(
            columns, known.experience, state, action, rules.radius, rules.effect_ridge, work
        )
        if count == 0:
            return None
        *moved, reward, ending = work.effect.tolist()
        visits = count_visits(columns.visits, action, count, work)
        return Step(self._unscaled(state + moved, observation), reward, ending, int(visits))

    def retell(self, option: int, action: int) -> Story:
        """Imagines the story of an option and action anew, from experience as it is now.

        Raises:
            ValueError: If this mind has not learned what follows an action.
        """
        known = self._known()
        columns, rules, work = self.forest.columns, known.rules, self.work
        trail = allocate_trail(rules.imagine_limit, self.forest.n_features)
        count, reward, discount = repeat(
            columns, known.experience, option, action, rules, work, trail
        )
        value = self.view.values[option]
        steps = tuple(
            Step(
                self._unscaled(trail.states[n], value),
                float(trail.rewards[n]),
                float(trail.endings[n]),
                int(trail.visits[n]),
            )
            for n in range(count)
        )
        ends = find_shares(columns, work.state, rules.share_ridge, False, work) if count else 0
        has_say = work.shares[:ends] > 0
        return Story(
            steps,
            reward,
            discount,
            work.ids[:ends][has_say],
            work.shares[:ends][has_say].astype(np.float32).astype(np.float64),
        )

    def _known(self) -> Known:
        if self.known is None:
            raise ValueError(
                "Expected an agent that has learned what follows an action, as those of the "
                "anticipating preset do; this one imagines nothing."
            )
        return self.known

    def _unscaled(
        self, state: NDArray[np.float64], before: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """A scaled state in environment units; what has never varied stays as it was before."""
        attention, after = self.view.attention, np.array(before, np.float64)
        return np.divide(state, attention, out=after, where=attention > 0)

    @contextlib.contextmanager
    def muted(self, option: int) -> Iterator[None]:
        """Within `with`, it decides as if there were no such option; `planes` must not be asked."""
        columns = self.forest.columns
        forget_option(columns.places, columns.scaled, option)
        try:
            yield
        finally:
            self.forest.reserve(0)
            columns = self.forest.columns
            index_option(columns.places, columns.scaled, option)


def state_of(view: ForestView) -> dict[str, NDArray]:
    """A forest alone as the arrays that a mind is made of."""
    return {
        "values": view.values,
        "parents": view.parents.astype(np.int32),
        "is_alive": view.is_alive,
        "born": view.born,
        "weights": view.weights,
        "visits": view.visits.astype(np.int32),
        "links": view.links.astype(np.int32),
        "attention": view.attention,
        "revision": np.array(view.revision, np.int64),
    }


@compiled
def _find_planes(
    columns: Columns,
    options: NDArray[np.int64],
    ridge: float,
    work: Workspace,
    levels: NDArray[np.float64],
    slopes: NDArray[np.float64],
) -> None:
    """Writes the outlook of each of these options into its row of the [N, A] and [N, A, D]."""
    for option in options:
        look_around(columns, option, ridge, work, levels[option])
        slopes[option] = work.slopes
