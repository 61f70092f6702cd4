"""What each command does when all is well, and that a program can read it."""

import json
import shutil
import statistics
import time
from pathlib import Path

import pytest

import ao2viz
from tests.cli.processes import Cli


def test_help_names_every_command_and_is_quick(cli: Cli) -> None:
    started = time.perf_counter()
    done = cli("--help")
    assert time.perf_counter() - started < 5  # Under a second on a machine with nothing else to do.
    assert done.returncode == 0
    for command in ("app", "train", "evaluate", "record", "info", "list"):
        assert command in done.stdout


def test_train_saves_an_agent_that_python_can_load(cli: Cli, tmp_path: Path) -> None:
    done = cli(
        "train", "Pendulum-v1", "--steps", "700", "--preset", "paper", "--seed", "5",
        "--out", "deep/er/agent.ao2", "--set", "threshold=0.95", "--set", "decide_by=vote",
        "--set", "action_bins=3", "--set", "action_smoothing=0.9", "--set", "impression=0.04",
        "--set", "max_depth=1",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "Saved to deep/er/agent.ao2" in done.stdout
    agent = ao2viz.AO2.load(tmp_path / "deep/er/agent.ao2")
    assert agent.num_timesteps == 700
    assert agent.seed == 5
    assert agent.preset is ao2viz.Preset.PAPER
    assert agent.config.decide_by is ao2viz.DecideBy.VOTE
    assert agent.spec.n_actions == 3
    assert vars(agent.config)["threshold"] == 0.95
    text = cli("info", "deep/er/agent.ao2").stdout
    assert "action_smoothing 0.9, impression 0.04, max_depth 1" in text
    recorded = cli("record", "deep/er/agent.ao2", "--seed", "3")
    assert recorded.returncode == 0, recorded.stderr
    assert ao2viz.AO2.load(tmp_path / "deep/er/agent.ao2").episodes[0].action_smoothing == 0.9


def test_train_without_out_says_where_it_saved(cli: Cli, tmp_path: Path) -> None:
    done = cli("train", "CartPole-v1", "--steps", "300", "--json")
    summary = json.loads(done.stdout)
    assert summary["file"] == "runs/CartPole-v1-anticipating-seed0.ao2"
    assert summary["steps"] == 300
    assert (tmp_path / summary["file"]).is_file()


def test_the_same_seed_gives_the_same_forest_in_another_process(cli: Cli, tmp_path: Path) -> None:
    for name in ("one.ao2", "two.ao2"):
        assert cli("train", "CartPole-v1", "--steps", "800", "--out", name).returncode == 0
    one, two = (ao2viz.AO2.load(tmp_path / name).forest for name in ("one.ao2", "two.ao2"))
    assert len(one) > 0
    assert one.values.tobytes() == two.values.tobytes()
    assert one.weights.tobytes() == two.weights.tobytes()


def test_train_replaces_a_file_only_if_asked(cli: Cli, tmp_path: Path) -> None:
    arguments = ("train", "CartPole-v1", "--steps", "300", "--out", "agent.ao2")
    assert cli(*arguments).returncode == 0
    before = (tmp_path / "agent.ao2").read_bytes()
    refused = cli(*arguments, "--seed", "1")
    assert refused.returncode == 2
    assert "agent.ao2 is there already" in refused.stderr
    assert (tmp_path / "agent.ao2").read_bytes() == before
    assert cli(*arguments, "--seed", "1", "--overwrite").returncode == 0
    assert (tmp_path / "agent.ao2").read_bytes() != before


def test_a_saved_agent_goes_on_as_if_it_had_never_stopped(cli: Cli, tmp_path: Path) -> None:
    assert cli("train", "CartPole-v1", "--steps", "400", "--out", "a.ao2").returncode == 0
    refused = cli("train", "a.ao2", "--steps", "300")
    assert refused.returncode == 2
    assert "a.ao2 is there already" in refused.stderr
    done = cli("train", "a.ao2", "--steps", "300", "--out", "b.ao2", "--set", "slip=0.1")
    assert done.returncode == 0, done.stderr
    assert "300 steps after 400 earlier ones" in done.stdout
    expected = ao2viz.AO2.load(tmp_path / "a.ao2")
    expected.change_settings(slip=0.1)
    expected.learn(300)
    agent = ao2viz.AO2.load(tmp_path / "b.ao2")
    assert agent.num_timesteps == 700
    assert vars(agent.config)["slip"] == 0.1
    assert agent.forest.values.tobytes() == expected.forest.values.tobytes()
    assert agent.forest.weights.tobytes() == expected.forest.weights.tobytes()
    assert ao2viz.AO2.load(tmp_path / "a.ao2").num_timesteps == 400
    for wrong, words in (
        (("a.ao2", "--seed", "1", "--out", "c.ao2"), "leave out --preset and --seed"),
        (("a.ao2", "--set", "levels=2", "--out", "c.ao2"), "levels"),
        (("none.ao2",), "none.ao2"),
        (("CartPole-v1", "--env", "CartPole-v1"), "gets it as ENV"),
    ):
        done = cli("train", *wrong)
        assert done.returncode == 2, done.stdout
        assert words in done.stderr
        assert not (tmp_path / "c.ao2").exists()


def test_an_environment_that_raises_costs_nothing_that_was_learned(
    cli: Cli, tmp_path: Path
) -> None:
    (tmp_path / "exploding.py").write_text(
        "import gymnasium\n"
        "from gymnasium.envs.classic_control import CartPoleEnv\n"
        "class Exploding(CartPoleEnv):\n"
        "    left = 400\n"
        "    def step(self, action):\n"
        "        self.left -= 1\n"
        "        if self.left < 0:\n"
        "            raise RuntimeError('the motor\\nburned')\n"
        "        return super().step(action)\n"
        "gymnasium.register('Exploding-v0', Exploding)\n"
    )
    done = cli("train", "exploding:Exploding-v0", "--steps", "1000", "--out", "a.ao2", "--json")
    assert done.returncode == 1
    assert "RuntimeError: the motor burned" in done.stderr
    assert "Traceback" not in done.stderr
    assert json.loads(done.stdout)["steps"] == 400
    assert json.loads(cli("info", "a.ao2", "--json").stdout)["steps"] == 400
    # Such an environment is known only to those who import its module.
    unknown = cli("evaluate", "a.ao2", "--episodes", "1")
    assert unknown.returncode == 2
    assert "Exploding-v0" in unknown.stderr
    known = cli("evaluate", "a.ao2", "--episodes", "1", "--env", "exploding:Exploding-v0")
    assert known.returncode == 0, known.stderr


def test_evaluate_gives_every_return_and_their_statistics(cli: Cli, agent_file: Path) -> None:
    done = cli("evaluate", str(agent_file), "--episodes", "4", "--seed", "3", "--json")
    result = json.loads(done.stdout)
    expected = ao2viz.AO2.load(agent_file).evaluate(episodes=4, seed=3).tolist()
    assert result["returns"] == expected
    assert result["mean"] == pytest.approx(statistics.fmean(expected))
    assert result["std"] == pytest.approx(statistics.stdev(expected))
    assert result["standard_error"] == pytest.approx(statistics.stdev(expected) / 2)
    text = cli("evaluate", str(agent_file), "--episodes", "4", "--seed", "3").stdout
    assert f"Mean return      {statistics.fmean(expected):.2f}" in text
    assert " ".join(f"{value:.6g}" for value in expected) in text


def test_evaluate_can_think_ahead(cli: Cli, agent_file: Path) -> None:
    agent = ao2viz.AO2.load(agent_file)
    agent.set_think_ahead(2)
    arguments = ("evaluate", str(agent_file), "--episodes", "2", "--think-ahead", "2")
    result = json.loads(cli(*arguments, "--json").stdout)
    assert result["think_ahead"] == 2
    assert result["returns"] == agent.evaluate(episodes=2).tolist()
    assert "thinking 2 steps ahead, deciding by" in cli(*arguments).stdout
    refused = cli("evaluate", str(agent_file), "--think-ahead", "9")
    assert refused.returncode == 2
    assert "Expected think_ahead between 0 and 8" in refused.stderr


def test_evaluate_of_one_episode_claims_no_spread(cli: Cli, agent_file: Path) -> None:
    result = json.loads(cli("evaluate", str(agent_file), "--episodes", "1", "--json").stdout)
    assert len(result["returns"]) == 1
    assert result["std"] is None
    assert result["standard_error"] is None


def test_record_adds_episodes_to_the_file_or_to_a_copy(
    cli: Cli, agent_file: Path, tmp_path: Path
) -> None:
    shutil.copy(agent_file, tmp_path / "agent.ao2")
    done = cli("record", "agent.ao2", "--episodes", "2", "--seed", "3", "--json")
    recorded = json.loads(done.stdout)
    assert recorded["episodes_in_file"] == 2
    kept = ao2viz.AO2.load(tmp_path / "agent.ao2")
    assert [episode.total_reward for episode in kept.episodes] == (
        kept.evaluate(episodes=2, seed=3).tolist()
    )
    assert all(
        len(episode.decisions) == len(episode) and not episode.is_training
        for episode in kept.episodes
    )
    before = (tmp_path / "agent.ao2").read_bytes()
    assert "which now holds 3" in cli("record", "agent.ao2", "--out", "copy.ao2").stdout
    assert (tmp_path / "agent.ao2").read_bytes() == before
    assert len(ao2viz.AO2.load(tmp_path / "copy.ao2").episodes) == 3
    again = cli("record", "agent.ao2", "--out", "copy.ao2")
    assert again.returncode == 2
    assert "copy.ao2 is there already" in again.stderr


def test_info_says_what_the_file_holds(cli: Cli, agent_file: Path) -> None:
    agent = ao2viz.AO2.load(agent_file)
    result = json.loads(cli("info", str(agent_file), "--json").stdout)
    assert result["environment"] == "CartPole-v1"
    assert result["steps"] == 1500
    assert result["options"] == len(agent.forest)
    assert result["depth"] == agent.forest.depths.max() + 1
    assert result["settings"]["attention_width"] == 4.0
    assert result["attention"] == agent.forest.attention.tolist()
    text = cli("info", str(agent_file)).stdout
    assert "Cart pole, 500 steps (CartPole-v1)" in text
    assert f"{len(agent.forest):,} options" in text
    assert "pole angular velocity" in text


def test_list_shows_sound_and_broken_files(cli: Cli, agent_file: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    shutil.copy(agent_file, tmp_path / "mine/good.ao2")
    (tmp_path / "mine/bad.ao2").write_bytes(agent_file.read_bytes()[:500])
    (tmp_path / "mine/other.txt").write_text("not an agent")
    rows = json.loads(cli("list", "mine", "--json").stdout)
    assert [row["file"] for row in rows] == ["mine/bad.ao2", "mine/good.ao2"]
    assert "error" in rows[0]
    assert rows[1]["steps"] == 1500
    done = cli("list", "mine")
    assert done.returncode == 0
    assert "mine/good.ao2" in done.stdout
    assert "1,500" in done.stdout
    assert "bad.ao2" in done.stderr


def test_list_finds_what_train_made(cli: Cli) -> None:
    made = json.loads(cli("train", "CartPole-v1", "--steps", "300", "--json").stdout)["file"]
    rows = json.loads(cli("list", "--json").stdout)
    assert made in [row["file"] for row in rows]


def test_cleanse_saves_a_smaller_agent_and_says_what_changed(
    cli: Cli, agent_file: Path, tmp_path: Path
) -> None:
    before = agent_file.read_bytes()
    arguments = ("cleanse", str(agent_file), "--out", "small.ao2", "--tolerance", "0.5")
    done = cli(*arguments, "--json")
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    small = ao2viz.AO2.load(tmp_path / "small.ao2")
    assert len(small.forest) == summary["options_after"] < summary["options_before"]
    assert summary["values_changed"] == 0
    assert agent_file.read_bytes() == before
    refused = cli(*arguments)
    assert refused.returncode == 2
    assert "small.ao2 is there already" in refused.stderr
    text = cli(*arguments, "--overwrite").stdout
    gone = summary["options_before"] - summary["options_after"]
    assert f"{gone:,} of {summary['options_before']:,} options went" in text
