"""What only a whole mind can answer, asked in a thread of its own."""

from collections import OrderedDict
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeVar

from numpy.typing import NDArray

from ao2viz.core.decision import Decision
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges, ranges_by_id
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Check, Faithfulness
from ao2viz.explain.ahead import Ahead, look_ahead
from ao2viz.explain.faithful import Trials
from ao2viz.explain.flips import Flips
from ao2viz.explain.origin import Origin, explain_weight
from ao2viz.explain.what_if import find_flips_at
from ao2viz.explain.whole import (
    MOST_SEARCHED,
    Novelty,
    measure_novelty,
    sample_states,
    states_of,
)
from ao2viz.recording.episode import Episode
from ao2viz.store.saved import Learned

STEPS_AHEAD = 60
"""The imagined path goes so far, unless it ends before."""

_KEPT_MINDS = 3
_KEPT_ANSWERS = 256
_MOST_WAITING = 3  # Of an episode that plays faster than it is thought about, some are left out.
_T = TypeVar("_T")


@dataclass(frozen=True)
class NoAnswer:
    """Why a question has no answer, in words."""

    words: str


class Thinker:
    """Answers questions about what was learned; None until the answer is there.

    Whoever asks asks again with every tick. Only the app loop may ask.
    """

    def __init__(self) -> None:
        self._thread: ThreadPoolExecutor | None = None
        self._minds: OrderedDict[int, tuple[Learned, Mind]] = OrderedDict()  # The thread's own.
        # Each holds what it is about, so that an id stands for one thing as long as it is kept.
        self._asked: OrderedDict[object, tuple[object, Future[object]]] = OrderedDict()

    @property
    def is_busy(self) -> bool:
        """Whether an answer is on its way."""
        return any(not future.done() for _, future in self._asked.values())

    def ahead(self, learned: Learned, observation: NDArray) -> Ahead | NoAnswer | None:
        """Where it expects to go from an observation [D]."""
        return self._ask(
            (id(learned), "ahead", observation.tobytes()),
            learned,
            lambda mind: look_ahead(mind, observation, STEPS_AHEAD),
        )

    def origin(self, learned: Learned, option: int, action: int) -> Origin | NoAnswer | None:
        """Where a weight comes from."""
        return self._ask(
            (id(learned), option, action),
            learned,
            lambda mind: explain_weight(mind, option, action),
        )

    def decision(self, learned: Learned, state: NDArray) -> Decision | NoAnswer | None:
        """What it would decide, seeing a state [D]."""
        key = (id(learned), "decision", state.tobytes())
        return self._ask(key, learned, lambda mind: mind.decide(state))

    def ranges(self, learned: Learned, spec: TaskSpec) -> Ranges | NoAnswer | None:
        """What its environment allows to be seen."""
        key = (id(learned), "ranges")
        return self._ask(key, learned, lambda _: ranges_by_id(spec.env_id, spec.n_features))

    def flips(self, learned: Learned, spec: TaskSpec, state: NDArray) -> Flips | NoAnswer | None:
        """What would change its decision at a state [D]."""
        ranges = self.ranges(learned, spec)
        if ranges is None or isinstance(ranges, NoAnswer):
            return ranges
        key = (id(learned), "flips", state.tobytes())
        return self._ask(key, learned, lambda mind: find_flips_at(mind, state, ranges))

    def novelty(
        self, learned: Learned, state: NDArray, recorded: Sequence[Episode]
    ) -> Novelty | NoAnswer | None:
        """Whether it has met anything like a state [D], beside what was recorded."""
        key = (id(learned), "novelty", state.tobytes(), *map(id, recorded))

        def work(mind: Mind) -> Novelty:
            states = sample_states(states_of(mind, recorded), MOST_SEARCHED)
            return measure_novelty(mind, state, states)

        return self._ask(key, learned, work, recorded)

    def faithfulness(
        self, learned: Learned, spec: TaskSpec, recorded: Sequence[Episode], checks: Sequence[Check]
    ) -> Faithfulness | NoAnswer | None:
        """How often explanations agree with it, tried on what was recorded of it."""
        ranges = self.ranges(learned, spec)
        if ranges is None or isinstance(ranges, NoAnswer):
            return ranges
        key = (id(learned), "faithful", *checks, *map(id, recorded))

        def work(mind: Mind) -> Faithfulness:
            decisions = [decision for episode in recorded for decision in episode.decisions]
            return Trials(mind, spec, decisions, lambda: ranges).on(checks)

        return self._ask(key, learned, work, recorded)

    def close(self) -> None:
        """Waits for what is under way, and forgets the rest."""
        if self._thread is not None:
            self._thread.shutdown(wait=True, cancel_futures=True)

    def _ask(
        self, key: object, learned: Learned, answer: Callable[[Mind], _T], about: object = None
    ) -> _T | NoAnswer | None:
        if key not in self._asked:
            waiting = [k for k, (_, future) in self._asked.items() if not future.done()]
            for late in waiting[: -_MOST_WAITING + 1]:
                if self._asked[late][1].cancel():
                    del self._asked[late]
            if self._thread is None:
                self._thread = ThreadPoolExecutor(1, "thinker")
            self._asked[key] = (learned, about), self._thread.submit(self._answer, learned, answer)
            while len(self._asked) > _KEPT_ANSWERS:
                self._asked.popitem(last=False)[1][1].cancel()
        self._asked.move_to_end(key)
        future = self._asked[key][1]
        return future.result() if future.done() else None  # pyright: ignore[reportReturnType]

    def _answer(self, learned: Learned, answer: Callable[[Mind], object]) -> object:
        try:
            known = self._minds.pop(id(learned), None)
            mind = known[1] if known is not None else Mind(learned.config, learned.state)
            self._minds[id(learned)] = learned, mind
            while len(self._minds) > _KEPT_MINDS:
                self._minds.popitem(last=False)
            return answer(mind)
        except ValueError as error:  # Not every agent can answer everything; it says so.
            return NoAnswer(str(error))
