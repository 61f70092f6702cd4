"""The policy file acts as the agent does, in an interpreter that has numpy and nothing else."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from numpy.typing import NDArray

import ao2viz
from ao2viz import AO2
from ao2viz.resources import saved_schemas
from ao2viz.store.files import read
from ao2viz.store.saved import SavedAgent
from tests.exports.conftest import Export

SHIPPED = sorted(path.stem for path in saved_schemas().glob("*.ao2"))

# No site packages, no environment variables, no user folder: numpy is put in its way by hand.
PROGRAM = """
import sys
sys.path[:0] = sys.argv[1:3]
import numpy as np
before = set(sys.modules)
import policy
assert set(sys.modules) - before <= {"policy", "zlib"}, set(sys.modules) - before
states = np.load(sys.argv[3], allow_pickle=False)
np.save(sys.argv[4], np.array([policy.choose(state) for state in states]))
print(policy.act(states[0]))
"""


def run_bare(policy: Path, states: NDArray[np.float64], folder: Path) -> tuple[list[int], str]:
    """The actions that the file chooses, and what it hands to the environment for the first."""
    bare = folder / "bare"
    bare.mkdir()
    installed = Path(np.__file__).parent
    for package in (installed, installed.with_name("numpy.libs")):
        if package.exists():
            (bare / package.name).symlink_to(package)
    (bare / "policy.py").write_bytes(policy.read_bytes())
    np.save(folder / "states.npy", states)
    done = subprocess.run(
        [
            *(sys.executable, "-I", "-S", "-c", PROGRAM, str(bare), str(bare)),
            *(str(folder / "states.npy"), str(folder / "chosen.npy")),
        ],
        check=False,
        capture_output=True,
        text=True,
        env={"PATH": os.defpath},
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    return np.load(folder / "chosen.npy", allow_pickle=False).tolist(), done.stdout.strip()


def states_of(agent: SavedAgent) -> NDArray[np.float64]:
    """Every recorded state, 10,000 random ones near and far, and options' own values."""
    rng = np.random.default_rng(5)
    view = agent.forest_view()
    known = view.values[view.is_alive]
    low, high = known.min(axis=0), known.max(axis=0)
    wide = rng.uniform(low - (high - low) / 2, high + (high - low) / 2, (5_000, len(low)))
    near = known[rng.integers(len(known), size=5_000)]
    near = near + rng.normal(size=near.shape) * (high - low) * 0.02
    recorded = [episode.observations for episode in agent.episodes]
    zeros = np.array([np.zeros(len(low)), -np.zeros(len(low))])
    return np.concatenate([*recorded, wide, near, known[:500], zeros])


@pytest.mark.parametrize("env_id", SHIPPED)
def test_it_chooses_as_the_agent_does(env_id: str, write: Export, tmp_path: Path) -> None:
    saved = read(saved_schemas() / f"{env_id}.ao2")
    states = states_of(saved)
    agent = AO2.from_saved(saved)
    expected = [agent.decide(state).action for state in states]
    chosen, _ = run_bare(write(saved, "policy"), states, tmp_path)
    assert chosen == expected


def test_it_chooses_as_the_paper_preset_does_ties_and_all(tmp_path: Path) -> None:
    agent = AO2("MountainCar-v0", preset="paper", seed=0).learn(300)
    agent.record_episode(3)
    saved = agent.to_saved()
    states = states_of(saved)
    decisions = [agent.decide(state) for state in states]
    assert sum(decision.is_tie for decision in decisions) > 100
    path = ao2viz.export(saved, tmp_path / "policy.py", "policy")
    chosen, _ = run_bare(path, states, tmp_path)
    assert chosen == [decision.action for decision in decisions]


def test_an_agent_that_knows_nothing_has_a_policy_too(tmp_path: Path) -> None:
    agent = AO2("CartPole-v1", seed=0)
    states = np.random.default_rng(0).normal(size=(200, 4))
    path = ao2viz.export(agent, tmp_path / "policy.py", "policy")
    chosen, _ = run_bare(path, states, tmp_path)
    assert chosen == [agent.decide(state).action for state in states]


@pytest.mark.parametrize("env_id", ["CartPole-v1", "Pendulum-v1"])
def test_it_plays_the_same_episode(env_id: str, write: Export, tmp_path: Path) -> None:
    agent = read(saved_schemas() / f"{env_id}.ao2")
    episode = agent.episodes[0]
    program = (
        "import sys, json; sys.path.insert(0, sys.argv[1]); import policy, gymnasium\n"
        f"env = gymnasium.make({env_id!r}); seen, _ = env.reset(seed={episode.seed})\n"
        "total, done = 0.0, False\n"
        "while not done:\n"
        "    seen, reward, ended, cut, _ = env.step(policy.act(seen))\n"
        "    total, done = total + float(reward), ended or cut\n"
        "print(json.dumps(total))"
    )
    folder = tmp_path / "code"
    folder.mkdir()
    write(agent, "policy").rename(folder / "policy.py")
    done = subprocess.run(
        [sys.executable, "-c", program, str(folder)],
        check=True,
        capture_output=True,
        text=True,
    )
    assert json.loads(done.stdout) == pytest.approx(episode.total_reward, abs=1e-9)


def test_it_hands_over_what_the_environment_takes(tmp_path: Path) -> None:
    for env_id in ("CartPole-v1", "Pendulum-v1"):
        saved = read(saved_schemas() / f"{env_id}.ao2")
        (tmp_path / env_id).mkdir()
        path = ao2viz.export(saved, tmp_path / env_id / "policy.py", "policy")
        states = saved.episodes[0].observations[:1]
        _, shown = run_bare(path, states, tmp_path / env_id)
        space = gym.make(env_id).action_space
        given = AO2.from_saved(saved).predict(states[0])[0]
        assert space.contains(given)
        assert shown == str(given)


def test_wrong_observations_are_told(cartpole: SavedAgent, write: Export, tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="Expected 4 finite numbers, cart position"):
        run_bare(write(cartpole, "policy"), np.zeros((1, 3)), tmp_path)


def test_hostile_names_are_strings(tiny: SavedAgent, write: Export, tmp_path: Path) -> None:
    spec = replace(
        tiny.spec,
        env_id='CartPole-v1"""\\',
        action_names=('"""\nimport os\n', "{0.__class__}"),
    )
    saved = replace(tiny, spec=spec)
    states = states_of(saved)[:300]
    chosen, _ = run_bare(write(saved, "policy"), states, tmp_path)
    agent = AO2.from_saved(tiny)
    assert chosen == [agent.decide(state).action for state in states]


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"decide_by": "vote"}, r'set_decide_by\("path"\)'),
        ({"think_ahead": 2}, r"set_think_ahead\(0\)"),
    ],
)
def test_what_a_file_cannot_do_is_refused(write: Export, settings: dict, words: str) -> None:
    agent = AO2("CartPole-v1", seed=0, **settings)
    with pytest.raises(ValueError, match=words):
        write(agent.to_saved(), "policy")


def test_smoothed_actions_are_refused(write: Export) -> None:
    agent = AO2("Pendulum-v1", seed=0, action_smoothing=0.5)
    with pytest.raises(ValueError, match="smoothed"):
        write(agent.to_saved(), "policy")
