"""The agent as a Python programmer meets it: learn, predict, decide, save, load."""

import os
import time
from collections.abc import Callable
from typing import Any, Self

import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ao2viz.core.agent import make_learner
from ao2viz.core.card import make_card
from ao2viz.core.cleansing import Cleansed
from ao2viz.core.config import (
    Config,
    Preset,
    change_config,
    check_names,
    make_config,
    preset_of,
    to_preset,
)
from ao2viz.core.decision import DecideBy, Decision
from ao2viz.core.forest import ForestView
from ao2viz.core.settings import check_changeable
from ao2viz.envs.matching import check_env, check_match
from ao2viz.envs.motion import check_smoothing, last_executed, smooth
from ao2viz.envs.task import TaskSpec, describe, make_env, settings_for, to_observation
from ao2viz.explain.abstract import summarise
from ao2viz.explanations import Explainer
from ao2viz.recording.episode import Episode
from ao2viz.recording.growth_log import GrowthLog
from ao2viz.recording.history import History
from ao2viz.store.errors import AgentFileError
from ao2viz.store.files import read, write
from ao2viz.store.saved import SavedAgent, get_generator, set_generator
from ao2viz.training.loop import (
    Stepper,
    StepResult,
    evaluation_seed,
    play,
    to_seed,
    training_seed,
)
from ao2viz.training.progress import advancing

Callback = Callable[[StepResult], bool | None]


class AO2:
    """An AO2 agent and its environment, in the habit of stable-baselines3.

    ```python
    agent = AO2("CartPole-v1")
    agent.learn(20_000)
    print(agent.evaluate(episodes=100).mean())
    agent.save("cartpole.ao2")
    ```

    The same environment, preset, seed and settings give the same agent, to the bit. Not safe to
    share between threads: one agent has one owner.
    """

    def __init__(
        self,
        env: str | gym.Env,
        preset: Preset | str = Preset.ANTICIPATING,
        seed: int = 0,
        **overrides: Any,
    ) -> None:
        """Makes an agent that has learned nothing yet.

        Args:
            env: A Gymnasium id ("module:EnvId" imports the module first) or an environment.
            preset: "anticipating" or "paper".
            seed: Everything random comes from it, the seeds of training episodes included.
            overrides: Settings of the preset, on top of those proven for a catalogued
                environment, and `action_bins`: how many values per axis continuous actions get.

        Raises:
            ValueError: If the environment does not fit, or a setting is unknown or out of range.
        """
        kind = to_preset(preset)
        check_names(kind, overrides, beside=("action_bins",))
        self._env: gym.Env | None = make_env(env) if isinstance(env, str) else check_env(env)
        self.spec: TaskSpec = describe(self._env, overrides.pop("action_bins", None))
        config = change_config(make_config(kind, settings_for(self.spec, kind)), overrides)
        check_smoothing(self.spec, config.action_smoothing)
        self._setup(config, to_seed(seed))

    def _setup(self, config: Config, seed: int) -> None:
        self.seed = seed
        self.history = History()
        self.growth = GrowthLog()
        self.episodes: list[Episode] = []
        self._rng = np.random.default_rng(seed)
        self._learner = make_learner(
            config, self.spec.ranges, self.spec.n_actions, self._rng, time.perf_counter
        )

    @property
    def config(self) -> Config:
        """Every setting, frozen."""
        return self._learner.config

    @property
    def preset(self) -> Preset:
        """Which of the two agents this is."""
        return preset_of(self.config)

    @property
    def env(self) -> gym.Env:
        """Its environment; made when first asked for after a load.

        Raises:
            ValueError: If it cannot be made from its id; `load` takes one then.
        """
        if self._env is None:
            self._env = check_match(make_env(self.spec.env_id), self.spec)
        return self._env

    @property
    def num_timesteps(self) -> int:
        """Steps learned from so far."""
        return self._learner.n_steps

    @property
    def forest(self) -> ForestView:
        """A frozen copy of its options; see `ForestView`."""
        return self._learner.view()

    @property
    def explain(self) -> Explainer:
        """What answers questions about its decisions, as it is now; see `Explainer`."""
        return Explainer(self)

    def learn(
        self,
        total_timesteps: int,
        callback: Callback | None = None,
        progress_bar: bool = False,
    ) -> Self:
        """Learns for so many more steps, from a fresh episode on, then lets it settle.

        Args:
            total_timesteps: Steps to take.
            callback: Called after every step with its `StepResult`; returning False stops early.
            progress_bar: Shows one in the terminal.

        Raises:
            ValueError: If the environment gives numbers that are not finite. Whatever it raises
                itself passes through too; what was learned until then is kept.
        """
        stepper = self.stepper()
        with advancing(total_timesteps, is_shown=progress_bar) as advance:
            for _ in range(total_timesteps):
                result = stepper.step()
                advance(1)
                if callback is not None and callback(result) is False:
                    break
        self.settle()
        return self

    def stepper(self) -> Stepper:
        """Learns step by step, for loops of one's own; call `settle` when done."""
        return Stepper(
            self.env,
            self.spec,
            self._learner,
            lambda: training_seed(self._rng),
            learns=True,
            history=self.history,
            growth=self.growth,
        )

    def settle(self) -> None:
        """Lets what was learned settle; `learn` ends with it."""
        self.growth.extend(self._learner.sleep())

    def cleanse(self, tolerance: float = 0.05) -> Cleansed:
        """Lets go of options that its decisions hardly need: a smaller agent, easier to read.

        Best when learning is over: what it learns afterwards it learns with fewer options.

        Args:
            tolerance: By how much what an action is expected to earn may change where options
                are or were, in standard deviations of what options are worth; from 0 to 1.

        Returns:
            How many options went, and how many decisions changed: at the options' values, and in
            the states of the recorded episodes.

        Raises:
            ValueError: If the tolerance is out of range, or the preset is `paper`.
        """
        make_config(Preset.ANTICIPATING, {"cleansing": tolerance})
        values = self.forest.values[self.forest.is_alive]
        seen = np.concatenate([values, *(each.observations[:-1] for each in self.episodes)])
        before = np.array([self._learner.act_at(row) for row in seen])
        self.growth.extend(self._learner.cleanse(tolerance))
        n, left = len(values), len(self.forest)
        changed = before != np.array([self._learner.act_at(row) for row in seen])
        in_values, in_states = int(changed[:n].sum()), int(changed[n:].sum())
        return Cleansed(n, left, in_values, len(seen) - n, in_states)

    def set_decide_by(self, decide_by: DecideBy | str) -> None:
        """Switches between "vote" and "path"; allowed at any time.

        Raises:
            ValueError: If it is neither.
        """
        self.change_settings(decide_by=decide_by)

    def set_think_ahead(self, steps: int, limit: int | None = None) -> None:
        """Changes how many steps ahead every decision thinks; allowed at any time.

        Args:
            steps: Of the environment, 0 to 8; 0 does not think ahead, which is the fastest.
            limit: Milliseconds that one decision may take for it, 0 for as long as it takes;
                `None` leaves that as it is. With a limit, what it decides depends on the machine.

        Raises:
            ValueError: If a number is out of range, or the preset is `paper`: it does not learn
                what follows an action.
        """
        settings = {"think_ahead": steps, **({} if limit is None else {"think_limit": limit})}
        if self.preset is Preset.ANTICIPATING:
            self.change_settings(**settings)
        elif any(settings.values()):
            raise ValueError(
                "The paper preset does not learn what follows an action, so it cannot think "
                "ahead; the anticipating preset can."
            )

    def change_settings(self, **settings: Any) -> None:
        """Changes settings in the middle of a life; `settings_of` says which can, and from when on.

        Raises:
            ValueError: If one is unknown, out of range, or cannot change any more.
        """
        config = change_config(self.config, settings)
        check_changeable(self.preset, set(settings))
        self._learner.change({name: getattr(config, name) for name in settings})

    def decide(self, observation: ArrayLike) -> Decision:
        """What it would do, greedily, if it saw this, and everything that led to it."""
        return self._learner.decide_at(to_observation(observation, self.spec))

    def predict(
        self,
        observation: NDArray,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        """Actions in the environment's own terms, as stable-baselines3's algorithms give them.

        Args:
            observation: One of shape [D], or a batch [n, D] as vectorised environments give.
            state: With `action_smoothing`, what the call before returned, as with the recurrent
                policies of stable-baselines3; `None` begins episodes. Otherwise AO2 has no state,
                and whatever is given comes back unchanged.
            episode_start: With `action_smoothing`, whether an episode begins with this
                observation; for a batch one truth a row. Then what was executed before is
                forgotten.
            deterministic: Accepted for compatibility; AO2 always answers with the action it
                expects the most of.

        Returns:
            What `env.step` wants for one observation; for a batch an array with one action a
            row. And the `state` for the next call: what is executed now, [dims] or [n, dims].

        Raises:
            ValueError: If observation or state do not fit.
        """
        del deterministic
        is_batch = np.ndim(observation) == 2
        rows = observation if is_batch else [observation]
        chosen = [self._learner.act_at(to_observation(row, self.spec)) for row in rows]
        if self.config.action_smoothing == 1.0:
            actions = [self.spec.to_env_action(action) for action in chosen]
            return (np.array(actions) if is_batch else actions[0]), state
        last = last_executed(self.spec, state, episode_start, len(chosen))
        executed = np.array(
            [
                smooth(self.spec, action, before, self.config.action_smoothing)
                for action, before in zip(chosen, last, strict=True)
            ]
        )
        executed = executed if is_batch else executed[0]
        return executed.astype(np.float32), executed

    def evaluate(self, episodes: int = 100, seed: int = 0) -> NDArray[np.float64]:
        """The return of each of so many greedy episodes; learns nothing.

        Episode i starts from `evaluation_seed(seed, i)`, which training never draws.
        """
        act, smoothing = self._learner.act_at, self.config.action_smoothing
        seeds = [evaluation_seed(seed, i) for i in range(episodes)]
        returns = [play(self.env, self.spec, act, each, smoothing) for each in seeds]
        return np.array(returns, np.float64)

    def record_episode(self, seed: int) -> Episode:
        """Plays one greedy episode with every decision, and adds it to `episodes`.

        The environment is reset with exactly this seed.
        """
        stepper = Stepper(self.env, self.spec, self._learner, lambda: seed, learns=False)
        while not stepper.step().has_ended:
            pass
        episode = stepper.episode()
        assert episode is not None  # It has at least the step just taken.
        self.episodes.append(episode)
        return episode

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes everything to one .ao2 file; a kill at any moment leaves the old or the new.

        Raises:
            OSError: If the file cannot be written.
        """
        write(path, self.to_saved())

    def to_saved(self) -> SavedAgent:
        """Everything that a file holds, as frozen copies."""
        return SavedAgent(
            spec=self.spec,
            config=self.config,
            seed=self.seed,
            n_steps=self.num_timesteps,
            state=self._learner.get_state(),
            generator=get_generator(self._rng),
            history=self.history.to_array(),
            growth=self.growth.to_arrays(),
            growth_dropped=self.growth.dropped,
            episodes=tuple(self.episodes),
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str], env: str | gym.Env | None = None) -> "AO2":
        """The agent that `save` wrote; it continues as if it had never stopped, to the bit.

        Args:
            path: The .ao2 file.
            env: Its environment; made from the id in the file, when first needed, if not given.

        Raises:
            AgentFileError: If the file is not an agent, broken, or from a newer ao2viz.
            ValueError: If `env` does not fit the agent.
        """
        saved = read(path)
        try:
            return cls.from_saved(saved, env)
        except AgentFileError as error:
            raise AgentFileError(f"Could not open {str(path)!r}. {error}") from error

    @classmethod
    def from_saved(cls, saved: SavedAgent, env: str | gym.Env | None = None) -> "AO2":
        """The agent of a file that was read; see `load`."""
        agent = cls.__new__(cls)
        agent.spec = saved.spec
        given = make_env(env) if isinstance(env, str) else env
        agent._env = None if given is None else check_match(check_env(given), saved.spec)
        agent._setup(saved.config, saved.seed)
        try:
            agent._learner.set_state(dict(saved.state))
        except ValueError as error:
            raise AgentFileError(f"What this agent learned is not sound: {error}") from error
        if agent.num_timesteps != saved.n_steps:
            raise AgentFileError(
                f"Expected an agent of {saved.n_steps} steps, but it has {agent.num_timesteps}."
            )
        set_generator(agent._rng, saved.generator)
        agent.history = History.from_array(saved.history)
        agent.growth = GrowthLog.from_arrays(dict(saved.growth), saved.growth_dropped)
        agent.episodes = list(saved.episodes)
        return agent

    def __repr__(self) -> str:
        return (
            f"<AO2 {self.preset.value} on {self.spec.env_id}: {len(self.forest):,} options after "
            f"{self.num_timesteps:,} steps>"
        )

    def _repr_html_(self) -> str:
        """What notebooks show."""
        spec, history = self.spec, self.history.to_array()
        return make_card(
            "AO2 agent",
            summarise(spec, self.config, self.seed, self.num_timesteps, self.forest, history),
            history[:, 1].tolist(),
            "return of each training episode",
        )
