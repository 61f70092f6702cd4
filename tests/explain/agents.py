"""Minds and places to ask them, for the explanations that are proven by asking."""

from functools import cache

import numpy as np
from hypothesis import strategies as st

from ao2viz.agent import AO2
from ao2viz.core.config import AnticipatingConfig, Config, PaperConfig
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import Forest
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges
from ao2viz.resources import saved_schemas

BUNDLED = ["CartPole-v1", "Pendulum-v1", "MountainCar-v0", "Acrobot-v1"]
BOX = Ranges(np.full(3, -2.0), np.full(3, 2.0))


@cache
def bundled(env_id: str) -> AO2:
    return AO2.load(saved_schemas() / f"{env_id}.ao2")


def some_states(agent: AO2, step: int = 10) -> np.ndarray:
    return np.concatenate([episode.observations[:-1] for episode in agent.episodes])[::step]


def hand_made(
    values: list[list[float]],
    weights: list[list[float]],
    attention: list[float] | None = None,
    config: Config | None = None,
) -> Mind:
    """A mind of these options, each a root; by default it decides by their own weights."""
    forest = Forest(len(values[0]), len(weights[0]), np.ones(len(values[0])))
    if attention is not None:
        forest.set_attention(np.array(attention), 0)
    for n, value in enumerate(values):
        forest.add(np.array(value), NO_OPTION, n)
        forest.columns.weights[n] = weights[n]
    return Mind.from_view(forest.view(), PaperConfig() if config is None else config)


@st.composite
def minds(draw: st.DrawFn) -> Mind:
    """Small minds of both presets, three features; some on a grid, where much is equally far."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    n, n_actions = draw(st.integers(1, 40)), draw(st.integers(1, 4))
    values, weights = rng.uniform(-2, 2, (n, 3)), rng.normal(size=(n, n_actions))
    attention = rng.uniform(0.2, 2.0, 3)
    if draw(st.booleans()):
        # Sums of such numbers are not rounded, so that ties are ties.
        values, attention = np.round(values * 4) / 4, 2.0 ** np.round(np.log2(attention))
    if draw(st.booleans()):
        weights = np.round(weights)
    if draw(st.booleans()):
        attention[draw(st.integers(0, 2))] = 0.0
    config = draw(st.sampled_from([PaperConfig(), AnticipatingConfig()]))
    return hand_made(values.tolist(), weights.tolist(), attention.tolist(), config)


@st.composite
def places(draw: st.DrawFn) -> np.ndarray:
    """An observation in BOX."""
    place = np.array([draw(st.floats(-2, 2, width=16)) for _ in range(3)])
    return np.round(place * 64) / 64 if draw(st.booleans()) else place
