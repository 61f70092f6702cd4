"""The `anticipating` preset: options that also learn what follows each action, and imagine.

An option with expectations is Neisser's anticipatory schema (Cognition and Reality, 1976); how
it learns is model-based value iteration on the options themselves (Sutton's Dyna, 1990).
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.arrays import Arrays, take_array
from ao2viz.core.assimilation import allocate_trace, settle
from ao2viz.core.attention import RunningSpread, attention_from, has_changed
from ao2viz.core.cleansing import apply_cleansing, plan_cleansing
from ao2viz.core.config import AnticipatingConfig
from ao2viz.core.decision import NO_OPTION, Decision
from ao2viz.core.experience import learn_law
from ao2viz.core.forest import Forest, ForestView
from ao2viz.core.growth import GrowthEvent
from ao2viz.core.imagination import rules_of
from ao2viz.core.impression import make_impression
from ao2viz.core.inference import Reading, act, count_ends, decide
from ao2viz.core.living import Life, Place, PlainLife, allocate_links, arrive, live, plain_life
from ao2viz.core.local_linear import make_workspace
from ao2viz.core.memory import (
    Memory,
    allocate_memory,
    memory_from_arrays,
    memory_to_arrays,
    reserve,
)
from ao2viz.core.regrowth import regrow
from ao2viz.core.relevance import find_relevance
from ao2viz.core.thinking import Clock, Horizon, standing_clock, think_over
from ao2viz.core.transition import Transition


class AnticipatingLearner:
    """Learns what follows each action and plans on it; see `Learner` for the life of an episode.

    Nothing is grown during the first `warmup_steps` steps: they are kept, and learned from as
    soon as their spread has set the attention.
    """

    def __init__(
        self,
        config: AnticipatingConfig,
        ranges: NDArray[np.float64],
        n_actions: int,
        rng: np.random.Generator,
        clock: Clock = standing_clock,
    ) -> None:
        self.config = config
        self.n_steps = 0
        self._rng = rng
        self._clock = clock
        self._n_features = len(ranges)
        self._n_actions = n_actions
        self._n_ends = count_ends(config.voters, self._n_features)
        self._rules = rules_of(config)
        self._spread = RunningSpread(self._n_features)
        self._impression = make_impression(self._n_features, config.impression)
        self._grown_at = np.zeros(self._n_features)  # Deviations that attention is measured by.
        self._next_check = config.warmup_steps
        self._next_law = 0  # The step from which on the laws are due to be learned anew.
        self._waiting: list[Transition] = []  # Warm-up steps not learned from yet.
        self._cursors = np.zeros(2, np.int64)
        forest = Forest(self._n_features, n_actions, np.zeros(self._n_features))
        memory = allocate_memory(forest, self._n_ends, config.law_degree)
        self._forest, self._experience, self._imagination = memory
        self._work = make_workspace(config.voters, self._n_features, n_actions)
        self._trace = allocate_trace(self._rules)
        self._links = allocate_links()
        self._observation = np.zeros(self._n_features)
        self._forget_episode()

    def start(self, observation: NDArray[np.float64]) -> tuple[GrowthEvent, ...]:
        """Begins an episode; see `Learner`."""
        events: list[GrowthEvent] = []
        self._forget_episode()
        self._observation = observation
        if self.n_steps < self.config.warmup_steps:
            if self._waiting:
                self._waiting[-1] = self._waiting[-1]._replace(ended=True)
            self._spread.add(observation)
            return ()
        if self.n_steps >= self._next_check:
            self._check_attention(events)
        if self.n_steps >= self._next_law:
            self._learn_laws()
        self._spread.add(observation)
        self._here = self._situate(observation, events)
        return tuple(events)

    def decide(self, explore: bool = True) -> Decision:
        """Decides for the latest observation; see `Learner`."""
        if explore and self._rng.random() < self._epsilon():
            # What is drawn at random needs no thinking ahead.
            drawn = int(self._rng.integers(self._n_actions))
            return self._ask(self._observation, self._created, drawn)
        return self._think(self._ask(self._observation, self._created))

    def observe(
        self,
        decision: Decision,
        reward: float,
        observation: NDArray[np.float64],
        terminated: bool,
        truncated: bool,
    ) -> tuple[GrowthEvent, ...]:
        """Learns from one step; see `Learner`."""
        events: list[GrowthEvent] = []
        ended = terminated or truncated
        step = Transition(
            self._observation, decision.action, reward, observation, terminated, ended
        )
        self.n_steps += 1
        self._spread.add(observation)
        self._observation = observation
        self._created = NO_OPTION
        if self.n_steps <= self.config.warmup_steps:
            self._waiting.append(step)
            if self.n_steps == self.config.warmup_steps:
                self._wake(events)
            return tuple(events)
        self._learn(step, events)
        return tuple(events)

    def decide_at(self, observation: NDArray[np.float64]) -> Decision:
        """What it would do if it saw this; see `Learner`."""
        return self._think(self._ask(observation))

    def act_at(self, observation: NDArray[np.float64]) -> int:
        """The action of `decide_at`; see `Learner`."""
        if self.config.think_ahead > 0:
            return self.decide_at(observation).action
        return act(self._forest, observation, self._reading(), self._work)

    def sleep(self) -> tuple[GrowthEvent, ...]:
        """Settles, then cleanses as far as the settings say; see `Learner`."""
        self._settle()
        return self.cleanse(self.config.cleansing) if self.config.cleansing > 0.0 else ()

    def cleanse(self, tolerance: float) -> tuple[GrowthEvent, ...]:
        """Lets go of options that it can do without; see `Learner`.

        The weights stay what was learned with all of them: to let them settle among those that
        are left would lose again what the plan took care to keep.
        """
        plan = plan_cleansing(self._forest, tolerance, self._rules, self._work)
        memory = Memory(self._forest, self._experience, self._imagination)
        events = apply_cleansing(memory, plan, self.config.experience_cap, self.n_steps)
        if self._here != NO_OPTION:  # In the middle of an episode.
            self._here = int(plan.stands_for(self._forest.n_rows)[self._here])
        if events:
            self._imagine_anew(sweeps=0)
        return tuple(events)

    def _settle(self) -> None:
        """Imagines everything anew by laws learned anew, and lets the values rest."""
        self._learn_laws()
        self._imagine_anew(self.config.sleep_sweeps)

    def _imagine_anew(self, sweeps: int) -> None:
        settle(
            self._forest.columns,
            self._experience,
            self._imagination,
            self._forest.heads,
            sweeps,
            self._rules,
            self._work,
        )

    def change(self, settings: Mapping[str, Any]) -> None:
        """Takes over other settings; see `Learner`."""
        self.config = replace(self.config, **settings)
        self._rules = rules_of(self.config)

    def view(self) -> ForestView:
        """A frozen copy of the forest; see `Learner`."""
        return self._forest.view()

    def get_state(self) -> Arrays:
        """Copies of everything needed to continue; see `Learner`."""
        memory = Memory(self._forest, self._experience, self._imagination)
        return {
            **memory_to_arrays(memory),
            **({} if self._impression is None else self._impression.get_state()),
            "spread": self._spread.moments.copy(),
            "grown_at": self._grown_at.copy(),
            "waiting": np.array([step.to_row() for step in self._waiting]).reshape(
                -1, 2 * self._n_features + 4
            ),
            **({"law_due": np.array(self._next_law)} if self.config.law_degree else {}),
            "counters": np.array([self.n_steps, self._next_check, *self._cursors], np.int64),
        }

    def set_state(self, state: Arrays) -> None:
        """Takes over what `get_state` gave; see `Learner`."""
        a, d = self._n_actions, self._n_features
        memory = memory_from_arrays(state, d, a, self._n_ends, self.config)
        counters = take_array(state, "counters", (4,), np.int64)
        due = take_array(state, "law_due", (), np.int64) if self.config.law_degree else 0
        spread = take_array(state, "spread", (3, d), np.float64)
        grown_at = take_array(state, "grown_at", (d,), np.float64)
        waiting = take_array(state, "waiting", (None, 2 * d + 4), np.float64)
        tried = waiting[:, 2 * d]
        if counters[1] < 1 or not all(np.isfinite(x).all() for x in (spread, grown_at, waiting)):
            raise ValueError("Expected a next check after step 0, and finite numbers.")
        if len(waiting) >= self.config.warmup_steps or ((tried < 0) | (tried >= a)).any():
            raise ValueError(f"Expected fewer waiting steps than the warm-up's, actions below {a}.")
        if self._impression is not None:
            self._impression.set_state(state)
        self._forget_episode()
        self._forest, self._experience, self._imagination = memory
        self.n_steps, self._next_check = int(counters[0]), int(counters[1])
        self._cursors = counters[2:].copy()
        self._next_law = int(due)
        self._spread.moments[:] = spread
        self._grown_at = grown_at.copy()
        self._waiting = [Transition.from_row(row) for row in waiting]

    def _reading(self) -> Reading:
        return Reading(self.config.decide_by, self.config.share_ridge, has_outlook=True)

    def _ask(
        self, observation: NDArray[np.float64], created: int = NO_OPTION, drawn: int | None = None
    ) -> Decision:
        return decide(self._forest, observation, self._reading(), self._work, created, drawn)

    def _think(self, decision: Decision) -> Decision:
        """The decision after thinking ahead, as far as the settings say."""
        if self.config.think_ahead == 0:
            return decision
        horizon = Horizon(self.config.think_ahead, self.config.think_limit / 1000, self._clock)
        mind = self._forest, self._experience, self._imagination
        return think_over(decision, *mind, horizon, self._rules, self._work)

    def _epsilon(self) -> float:
        config = self.config
        if self.n_steps < config.warmup_steps:
            return 1.0
        progress = min(self.n_steps / config.epsilon_steps, 1.0)
        return config.epsilon_start + (config.epsilon_end - config.epsilon_start) * progress

    def _forget_episode(self) -> None:
        self._here = NO_OPTION
        self._created = NO_OPTION
        self._trace.used[:] = 0

    def _situate(self, observation: NDArray[np.float64], events: list[GrowthEvent]) -> int:
        """The option that stands for an observation, accommodated if there is none."""
        query = self._forest.attention * observation
        return self._settle_in(arrive(self._roomy_life(), observation, query, self.n_steps), events)

    def _learn(self, step: Transition, events: list[GrowthEvent]) -> None:
        """Records a step, finds where it led, and thinks; `_here` moves on."""
        forest, option = self._forest, self._here
        if self._impression is not None:
            gap = step.before - forest.columns.values[option]
            self._impression.move(self._spread_attention() * gap, step.reward)
        place = live(
            self._roomy_life(),
            option,
            step.action,
            step.reward,
            forest.attention * step.before,
            step.after,
            forest.attention * step.after,
            step.terminated,
            step.ended,
            self.n_steps,
        )
        self._here = self._settle_in(place, events)

    def _roomy_life(self) -> PlainLife:
        """Everything that learning needs, with room for one more option."""
        memory = reserve(Memory(self._forest, self._experience, self._imagination))
        self._forest, self._experience, self._imagination = memory
        return plain_life(
            Life(
                self._forest.columns,
                self._forest.heads,
                self._experience,
                self._imagination,
                self._trace,
                self._cursors,
                self._links,
                self._rules,
                self._work,
            )
        )

    def _settle_in(self, place: Place, events: list[GrowthEvent]) -> int:
        """Takes note of the option that stands for where one is; gives its id."""
        option, is_new, covering = place
        if is_new:
            self._created = option
            events.append(self._forest.adopt(option, self.n_steps))
            for parent in sorted(self._links[:covering].tolist()):
                events.append(self._forest.link(parent, option, self.n_steps))
        return option

    def _wake(self, events: list[GrowthEvent]) -> None:
        """Ends the warm-up: sets the attention, then learns from the steps that waited."""
        self._grown_at = self._spread.deviation
        events.append(self._forest.set_attention(self._spread_attention(), self.n_steps))
        waiting, self._waiting = self._waiting, []
        for step in waiting:
            if self._here == NO_OPTION:
                self._here = self._situate(step.before, events)
            self._learn(step, events)
            if step.ended:
                self._forget_episode()
        self._next_check = 2 * self.config.warmup_steps
        self._learn_laws()

    def _learn_laws(self) -> None:
        """Fits what the actions do in general; due again after a fifth more steps."""
        learn_law(
            self._forest.columns, self._experience, self._forest.n_rows, self.config.experience_cap
        )
        self._next_law = self.n_steps + max(self.n_steps // 5, self.config.warmup_steps)

    def _spread_attention(self) -> NDArray[np.float64]:
        """[D] attention by how much the features varied when it was last looked at."""
        return attention_from(self._grown_at, self.config.attention_width)

    def _check_attention(self, events: list[GrowthEvent]) -> None:
        """Regrows the forest if attention has become too narrow, or looks past what matters."""
        while self._next_check <= self.n_steps:
            self._next_check *= 2
        growth = 1.0 + self.config.attention_growth
        deviation = self._spread.deviation
        if (deviation > growth * self._grown_at).any():
            self._grown_at = np.maximum(deviation, self._grown_at)
        attention = self._spread_attention()
        if self.config.attention_relevance > 0.0:
            relevance = find_relevance(self._forest, self._imagination.steps, attention)
            attention *= relevance**self.config.attention_relevance
        if self._impression is not None:
            attention *= self._impression.factors
        if not has_changed(self._forest.attention, attention, growth):
            return
        events += regrow(
            self._forest,
            self._experience,
            self._imagination,
            attention,
            self._rules,
            self.n_steps,
        )
        self._settle()
