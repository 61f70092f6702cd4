"""`ao2viz explain`: one question about one decision, answered in sentences, a table or JSON."""

import contextlib
import ctypes
import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import typer
from rich.progress import Progress, SpinnerColumn, TextColumn

from ao2viz.agent import AO2
from ao2viz.cli.console import say, say_aside, show_json, stderr
from ao2viz.cli.exit_codes import EXIT_INTERRUPTED
from ao2viz.cli.explanation_tables import show_tables
from ao2viz.core.config import PaperConfig
from ao2viz.core.decision import Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import to_observation
from ao2viz.explain.nearest import NearestFlip
from ao2viz.explain.plain import to_plain
from ao2viz.explain.questions import Question
from ao2viz.explain.telling import Told
from ao2viz.explain.words import amounts, number, percent
from ao2viz.explanations import Explainer

_NOT_OF_A_DECISION = (Question.FORGET, Question.AGENT, Question.MUTE, Question.DISAGREE)


@dataclass(frozen=True)
class Asked:
    """What came with the question; None where nothing was said."""

    episode: int | None = None  # Recorded, counted from 0.
    step: int | None = None
    observation: str | None = None  # Numbers with commas, environment units.
    action: str | None = None  # Name or index.
    option: int | None = None
    steps: int = 50
    time_limit_s: float = 30.0
    forget: int | None = None  # Training episode, counted from 0.
    other: Path | None = None  # Another agent's file.
    episodes: int = 10  # To play for each muted option.


def run(file: Path, question: Question, asked: Asked, *, env: str | None, as_json: bool) -> None:
    """Answers one question.

    Raises:
        ValueError: If the file is no agent, or the question does not fit it.
    """
    agent = AO2.load(file, env)
    explain = agent.explain
    situation = None
    if question not in _NOT_OF_A_DECISION and not (
        question in (Question.WEIGHT, Question.OPTION) and asked.option is not None
    ):
        situation = find_situation(agent, explain, asked)
    answer = _answer(explain, question, asked, situation, env)
    if as_json:
        show_json(
            {
                "file": str(file),
                "environment": agent.spec.env_id,
                "question": question.value,
                "features": [feature.name for feature in agent.spec.features],
                "actions": list(agent.spec.action_names),
                "answer": to_plain(answer),
                "sentences": explain.tell(answer).splitlines(),
            }
        )
        return
    if situation is not None:
        shown = zip(agent.spec.features, amounts(situation.observation, agent.spec), strict=True)
        say("Seen: " + ", ".join(f"{feature.name} {text}" for feature, text in shown) + ".")
    for line in explain.tell(answer).splitlines():
        say(line)
    show_tables(answer, agent.spec)


def find_situation(agent: AO2, explain: Explainer, asked: Asked) -> Decision:
    """The decision that is asked about: a recorded one, or what it would do at an observation.

    Raises:
        ValueError: If there is none.
    """
    if asked.observation is not None:
        if asked.episode is not None or asked.step is not None:
            raise ValueError("Give either --observation, or --episode and --step.")
        return explain.mind.decide(_read_observation(asked.observation, agent))
    if not agent.episodes:
        raise ValueError(
            "This agent has no recorded episode to ask about; give an --observation, or record "
            "one with ao2viz record."
        )
    episode = len(agent.episodes) - 1 if asked.episode is None else asked.episode
    if episode >= len(agent.episodes):
        raise ValueError(
            f"There is no recorded episode {episode}; they go from 0 to {len(agent.episodes) - 1}."
        )
    decisions = agent.episodes[episode].decisions
    step = 0 if asked.step is None else asked.step
    if step >= len(decisions):
        raise ValueError(
            f"There is no step {step} in episode {episode}; they go from 0 to {len(decisions) - 1}."
        )
    return decisions[step]


def _read_observation(text: str, agent: AO2) -> np.ndarray:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        raise ValueError(
            f"Expected --observation as numbers with commas between, such as 0,0,0.05,0, but got "
            f"{text!r}."
        ) from None
    return to_observation(numbers, agent.spec)


def _answer(
    explain: Explainer,
    question: Question,
    asked: Asked,
    situation: Decision | None,
    env: str | None,
) -> Told:
    match question:
        case Question.WEIGHT:
            option, action = _weight_asked(explain.mind.view, asked, situation)
            index = to_action(explain, action)
            if isinstance(explain.mind.config, PaperConfig):
                with _learning() as on_progress:
                    return explain.ledger(option, index, on_progress)
            return explain.weight(option, index)
        case Question.OPTION:
            return explain.option(_option_asked(asked, situation))
        case Question.FORGET:
            if asked.forget is None:
                raise ValueError("Forget which training episode? Name it with --forget.")
            with _learning() as on_progress:
                return explain.forget(asked.forget, on_progress)
        case Question.AGENT:
            with stderr().status("Asking at every recorded state …"):
                return explain.whole.overview()
        case Question.MUTE:
            options = 5 if asked.option is None else [asked.option]
            with stderr().status("Playing without one option after the other …"):
                return explain.whole.carriers(options, asked.episodes)
        case Question.DISAGREE:
            if asked.other is None:
                raise ValueError("Disagree with whom? Name another agent's file with --other.")
            return explain.disagreements(AO2.load(asked.other, env))
    assert situation is not None  # The other questions are about a decision.
    match question:
        case Question.WHY:
            return explain.why(situation)
        case Question.WHY_NOT:
            if asked.action is None:
                names = ", ".join(explain.spec.action_names)
                raise ValueError(
                    f"Why not which action? Name it with --action; there are: {names}."
                )
            return explain.why_not(situation, to_action(explain, asked.action))
        case Question.FLIP:
            return explain.flips(situation)
        case Question.NEAREST_FLIP:
            with _only_python_prints():
                return _search(explain, situation, asked.time_limit_s)
        case Question.AHEAD:
            return explain.ahead(situation, asked.steps)
        case Question.NOVELTY:
            return explain.novelty(situation)


def to_action(explain: Explainer, text: str) -> int:
    """An action's index from what was typed: its name, or its index.

    Raises:
        ValueError: If there is no such action.
    """
    is_index = text.isdecimal() and text not in explain.spec.action_names
    return explain.action(int(text) if is_index else text)


def _weight_asked(view: ForestView, asked: Asked, situation: Decision | None) -> tuple[int, str]:
    """Which weight is meant: that of the option and action named, else of who decided."""
    option, action = _option_asked(asked, situation), asked.action
    if action is None:
        known = 0 <= option < len(view.weights)
        best = int(np.argmax(view.weights[option])) if known else 0
        action = str(best if situation is None else situation.action)
    return option, action


def _option_asked(asked: Asked, situation: Decision | None) -> int:
    """Which option is meant: the one that was named, else who decided."""
    if asked.option is not None:
        return asked.option
    assert situation is not None
    if len(situation.voters) == 0:
        raise ValueError("No option decided there; name one with --option.")
    return int(situation.voters[0])


@contextlib.contextmanager
def _only_python_prints() -> Iterator[None]:
    """Keeps what a compiled library prints out of the result: now and then the solver does."""
    sys.stdout.flush()
    try:
        number = sys.stdout.fileno()
    except (OSError, ValueError):  # Not a real file, as in some notebooks.
        yield
        return
    kept = os.dup(number)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, number)
    try:
        yield
    finally:
        # What C has not written yet would come out later, behind the result.
        with contextlib.suppress(OSError, TypeError):
            ctypes.CDLL(None).fflush(None)
        os.dup2(kept, number)
        os.close(kept)
        os.close(nowhere)


@contextlib.contextmanager
def _learning() -> Iterator[Callable[[float], None]]:
    """A bar that shows how much has been learned again; Ctrl-C ends it, and nothing is left."""
    console = stderr()
    with Progress(console=console, disable=not console.is_terminal, transient=True) as progress:
        task = progress.add_task("Learning again", total=1.0)
        try:
            yield lambda share: progress.update(task, completed=share)
        except KeyboardInterrupt:
            progress.stop()
            say_aside("Called off in the middle of learning again: there is no answer.")
            raise typer.Exit(EXIT_INTERRUPTED) from None


def _search(explain: Explainer, situation: Decision, time_limit_s: float) -> NearestFlip:
    """Searches with a line of progress; Ctrl-C ends the search and gives what it has."""
    console = stderr()
    with Progress(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        console=console,
        disable=not console.is_terminal,
        transient=True,
    ) as progress:
        task = progress.add_task("Searching …", total=None)
        search = explain.nearest_flip_in_background(situation, time_limit_s)
        while not search.is_done:
            try:
                return search.result(0.1)
            except TimeoutError:
                latest = search.latest
            except KeyboardInterrupt:
                search.cancel()
                return search.result()
            if latest is not None:
                progress.update(
                    task,
                    description=f"Nearest so far {number(latest.distance)}, none nearer than "
                    f"{number(latest.bound)} (gap {percent(latest.gap)}) …",
                )
        return search.result()
