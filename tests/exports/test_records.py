"""Minari and TensorBoard read what was written for them."""

import os
from dataclasses import replace
from pathlib import Path

import minari
import numpy as np
import pytest
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from ao2viz import AO2, export
from ao2viz.exports.records import dataset_name
from ao2viz.store.saved import SavedAgent
from tests.exports.conftest import Export


@pytest.mark.parametrize("name", ["cartpole", "pendulum"])
def test_minari_loads_the_episodes_and_plays_them_again(
    name: str,
    request: pytest.FixtureRequest,
    write: Export,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    agent: SavedAgent = request.getfixturevalue(name)
    folder = write(agent, "minari")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(folder))
    dataset = minari.load_dataset(dataset_name(agent.spec))
    assert dataset.total_episodes == 2
    env = dataset.recover_environment(render_mode="rgb_array")
    seeds = [int(m["seed"]) for m in dataset.storage.get_episode_metadata([0, 1])]
    for episode, read, seed in zip(agent.episodes, dataset, seeds, strict=True):
        assert seed == episode.seed
        np.testing.assert_array_equal(read.observations, episode.observations)
        np.testing.assert_allclose(read.rewards, episode.rewards, rtol=0, atol=1e-12)
        observation, _ = env.reset(seed=seed)
        pictures = [env.render()]
        for t, action in enumerate(read.actions):
            np.testing.assert_array_equal(observation, read.observations[t])
            observation, reward, _, _, _ = env.step(action)
            assert reward == read.rewards[t]
            pictures.append(env.render())
        assert np.abs(pictures[0].astype(int) - pictures[-1]).max() > 0
        assert read.truncations[-1]
        assert not read.terminations.any()
    env.close()


def test_smoothed_actions_are_kept_as_they_were_executed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    agent = AO2("Pendulum-v1", seed=0, action_smoothing=0.5).learn(300)
    agent.record_episode(2)
    folder = export(agent, tmp_path / "data", "minari")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(folder))
    (read,) = minari.load_dataset("pendulum-v1/ao2viz-v0")
    assert len(np.unique(read.actions)) > 5  # More than the grid has.
    env = agent.env
    observation, _ = env.reset(seed=2)
    for t, action in enumerate(read.actions):
        np.testing.assert_array_equal(observation, read.observations[t])
        observation = env.step(action)[0]


def test_minari_elsewhere_is_left_alone(
    cartpole: SavedAgent, write: Export, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "mine"))
    write(cartpole, "minari")
    assert os.environ["MINARI_DATASETS_PATH"] == str(tmp_path / "mine")
    assert not (tmp_path / "mine").exists()


def test_a_folder_can_be_named_from_here(
    cartpole: SavedAgent, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    export(cartpole, "data", "minari")
    monkeypatch.setenv("MINARI_DATASETS_PATH", "data")
    assert minari.load_dataset("cartpole-v1/ao2viz-v0").total_episodes == 2


def test_tensorboard_reads_every_scalar(pendulum: SavedAgent, write: Export) -> None:
    shares: list[float] = []
    folder = write(pendulum, "tensorboard", progress=shares.append)
    assert shares[-1] == 1.0
    found = EventAccumulator(str(folder), size_guidance={"scalars": 0}).Reload()
    returns = found.Scalars("training/return")
    assert [event.step for event in returns] == pendulum.history[:, 0].tolist()
    assert [event.value for event in returns] == pytest.approx(pendulum.history[:, 1], rel=1e-6)
    margins = found.Scalars("episode_1/margin")
    expected = [decision.margin for decision in pendulum.episodes[1].decisions]
    assert [event.value for event in margins] == pytest.approx(expected, rel=1e-6)
    assert len(found.Tags()["scalars"]) == 3 + 2 * 4


@pytest.mark.parametrize("format", ["minari", "tensorboard"])
def test_a_folder_is_never_replaced_and_never_half(
    cartpole: SavedAgent, write: Export, tmp_path: Path, format: str
) -> None:
    def stop(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match=r"^$"):
        write(cartpole, format, progress=stop)
    assert list(tmp_path.iterdir()) == []
    folder = write(cartpole, format)
    (folder / "mine").write_text("mine")
    with pytest.raises(ValueError, match="needs a new folder"):
        write(cartpole, format, overwrite=True)
    assert (folder / "mine").read_text() == "mine"


def test_data_sets_need_an_episode_scalars_do_not(cartpole: SavedAgent, write: Export) -> None:
    silent = replace(cartpole, episodes=())
    with pytest.raises(ValueError, match="ao2viz record"):
        write(silent, "minari")
    write(silent, "tensorboard")


def test_any_environment_gets_a_name_that_minari_allows(cartpole: SavedAgent) -> None:
    odd = replace(cartpole.spec, env_id='ALE/"Pong"-v5; rm -rf')
    assert dataset_name(odd) == "ale-pong-v5-rm-rf/ao2viz-v0"
    assert dataset_name(replace(cartpole.spec, env_id="中")) == "environment/ao2viz-v0"
