"""The owner of agent, environment and generator: commands in, steps taken, updates out.

No threads, no sleeping, no queues: a runner calls `handle`, `advance` and `update` in turn.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from ao2viz.agent import AO2
from ao2viz.recording.cycle import Cycle
from ao2viz.training.frames import draw
from ao2viz.training.loop import Stepper, cycle_of
from ao2viz.training.making import in_words, make_agent
from ao2viz.training.states import (
    IN_WORDS,
    MAX_LEARNING,
    MIN_LEARNING,
    TRANSITIONS,
    USUAL_LEARNING,
    ChangeSettings,
    Pause,
    Resume,
    RunCommand,
    RunEpisode,
    RunStatus,
    Save,
    SetDecideBy,
    SetShare,
    SetSpeed,
    Start,
    Step,
    Stop,
    TrainOn,
)
from ao2viz.training.stopwatch import Stopwatch
from ao2viz.training.throttle import Throttle
from ao2viz.training.updates import RunUpdate
from ao2viz.training.warmup import warm_up


class Worker:
    """One run after the other. Not safe to share between threads."""

    def __init__(
        self, runs_before: int = 0, clock: Callable[[], float] = time.perf_counter
    ) -> None:
        """Makes an idle worker.

        Args:
            runs_before: The number of the latest run of a worker that this one replaces.
            clock: Seconds; for throttling and for counting steps a second.
        """
        self.learning_share = USUAL_LEARNING  # Of the time; for whoever makes the updates.
        self.changes = 0  # Raised by whatever people should see at once.
        self._clock = clock
        self._status = RunStatus.IDLE
        self._message, self._is_error = "", False
        self._run_id = runs_before
        self._start = Start()
        self._agent: AO2 | None = None
        self._stepper: Stepper | None = None
        self._preparing: Iterator[None] | None = None
        self._status_before = RunStatus.IDLE
        self._single_steps = 0  # Asked for while paused and not taken yet.
        self._pauses_at_end = False  # Holds when the episode ends.
        self._cycle: Cycle | None = None  # Of the latest single step, until the run goes on.
        self._first_step = 0
        self._watch = Stopwatch()
        self._throttle = Throttle(clock)
        self._frame: bytes | None = None
        self._framed_at = -1
        self._draws = True

    @property
    def status(self) -> RunStatus:
        """What the run is doing."""
        return self._status

    @property
    def agent(self) -> AO2 | None:
        """The agent of the run, None before the first."""
        return self._agent

    def handle(self, command: RunCommand) -> None:
        """Does what is asked if it is legal now, else says in words why not. Never raises."""
        target = TRANSITIONS.get((self._status, type(command)))
        if target is None:
            self._tell(
                f"Cannot {IN_WORDS[type(command)]} while the run is {self._status.value}.",
                is_error=True,
            )
            return
        match command:
            case Start():
                self._status_before = self._status
                self._preparing = self._prepare(command)
                self._tell(f"Making {command.env_id}.")
            case Save():
                self._save(command)
            case SetSpeed():
                self._set_speed(command.steps_per_s)
                return
            case SetShare():
                self._set_share(command.learning)
                return
            case SetDecideBy():
                self._require_agent().set_decide_by(command.decide_by)
                self._tell(f"Decides by {command.decide_by.value} from now on.")
            case ChangeSettings():
                self._change(command)
            case TrainOn():
                if not self._extend(command.more_steps):
                    return
            case Stop():
                self._stop()
            case Step():
                self._single_steps += 1
            case Pause() | Resume() | RunEpisode():
                self._pauses_at_end = isinstance(command, RunEpisode)
                self._tell("")
        self._go(target)

    def advance(self, budget_s: float) -> float | None:
        """Works for about so long. Never raises; what the environment raises fails the run.

        Returns:
            Seconds until there is more to do: 0 for at once, None for not before a command.
        """
        if self._preparing is not None:
            self._advance_preparing()
            return 0.0
        try:
            if self._status is RunStatus.RUNNING:
                self._watch.start(self._clock())
                try:
                    return self._train(budget_s)
                finally:
                    self._watch.stop(self._clock())
            if self._status is RunStatus.PAUSED and self._single_steps:
                self._take_single_step()
                return 0.0
        except Exception as error:
            self._fail(error)
        return None

    def update(self) -> RunUpdate:
        """Everything there is to show now."""
        agent, stepper = self._agent, self._stepper
        general = RunUpdate(
            status=self._status,
            message=self._message,
            is_error=self._is_error,
            run_id=self._run_id,
            speed=self._throttle.speed,
            learning_share=self.learning_share,
        )
        if agent is None or stepper is None:
            return general
        holds = self._status not in (RunStatus.RUNNING, RunStatus.PREPARING)
        steps_per_s = self._measure_speed()
        left = self._first_step + self._start.total_steps - agent.num_timesteps
        return replace(
            general,
            spec=agent.spec,
            preset=agent.preset,
            seed=agent.seed,
            config=agent.config,
            n_steps=agent.num_timesteps,
            first_step=self._first_step,
            total_steps=self._start.total_steps,
            steps_per_s=steps_per_s,
            eta_s=left / steps_per_s if steps_per_s > 0 else None,
            episode_reward=stepper.episode_reward,
            episode_step=stepper.episode_step,
            history=agent.history.to_array(),
            seconds=self._watch.marks,
            forest=agent.forest,
            decision=None if stepper.last is None else stepper.last.decision,
            frame=self._draw(),
            saved=agent.to_saved() if holds else None,
            episode=stepper.episode() if holds else None,
            cycle=self._cycle if holds else None,
        )

    def close(self) -> None:
        """Lets go of the environment."""
        if self._agent is not None:
            self._close_env(self._agent)

    # Preparing.

    def _prepare(self, start: Start) -> Iterator[None]:
        """Yields wherever a command may be handled and the status be shown."""
        yield
        agent = make_agent(start)
        self._tell("Compiling; the first time on a machine, this takes up to a minute.")
        yield
        warm_up(agent.config, agent.spec.n_features, agent.spec.n_actions)
        # A stop that was asked for meanwhile is handled here, before the first step.
        yield
        if self._agent is not None:
            self._close_env(self._agent)
        self._agent, self._stepper = agent, agent.stepper()
        self._start = start
        self._run_id += 1
        self._first_step = agent.num_timesteps
        self._watch = Stopwatch(len(agent.history))
        self._single_steps, self._pauses_at_end = 0, False
        self._frame, self._framed_at, self._draws = None, -1, True

    def _advance_preparing(self) -> None:
        assert self._preparing is not None
        try:
            next(self._preparing)
        except StopIteration:
            self._preparing = None
            self._tell("")
            self._go(RunStatus.RUNNING)
        except Exception as error:
            # Nothing has changed yet: whatever was there before still is.
            self._preparing = None
            self._tell(in_words(error), is_error=True)
            self._go(self._status_before)

    # Training.

    @property
    def _is_done(self) -> bool:
        return self._require_agent().num_timesteps >= self._first_step + self._start.total_steps

    def _train(self, budget_s: float) -> float | None:
        deadline = self._clock() + budget_s
        while not self._is_done:
            now = self._clock()
            if now >= deadline:
                return 0.0
            if (wait_s := self._throttle.wait_s(now, self._n_steps)) > 0:
                return wait_s
            if self._take_step() and self._pauses_at_end:
                self._pauses_at_end = False
                self._go(RunStatus.PAUSED)
                return None
        if self._message != _SETTLING:
            self._tell(_SETTLING)  # Shown before the work begins; it can take seconds.
            return 0.0
        self._finish()
        return None

    def _take_single_step(self) -> None:
        self._single_steps -= 1
        if not self._is_done:  # It is if the pause came while the last step was settling.
            before = self._require_agent().forest
            self._take_step()
            assert self._stepper is not None
            assert self._stepper.last is not None
            self._cycle = cycle_of(before, self._require_agent().forest, self._stepper.last)
            self.changes += 1
        if self._is_done:
            self._finish()

    def _take_step(self) -> bool:
        """Whether the episode ended with it."""
        assert self._stepper is not None
        has_ended = self._stepper.step().has_ended
        if has_ended:
            self._watch.mark(self._clock())
        return has_ended

    def _finish(self) -> None:
        agent = self._require_agent()
        agent.settle()
        self._tell(f"Finished: {agent.num_timesteps:,} steps, {len(agent.forest):,} options.")
        self._go(RunStatus.FINISHED)

    def _stop(self) -> None:
        if self._preparing is not None:
            self._preparing = None
            self.close()
            self._agent, self._stepper = None, None
            self._tell("Stopped before the first step.")
            return
        agent = self._require_agent()
        self._single_steps = 0
        agent.settle()
        self._tell(f"Stopped after {agent.num_timesteps:,} steps.")

    def _extend(self, more_steps: int) -> bool:
        if more_steps < 1:
            self._tell(f"Expected at least one step to take, but got {more_steps}.", is_error=True)
            return False
        self._stepper = self._require_agent().stepper()  # From a fresh episode, as `learn` does.
        self._first_step = self._n_steps
        self._start = replace(self._start, total_steps=more_steps)
        self._single_steps, self._pauses_at_end = 0, False
        self._tell("")
        return True

    def _fail(self, error: Exception) -> None:
        agent = self._require_agent()
        self._single_steps = 0
        self._tell(
            f"{agent.spec.env_id} failed after {agent.num_timesteps:,} steps: {in_words(error)} "
            f"What was learned is kept: save it, or resume with a fresh episode.",
            is_error=True,
        )
        self._go(RunStatus.FAILED)

    def _save(self, command: Save) -> None:
        try:
            self._require_agent().save(command.path)
        except (OSError, ValueError) as error:
            self._tell(f"Could not save to {command.path}: {in_words(error)}", is_error=True)
        else:
            if not command.is_copy:
                self._tell(f"Saved to {command.path}.")

    def _change(self, command: ChangeSettings) -> None:
        try:
            self._require_agent().change_settings(**command.settings)
        except ValueError as error:
            self._tell(in_words(error), is_error=True)
        else:
            told = ", ".join(f"{name} {value}" for name, value in command.settings.items())
            self._tell(f"From now on: {told}.")

    # Speed.

    def _set_speed(self, steps_per_s: float | None) -> None:
        if steps_per_s is not None and not (np.isfinite(steps_per_s) and steps_per_s > 0):
            self._tell(
                f"Expected more than 0 steps a second, but got {steps_per_s}.", is_error=True
            )
            return
        self._throttle.set_limit(steps_per_s, self._n_steps)

    def _set_share(self, learning: float) -> None:
        if not MIN_LEARNING <= learning <= MAX_LEARNING:
            expected = f"from {MIN_LEARNING:.0%} to {MAX_LEARNING:.0%} of the time for learning"
            self._tell(f"Expected {expected}, but got {learning}.", is_error=True)
            return
        self.learning_share = learning
        self.changes += 1

    def _measure_speed(self) -> float:
        return self._throttle.measure(self._n_steps) if self._status is RunStatus.RUNNING else 0.0

    @property
    def _n_steps(self) -> int:
        return 0 if self._agent is None else self._agent.num_timesteps

    # Small things.

    def _draw(self) -> bytes | None:
        agent, stepper = self._require_agent(), self._stepper
        assert stepper is not None
        if not self._draws or stepper.last is None or self._status is RunStatus.FAILED:
            return self._frame
        if self._framed_at != agent.num_timesteps:
            self._framed_at = agent.num_timesteps
            try:
                self._frame = draw(agent.env)
            except Exception as error:  # A picture is not worth a run.
                self._draws, self._frame = False, None
                self._tell(f"{agent.spec.env_id} could not be drawn: {in_words(error)}", True)
        return self._frame

    def _require_agent(self) -> AO2:
        assert self._agent is not None, f"A {self._status.value} run must have an agent."
        return self._agent

    def _go(self, status: RunStatus) -> None:
        self.changes += 1
        if status is RunStatus.RUNNING:
            self._cycle = None
        if status is not self._status:
            self._status = status
            self._throttle.restart(self._n_steps)

    def _tell(self, message: str, is_error: bool = False) -> None:
        self._message, self._is_error = message, is_error
        self.changes += 1

    def _close_env(self, agent: AO2) -> None:
        try:
            agent.env.close()
        except Exception as error:  # It is of no use any more, whatever it says.
            self._tell(f"{agent.spec.env_id} could not be closed: {in_words(error)}", True)


_SETTLING = "All steps taken; letting what was learned settle."
