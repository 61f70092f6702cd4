"""The compared algorithms in the same table, beside AO2, measured in the same way."""

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from ao2viz import AO2, baselines
from ao2viz.baselines.algorithm import Acting, Algorithm
from ao2viz.core.config import Preset
from ao2viz.experiments.measure import attempt, measure
from ao2viz.experiments.plan import Run, Schedule
from ao2viz.experiments.statistics import summarise
from ao2viz.experiments.table import SCHEMA, opened, read
from tests.experiments.evaluations import both_ways

SMALL = '{"envs": 2, "hidden": 8, "minibatch": 32, "rollout": 16}'
RIVAL = Run("CartPole-v1", Algorithm.DAC_PPO, SMALL, 3)
SCHEDULE = Schedule((64, 320), episodes=3)


@pytest.fixture(scope="module")
def rows():
    return tuple(measure(RIVAL, SCHEDULE))


def test_a_rival_is_measured_at_every_checkpoint_in_both_ways(rows):
    assert [(one.steps, one.decide_by) for one in rows] == [
        (steps, acting) for steps in (64, 320) for acting in Acting
    ]
    for one in rows:
        agent = baselines.make("dac+ppo", "CartPole-v1", 3, **RIVAL.overrides).learn(one.steps)
        returns = agent.evaluate(3, deterministic=one.decide_by is Acting.GREEDY)
        assert one.returns == tuple(returns.tolist())
        assert one.options == agent.n_parameters
    assert 0 < rows[0].cpu_s < rows[-1].cpu_s


def test_training_episodes_are_told_once(rows):
    agent = baselines.make("dac+ppo", "CartPole-v1", 3, **RIVAL.overrides).learn(320)
    history = agent.history.to_array()
    assert [end for one in rows for end in one.episode_ends] == history[:, 0].tolist()
    assert [earned for one in rows for earned in one.episode_returns] == history[:, 1].tolist()
    assert all(one.episode_ends == () for one in rows if one.decide_by is Acting.SAMPLED)
    ours = list(measure(Run("CartPole-v1", Preset.PAPER, "{}", 3), Schedule((200, 500), 1)))
    told = [earned for one in ours for earned in one.episode_returns]
    assert told == AO2("CartPole-v1", "paper", 3).learn(500).history.to_array()[:, 1].tolist()


def test_rivals_and_ao2_share_a_table(tmp_path, rows):
    path = tmp_path / "r.parquet"
    with opened(path) as table:
        table.add([*rows, *both_ways()])
        assert table.holds(RIVAL, SCHEDULE)
        assert not table.holds(RIVAL, Schedule((64, 352), episodes=3))
    assert read(path) == [*rows, *both_ways()]
    groups = {(one.preset, one.decide_by) for one in summarise(read(path))}
    assert (Algorithm.DAC_PPO, Acting.SAMPLED) in groups
    assert len(groups) == 4


def test_a_table_of_format_1_is_read_and_gone_on_with(tmp_path):
    path = tmp_path / "old.parquet"
    with opened(path) as table:
        table.add(both_ways(1.0, 3.0))
    old = pq.read_table(path).drop_columns(["episode_ends", "episode_returns"])
    pq.write_table(old.replace_schema_metadata({"ao2viz_results": "1"}), path)
    assert read(path) == list(both_ways(1.0, 3.0))
    with opened(path) as table:
        table.add(both_ways(5.0, 5.0, steps=2000))
    assert len(read(path)) == 4
    assert pq.read_schema(path).names == SCHEMA.names


def test_training_episodes_that_do_not_pair_are_refused(tmp_path, rows):
    path = tmp_path / "r.parquet"
    with opened(path) as table:
        table.add(rows)
    broken = [row | {"episode_ends": [1]} for row in pq.read_table(path).to_pylist()]
    pq.write_table(pa.Table.from_pylist(broken, SCHEMA), path)
    with pytest.raises(ValueError, match="the end and the return of every training episode"):
        read(path)


def test_a_checkpoint_within_an_update_fails_in_words():
    outcome = attempt(RIVAL, Schedule((50,), episodes=1))
    assert outcome.error == (
        "ValueError: dac+ppo can be evaluated after multiples of 32 steps, but a checkpoint is 50."
    )
