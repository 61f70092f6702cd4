"""Long work that one browser asked for: started, looked at, called off."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ao2viz.explain.background import Background
from ao2viz.ui.questions import Task


class CalledOffError(ValueError):
    """Ends work in the middle where nothing comes of it."""


@dataclass(frozen=True, eq=False)
class Begin:
    """Asks for work; the same kind of work that is under way is called off."""

    task: Task
    about: tuple[object, ...]  # What it is about: it counts for nothing else.
    work: Callable[[Callable[[Any], bool]], Any]  # As for `Background`.


@dataclass(frozen=True, eq=False)
class JobState:
    """How far a piece of work has come."""

    latest: Any  # What it reported last, at the end its result; None before the first.
    is_done: bool
    error: str  # Why it failed, in words; empty if it did not.
    seconds: float  # It has been at work, or was.


class Jobs:
    """The long work of one browser. Only the app loop may call it."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._jobs: dict[Task, tuple[Begin, Background[Any], float]] = {}
        self._ended: dict[Task, JobState] = {}

    @property
    def is_busy(self) -> bool:
        """Whether something is at work, or its end has not been looked at."""
        return len(self._ended) < len(self._jobs)

    def begin(self, begin: Begin) -> None:
        """Starts work in a thread of its own."""
        self.forget(begin.task)
        self._jobs[begin.task] = begin, Background(begin.work), self._clock()

    def call_off(self, task: Task) -> None:
        """Asks work to end soon."""
        if task in self._jobs:
            self._jobs[task][1].cancel()

    def forget(self, task: Task) -> None:
        """Calls work off, and no longer knows of it."""
        self.call_off(task)
        self._jobs.pop(task, None)
        self._ended.pop(task, None)

    def look(self, task: Task, about: tuple[object, ...]) -> JobState | None:
        """How far the work about this has come; work about something else is forgotten."""
        if task not in self._jobs:
            return None
        begin, background, since = self._jobs[task]
        if begin.about != about:
            self.forget(task)
            return None
        if task not in self._ended:
            if not background.is_done:
                return JobState(background.latest, False, "", self._clock() - since)
            self._ended[task] = _end_of(background, self._clock() - since)
        return self._ended[task]

    def close(self) -> None:
        """Calls everything off."""
        for task in list(self._jobs):
            self.forget(task)


def _end_of(background: Background[Any], seconds: float) -> JobState:
    try:
        return JobState(background.result(0), True, "", seconds)
    except Exception as error:  # Whatever went wrong is told where the result would stand.
        words = str(error) or type(error).__name__
        if not isinstance(error, ValueError | OSError):
            words = f"{type(error).__name__}: {words}"
        return JobState(background.latest, True, words, seconds)
