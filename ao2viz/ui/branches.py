"""Branches: episodes that go on otherwise since a person chose an action, played in a thread."""

from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from ao2viz.core.mind import Mind
from ao2viz.envs.task import TaskSpec
from ao2viz.recording.episode import Episode
from ao2viz.store.saved import Learned
from ao2viz.training.branching import BranchStoppedError, Takeover, play_branch


@dataclass(frozen=True, eq=False)
class BranchWish:
    """A branch that somebody wants to see."""

    main: Episode
    spec: TaskSpec
    learned: Learned  # Who goes on; it learns nothing on the way.
    takeovers: tuple[Takeover, ...]
    limit: int  # Steps of the agent after the last takeover; 0: to the end.


@dataclass(frozen=True, eq=False)
class Branch:
    """A branch that is there to be watched."""

    main: Episode
    takeovers: tuple[Takeover, ...]
    episode: Episode

    @property
    def departure(self) -> int:
        """The step at which it leaves the main line."""
        return self.takeovers[0].step

    def takeover_at(self, step: int) -> Takeover | None:
        """What a person chose at a step, if anything."""
        return next((t for t in self.takeovers if t.step == step), None)


@dataclass(frozen=True)
class BranchUnderWay:
    """How far a branch has been played."""

    steps: int


@dataclass(frozen=True)
class BranchFailure:
    """Why there is no branch, in words."""

    message: str


BranchResult = Episode | BranchUnderWay | BranchFailure


class Brancher:
    """Plays the branches that are wanted, one after the other. Only the app loop may call it."""

    def __init__(self) -> None:
        self._thread: ThreadPoolExecutor | None = None
        self._results: dict[BranchWish, BranchResult] = {}
        self._mind: tuple[Learned, Mind] | None = None  # The thread's own.

    def play(self, wishes: Iterable[BranchWish]) -> Mapping[BranchWish, BranchResult]:
        """What has become of these; all others are called off and forgotten."""
        wanted = set(wishes)
        for wish in [w for w in list(self._results) if w not in wanted]:
            del self._results[wish]
        for wish in wanted - self._results.keys():
            if self._thread is None:
                self._thread = ThreadPoolExecutor(1, "branches")
            self._results[wish] = BranchUnderWay(0)
            self._thread.submit(self._play, wish)
        return dict(self._results)

    def close(self) -> None:
        """Calls everything off."""
        self._results.clear()
        if self._thread is not None:
            self._thread.shutdown(wait=True, cancel_futures=True)

    def _play(self, wish: BranchWish) -> None:
        def tell(steps: int) -> bool:
            if wish not in self._results:
                return False
            self._tell(wish, BranchUnderWay(steps))
            return True

        try:
            mind = self._mind_of(wish.learned)
            self._tell(
                wish,
                play_branch(
                    wish.main, wish.spec, wish.takeovers, mind.decide, wish.limit, on_step=tell
                ),
            )
        except BranchStoppedError:
            return
        except Exception as error:  # Whatever a stranger's environment raises is shown in words.
            self._tell(wish, BranchFailure(f"No branch: {error}"))

    def _tell(self, wish: BranchWish, result: BranchResult) -> None:
        if wish in self._results:  # A late word about what was called off harms nobody.
            self._results[wish] = result

    def _mind_of(self, learned: Learned) -> Mind:
        if self._mind is None or self._mind[0] is not learned:
            self._mind = learned, Mind(learned.config, learned.state)
        return self._mind[1]
