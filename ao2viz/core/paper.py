"""The `paper` preset: the closest reading of Hakimzadeh, Xue and Setoodeh that learns.

Where the paper is silent or contradicts itself, `docs/algorithm.md` says how it was settled.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.arrays import Arrays, take_array
from ao2viz.core.config import Credit, PaperConfig
from ao2viz.core.decision import NO_OPTION, Decision
from ao2viz.core.forest import Forest, ForestView
from ao2viz.core.growth import GrowthEvent
from ao2viz.core.impression import make_impression
from ao2viz.core.inference import Reading, act, decide
from ao2viz.core.ledger import Ledger
from ao2viz.core.local_linear import make_workspace


class PaperLearner:
    """Algorithms 1 to 3 of the paper; see `Learner` for the life of an episode.

    Similarity is 1 - mean(|U - V| / range), so with attention 1 / (D · range) the distance of
    equation 1 is 1 - similarity. All options form one schema, as Algorithm 2 grows it.
    """

    def __init__(
        self,
        config: PaperConfig,
        ranges: NDArray[np.float64],
        n_actions: int,
        rng: np.random.Generator,
    ) -> None:
        self.config = config
        self.n_steps = 0
        self.ledger: Ledger | None = None  # Who wants to know what moves a weight sets it.
        self._rng = rng
        self._n_actions = n_actions
        self._per_range = 1.0 / ranges
        self._attention = self._per_range / len(ranges)  # Before any impression.
        self._impression = make_impression(len(ranges), config.impression)
        self._forest = Forest(len(ranges), n_actions, self._attention)
        self._work = make_workspace(config.voters, len(ranges), n_actions)
        self._observation = np.zeros(len(ranges))
        self._forget_episode()

    def start(self, observation: NDArray[np.float64]) -> tuple[GrowthEvent, ...]:
        """Begins an episode; the very first observation becomes the root. See `Learner`."""
        self._forget_episode()
        self._observation = observation
        if self._forest.n_rows == 0:
            return (self._forest.add(observation, NO_OPTION, self.n_steps),)
        if self._impression is None:
            return ()
        # Once an episode: every change of attention makes the index of all options anew.
        attention = self._attention * self._impression.factors
        return (self._forest.set_attention(attention, self.n_steps),)

    def decide(self, explore: bool = True) -> Decision:
        """Decides for the latest observation; see `Learner`."""
        decision = self.decide_at(self._observation)
        if not explore:
            return decision
        if self._deserves_option(decision):
            decision = replace(decision, created=self._forest.n_rows)  # `observe` makes it.
        if self.config.epsilon > 0 and self._rng.random() < self.config.epsilon:
            return replace(decision, action=int(self._rng.integers(self._n_actions)), explored=True)
        return decision

    def observe(
        self,
        decision: Decision,
        reward: float,
        observation: NDArray[np.float64],
        terminated: bool,
        truncated: bool,
    ) -> tuple[GrowthEvent, ...]:
        """Reforms the structure, then applies the reward; see `Learner`."""
        self.n_steps += 1
        selected = int(decision.voters[0])
        if self.config.failure_only:
            reward = -1.0 if terminated else 0.0
        self._trace.append((selected, decision.action, reward))
        if self._impression is not None:
            gap = decision.observation - self._forest.columns.values[selected]
            self._impression.move(self._per_range * gap, reward)
        events = self._accommodate(decision, selected)
        self._observation = observation
        self._assimilate(reward, ended=terminated or truncated, terminated=terminated)
        return events

    def decide_at(self, observation: NDArray[np.float64]) -> Decision:
        """What it would do if it saw this; see `Learner`."""
        return decide(self._forest, observation, self._reading(), self._work)

    def act_at(self, observation: NDArray[np.float64]) -> int:
        """The action of `decide_at`; see `Learner`."""
        return act(self._forest, observation, self._reading(), self._work)

    def sleep(self) -> tuple[GrowthEvent, ...]:
        """The paper knows no sleep; nothing is left to settle."""
        return ()

    def cleanse(self, tolerance: float) -> tuple[GrowthEvent, ...]:
        """Refuses; see `Learner`."""
        raise ValueError(
            "In the paper preset every option decides by its own weights alone, so there is no "
            "telling what is lost with one; the anticipating preset can be cleansed."
        )

    def change(self, settings: Mapping[str, Any]) -> None:
        """Takes over other settings; see `Learner`."""
        self.config = replace(self.config, **settings)

    def view(self) -> ForestView:
        """A frozen copy of the forest; see `Learner`."""
        return self._forest.view()

    def get_state(self) -> Arrays:
        """Copies of everything needed to continue; see `Learner`."""
        impression = {} if self._impression is None else self._impression.get_state()
        counters = np.array([self.n_steps], np.int64)
        return {**self._forest.get_state(), **impression, "counters": counters}

    def set_state(self, state: Arrays) -> None:
        """Takes over what `get_state` gave; see `Learner`."""
        forest = Forest(self._forest.n_features, self._n_actions, self._attention)
        forest.set_state(state)
        n_steps = int(take_array(state, "counters", (1,), np.int64)[0])
        if self._impression is not None:
            self._impression.set_state(state)
        self.n_steps = n_steps
        self._forest = forest
        self._forget_episode()

    def _reading(self) -> Reading:
        return Reading(self.config.decide_by, self.config.share_ridge, has_outlook=False)

    def _forget_episode(self) -> None:
        # (option, action, reward), the newest last.
        self._trace: deque[tuple[int, int, float]] = deque(maxlen=self.config.trace_length)

    def _deserves_option(self, decision: Decision) -> bool:
        """Similarity ≤ threshold, written as a distance."""
        return 1.0 - decision.distance <= self.config.threshold

    def _accommodate(self, decision: Decision, selected: int) -> tuple[GrowthEvent, ...]:
        """Algorithm 2: a child for the selected option, if that is not similar enough.

        Where that would be too deep, the child goes to the nearest ancestor that may have it.
        """
        if not self._deserves_option(decision):
            return ()
        if self.config.max_depth > 0:
            columns = self._forest.columns
            while columns.depths[selected] >= self.config.max_depth:
                selected = int(columns.parents[selected])
        return (self._forest.add(decision.observation, selected, self.n_steps),)

    def _assimilate(self, reward: float, ended: bool, terminated: bool) -> None:
        """Algorithm 3: gives each action of the trace its part of what was earned."""
        trace, config = self._trace, self.config
        if config.credit is Credit.ACCUMULATE:
            credit = reward
            newest, chosen, _ = trace[-1]
            self._forest.columns.visits[newest, chosen] += 1
            for delay, (option, action, _) in enumerate(reversed(trace)):
                self._forest.columns.weights[option, action] += credit
                credit *= config.gamma
                if self.ledger is not None and self.ledger.is_about(option, action):
                    self.ledger.add(self.n_steps - delay, delay, reward)
            return
        after = 0.0
        if config.credit is Credit.BOOTSTRAP and not terminated:
            nearest, _ = self._forest.nearest(self._observation)
            after = float(self._forest.columns.weights[nearest[0]].max())
        if len(trace) == config.trace_length:
            self._move_weight(after)
            trace.popleft()  # Each step's action is moved once, also by the step that ends it all.
        if terminated or (ended and config.credit is Credit.BOOTSTRAP):
            # The last actions get what there was to earn. A time limit only hides the rest of a
            # return, which would look better than it is.
            while trace:
                self._move_weight(after)
                trace.popleft()

    def _move_weight(self, after: float) -> None:
        """Moves the oldest action's weight towards the discounted return of its trace."""
        earned = after
        for _, _, reward in reversed(self._trace):
            earned = reward + self.config.gamma * earned
        option, action, _ = self._trace[0]
        columns = self._forest.columns
        # Counted here, so that the first return sets the weight instead of being mixed with 0.
        columns.visits[option, action] += 1
        rate = max(self.config.step_size, 1.0 / columns.visits[option, action])
        columns.weights[option, action] += rate * (earned - columns.weights[option, action])
        if self.ledger is not None and self.ledger.is_about(option, action):
            rewards = [reward for _, _, reward in self._trace]
            self.ledger.move(self.n_steps - len(rewards) + 1, rewards, after, rate)
