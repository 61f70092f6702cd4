"""`agent.explain`: everything that can be asked of an agent about its decisions."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ao2viz.core.config import PaperConfig
from ao2viz.core.decision import Decision
from ao2viz.core.learner import Learner
from ao2viz.core.ledger import Ledger
from ao2viz.core.mind import Mind
from ao2viz.core.paper import PaperLearner
from ao2viz.envs.ranges import Ranges, ranges_of, unlimited
from ao2viz.envs.task import TaskSpec, to_observation
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.ahead import Ahead, look_ahead
from ao2viz.explain.background import Background
from ao2viz.explain.contrast import WhyNot, explain_why_not
from ao2viz.explain.faithful import Trials
from ao2viz.explain.flips import Flips, explain_flips
from ao2viz.explain.forgetting import Forgotten, compare_without
from ao2viz.explain.ledger import Account, close_ledger
from ao2viz.explain.nearest import NearestFlip, Progress, find_nearest_flip
from ao2viz.explain.option import WholeOption, explain_option
from ao2viz.explain.origin import Origin, explain_weight
from ao2viz.explain.telling import CHECKS, Told, tell
from ao2viz.explain.whole import Comparison, Novelty, sample_states
from ao2viz.explain.why import Why, explain_why
from ao2viz.training.relearning import Progress as LearningProgress
from ao2viz.training.relearning import check_same, learn_again
from ao2viz.whole import WholeAgent

if TYPE_CHECKING:
    from ao2viz.agent import AO2

Situation = ArrayLike | Decision
"""What is asked about: an observation [D], or a recorded decision."""


class Explainer:
    """Explains an agent as it was when this was made; what it learns later changes nothing here.

    ```python
    explain = agent.explain
    why = explain.why([0.0, 0.0, 0.05, 0.0])
    print(explain.tell(why))
    ```

    What is asked about is an observation, or a decision out of a recorded episode. Such a decision
    is explained as it was made; what *would* be is asked of the agent as it is.
    """

    def __init__(self, agent: "AO2") -> None:
        self._agent = agent
        self.spec: TaskSpec = agent.spec
        saved = agent.to_saved()
        self._seed, self._n_steps = saved.seed, saved.n_steps
        self._state, self._history = saved.state, saved.history
        self._episodes = saved.episodes
        self._repeated: Faithfulness | None = None  # None: nobody has tried yet.
        self.mind = Mind(agent.config, saved.state)
        decisions = [decision for episode in self._episodes for decision in episode.decisions]
        self._trials = Trials(self.mind, self.spec, decisions, lambda: self.ranges)

    def why(self, situation: Situation) -> Why:
        """Why this action: path, distances, expectations and what they are made of."""
        why = explain_why(self._decision(situation), self.spec, self.mind.view)
        return replace(why, faithfulness=self._trials.on(CHECKS[Why]))

    def why_not(self, situation: Situation, action: int | str) -> WhyNot:
        """Why not that action, given by its index or its name.

        Raises:
            ValueError: If there is no such action, or it is the chosen one.
        """
        decision = self._decision(situation)
        found = explain_why_not(decision, self.action(action), self.mind.view)
        return replace(found, faithfulness=self._trials.on(CHECKS[WhyNot]))

    def flips(self, situation: Situation) -> Flips:
        """What would flip it: for each feature the nearest flips, and a certified radius."""
        decision = self._decision(situation)
        found = explain_flips(self.mind, decision, self.ranges)
        return replace(found, faithfulness=self._trials.on(CHECKS[Flips]))

    def nearest_flip(
        self,
        situation: Situation,
        time_limit_s: float = 30.0,
        on_progress: Progress | None = None,
    ) -> NearestFlip:
        """The least change of all features together that changes the action; takes its time.

        Returns the best so far, with its gap, when the time is up or `on_progress` gives False.

        Raises:
            ValueError: If the agent votes or thinks ahead, or there is no SciPy.
        """
        seen = self._decision(situation).observation
        found = find_nearest_flip(self.mind, seen, self.ranges, time_limit_s, on_progress)
        return replace(found, faithfulness=self._trials.on(CHECKS[NearestFlip]))

    def nearest_flip_in_background(
        self, situation: Situation, time_limit_s: float = 30.0
    ) -> Background[NearestFlip]:
        """`nearest_flip` in a thread of its own: its `latest`, `cancel()` and `result()`."""
        seen, mind, ranges = self._decision(situation).observation, self.mind.copy(), self.ranges
        trials = self._trials.copy(mind, ranges)

        def search(report: Callable[[NearestFlip], bool]) -> NearestFlip:
            found = find_nearest_flip(mind, seen, ranges, time_limit_s, report)
            return replace(found, faithfulness=trials.on(CHECKS[NearestFlip]))

        return Background(search)

    @property
    def whole(self) -> WholeAgent:
        """What can be asked about the agent as a whole; see `WholeAgent`."""
        return WholeAgent(
            self.mind, self.spec, self._episodes, lambda: self._agent.env, lambda: self.ranges
        )

    def novelty(self, situation: Situation) -> Novelty:
        """Whether what is seen is like nothing that the agent has met: the alarm."""
        return self.whole.novelty(self._decision(situation).observation)

    def disagreements(self, other: "AO2") -> Comparison:
        """Where another agent of the same task would choose differently, over both's states.

        Raises:
            ValueError: If it is one of another task.
        """
        theirs = other.explain
        return self.whole.disagreements(theirs.mind, theirs.whole.states())

    def ahead(self, situation: Situation, limit: int = 50) -> Ahead:
        """Where this will lead: the way it expects to go, up to so many steps.

        Raises:
            ValueError: If the agent has not learned what follows an action (the paper's has not).
        """
        way = look_ahead(self.mind, self._decision(situation).observation, limit)
        return replace(way, faithfulness=self._trials.on(CHECKS[Ahead]))

    def weight(self, option: int, action: int | str) -> Origin:
        """Where the weight of an action at an option comes from: its story, step by step.

        Raises:
            ValueError: If there is no such option or action, or the agent imagines nothing.
        """
        origin = explain_weight(self.mind, option, self.action(action))
        return replace(origin, faithfulness=self._trials.on(CHECKS[Origin]))

    def option(self, option: int) -> WholeOption:
        """One option in full: value, weights and what they rest on, experience, recorded uses.

        Raises:
            ValueError: If there is no such living option.
        """
        found = explain_option(self.mind, option, self._episodes)
        return replace(found, faithfulness=self._trials.on(CHECKS[WholeOption]))

    def ledger(
        self, option: int, action: int | str, on_progress: LearningProgress | None = None
    ) -> Account:
        """Every reward in a weight of the `paper` preset, by training episode and step.

        Nothing is kept in ordinary learning: the agent is learned again from its seed, which takes
        as long as it took, and what moves this one weight is written down.

        Raises:
            ValueError: If it is no agent of that preset, there is no such weight, or it cannot be
                learned again to the bit.
            LearningStoppedError: If `on_progress` ended it.
        """
        config, view, index = self.mind.config, self.mind.view, self.action(action)
        if not isinstance(config, PaperConfig):
            raise ValueError(
                "Expected an agent of the paper preset: its weights are made of rewards. Those of "
                "the anticipating preset are imagined; ask for `weight`."
            )
        if not (0 <= option < len(view.is_alive) and view.is_alive[option]):
            raise ValueError(f"There is no living option {option}.")
        ledger = Ledger(option, index, config.gamma)

        def watch(learner: Learner) -> None:
            assert isinstance(learner, PaperLearner)
            learner.ledger = ledger

        repeated = self._repeat(watch, on_progress)
        account = close_ledger(ledger, float(view.weights[option, index]), self._history)
        return replace(account, faithfulness=repeated)

    def forget(self, episode: int, on_progress: LearningProgress | None = None) -> Forgotten:
        """Which decisions would be others, had a training episode never been learned from.

        The agent is learned again twice: as it was, to make sure that it comes out the same, and
        without. Compared are the recorded states; without any, the options' values.

        Args:
            episode: Of the training, counted from 0.
            on_progress: Told the share that is done; returning False ends it.

        Raises:
            ValueError: If there is no such episode, or it cannot be learned again to the bit.
            LearningStoppedError: If `on_progress` ended it.
        """
        if not 0 <= episode < len(self._history):
            raise ValueError(
                f"There is no training episode {episode}; {len(self._history):,} were finished, "
                f"counted from 0."
            )
        repeated = self._repeated
        if repeated is None:
            repeated = self._repeat(None, _half(on_progress, 0))
        learner = learn_again(
            self._agent.env,
            self.spec,
            self.mind.config,
            self._seed,
            self._n_steps,
            without=episode,
            on_progress=_half(on_progress, 1),
        )
        other = Mind(self.mind.config, learner.get_state())
        _, reward, length, _ = self._history[episode].tolist()
        states = self.whole.states()
        found = compare_without(self.mind, other, states, episode, int(length), reward)
        return replace(found, faithfulness=repeated)

    def _repeat(
        self, watch: Callable[[Learner], None] | None, on_progress: LearningProgress | None
    ) -> Faithfulness:
        """Learns the agent again, and makes sure that it is the same; says how often it decides so.

        Raises:
            ValueError: If it comes out otherwise.
            LearningStoppedError: If `on_progress` ended it.
        """
        learner = learn_again(
            self._agent.env,
            self.spec,
            self.mind.config,
            self._seed,
            self._n_steps,
            watch=watch,
            expected=self._history,
            on_progress=on_progress,
        )
        check_same(learner, self._state)
        again = Mind(self.mind.config, learner.get_state())
        self._repeated = self._trials.learned_again(again, sample_states(self.whole.states()))
        return self._repeated

    def tell(self, told: Told) -> str:
        """Any explanation from here in plain sentences, a line each."""
        return "\n".join(tell(told, self.spec))

    @property
    def ranges(self) -> Ranges:
        """The observations that the environment allows; all, where it cannot be made here."""
        try:
            return ranges_of(self._agent.env)
        except ValueError:
            return unlimited(self.spec.n_features)

    def action(self, action: int | str) -> int:
        """An action's index, from its index or its name.

        Raises:
            ValueError: If there is none; says which there are.
        """
        names = self.spec.action_names
        if isinstance(action, str):
            if action in names:
                return names.index(action)
        elif 0 <= action < len(names):
            return int(action)
        raise ValueError(
            f"Expected an action of {self.spec.env_id}, but got {action!r}. There are: "
            f"{', '.join(f'{i} ({name})' for i, name in enumerate(names))}."
        )

    def _decision(self, situation: Situation) -> Decision:
        if isinstance(situation, Decision):
            return situation
        return self.mind.decide(to_observation(situation, self.spec))


def _half(on_progress: LearningProgress | None, which: int) -> LearningProgress | None:
    """The progress of one of two halves."""
    return None if on_progress is None else lambda share: on_progress((which + share) / 2)
