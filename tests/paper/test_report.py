"""The report: the paper beside ours, what is missing, and nothing that was not measured."""

import html
import itertools
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ao2viz.baselines.algorithm import Acting, Algorithm
from ao2viz.core.config import Preset
from ao2viz.core.decision import DecideBy
from ao2viz.experiments.measure import Evaluation
from ao2viz.experiments.table import read
from ao2viz.paper.document import Paragraph, Section, Table, pictures_of, to_markdown, to_page
from ao2viz.paper.findings import TITLE, report
from ao2viz.paper.phases import find_phases
from ao2viz.paper.plan import FULL, QUICK, make_tasks
from tests.experiments.evaluations import evaluation

DOCS = Path(__file__).resolve().parents[2] / "docs" / "paper"
TASKS = make_tasks(QUICK, 2, 1)
COMMAND = "ao2viz paper --quick"


def measured(learner, env, final, settings="{}", seed=900, training=False) -> list[Evaluation]:
    """A run that rises to `final` at its last checkpoint, and earns 1 less in the other way."""
    (task,) = (
        task
        for task in TASKS
        if (task.run.preset, task.run.env, task.run.settings, task.run.seed)
        == (learner, env, settings, seed)
    )
    main = DecideBy.PATH if isinstance(learner, Preset) else Acting.GREEDY
    rows = []
    for back, steps in enumerate(reversed(task.schedule.checkpoints)):
        for way in task.run.ways:
            earned = final - 100 * back - (way is not main)
            row = evaluation(earned, of=task.run, steps=steps, decide_by=way)
            if training and way is task.run.ways[0]:
                ends = np.arange(steps - 4000, steps, 200).tolist()
                returns = tuple(-1000.0 + 300 * (steps > 20_000) for _ in ends)
                row = Evaluation(
                    **{**vars(row), "episode_ends": tuple(ends), "episode_returns": returns}
                )
            rows.append(row)
    return rows


ROWS = [
    *measured(Preset.PAPER, "Pendulum-v1", -250.0, training=True),
    *measured(Preset.PAPER, "Pendulum-v1", -180.0, seed=901, training=True),
    *measured(Algorithm.PPO, "CartPole-v0", 199.0),
    *measured(Preset.PAPER, "Pendulum-v1", -160.0, settings='{"epsilon": 0.1}'),
]


def lines(markdown: str, section: str, row: str) -> list[list[str]]:
    text = re.search(rf"^## {re.escape(section)}$(.*?)(?=^## |\Z)", markdown, re.M | re.S)
    assert text is not None
    return [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in text[1].splitlines()
        if line.startswith(f"| {row} |")
    ]


@pytest.fixture(scope="module")
def markdown():
    return to_markdown(TITLE, report(ROWS, TASKS, COMMAND))


def test_the_report_in_the_documentation_is_that_of_its_runs():
    written = (DOCS / "report.md").read_text("utf-8")
    command = "ao2viz paper --seeds 5 --rival-seeds 3 --out docs/paper"
    sections = report(read(DOCS / "results.parquet"), make_tasks(FULL, 5, 3), command)

    def less_versions(markdown: str) -> str:
        return re.sub(r"This report was written with .*", "", markdown)

    assert less_versions(to_markdown(TITLE, sections)) == less_versions(written)
    pictures = pictures_of(sections)
    assert set(pictures) == {path.name for path in DOCS.glob("*.svg")}
    for name, svg in pictures.items():
        assert svg == (DOCS / name).read_text("utf-8"), name


def test_a_cell_holds_the_papers_figure_and_ours_and_marks_what_misses(markdown):
    ((_, best, ours, average, mean, iqm, other, seeds, *rest),) = lines(
        markdown, "Pendulum-v1", "AO2 paper"
    )
    assert (best, ours) == ("−126.6", "−180.0 ▼")
    assert (average, mean) == ("−196.6", "−215.0 ▼")
    assert iqm.startswith("−215.0 [−250.0, −180.0]")
    assert (other, seeds) == ("−216.0", "2 of 2")
    assert rest[0] == f"{TASKS[1].schedule.checkpoints[-1]:,}"
    assert rest[-1].endswith("(1 of 2)"), "Only one seed reached −196.6."
    ((_, best, ours, average, mean, *_, there),) = lines(markdown, "CartPole-v0", "PPO")
    assert (best, ours, average, mean) == ("196.8", "199.0", "191.5", "199.0")
    assert there.endswith("(1 of 1)")


def test_what_was_not_run_is_shown_as_not_run(markdown):
    assert f"4 of {len(TASKS)} runs are done; what is missing" in markdown
    run = {row.run for row in ROWS}
    whole = report(ROWS, [task for task in TASKS if task.run in run], COMMAND)
    assert "4 of 4 runs are done. Measured" in to_markdown(TITLE, whole)
    ((_, best, ours, average, mean, *_, seeds),) = lines(markdown, "Acrobot-v1", "DAC+PPO")
    assert (best, ours, average, mean, seeds) == ("−59.38", "–", "−69.24", "–", "0 of 1")


def test_the_report_of_nothing_says_so():
    empty = to_markdown(TITLE, report([], TASKS, COMMAND))
    assert f"0 of {len(TASKS)} runs are done" in empty
    assert empty.count("Not run yet.") == 3
    assert "|  |" not in empty
    assert to_page(TITLE, report([], TASKS, COMMAND)).count("<svg") == 0


def test_an_unfinished_run_does_not_count_as_whole():
    half = [row for row in ROWS if row.run.preset is Algorithm.PPO][:-2]
    assert f"0 of {len(TASKS)} runs are done" in to_markdown(TITLE, report(half, TASKS, COMMAND))


def test_behaviours_and_every_seed_are_told(markdown):
    ((_, _, best, ours, average, mean, seeds),) = lines(
        markdown, "Behaviour experiments", "exploration"
    )
    assert (best, ours, average, mean, seeds) == ("−135", "−160.0 ▼", "−168", "−160.0", "1")
    found = lines(markdown, "Every seed", "Pendulum-v1")
    assert [(row[1], row[2], row[4], row[5]) for row in found] == [
        ("AO2 paper", "900", "−250.0", "−251.0"),
        ("AO2 paper", "901", "−180.0", "−181.0"),
    ]


def test_the_training_curve_has_its_phases(markdown):
    assert "three phases" in markdown
    assert "−1,000.0 up to" in markdown
    assert "−700.0 up to" in markdown


def test_the_page_loads_nothing_and_shows_every_chart(markdown):
    page = to_page(TITLE, report(ROWS, TASKS, COMMAND))
    pictures = pictures_of(report(ROWS, TASKS, COMMAND))
    assert set(pictures) == {
        "curves-CartPole-v0.svg", "curves-Pendulum-v1.svg", "training-Pendulum.svg",
    }  # fmt: skip
    assert page.count("<svg") == 3
    assert not re.search(r"(?:src|href)=|@import|url\(", page)
    assert "default-src 'none'" in html.unescape(page)
    for name, svg in pictures.items():
        assert f"]({name})" in markdown
        assert "currentColor" not in svg


def test_texts_are_escaped_on_the_page():
    evil = "<script>alert(1)</script>"
    page = to_page(evil, [Section(evil, [Paragraph(evil), Table([evil], [[evil]])])])
    assert "<script" not in page
    assert page.count("&lt;script&gt;") == 6


@given(st.lists(st.integers(-50, 50), min_size=3, max_size=9), st.integers(1, 3))
def test_phases_are_the_best_division_there_is(values, count):
    found = find_phases(np.array(values, float), count)
    assert [phase.first for phase in found[1:]] == [phase.past for phase in found[:-1]]
    assert (found[0].first, found[-1].past, len(found)) == (0, len(values), count)

    def cost(cuts):
        ends = [0, *cuts, len(values)]
        parts = [values[a:b] for a, b in itertools.pairwise(ends)]
        return sum(np.var(part) * len(part) for part in parts)

    n = len(values)
    divisions = {
        1: [()],
        2: [(i,) for i in range(1, n)],
        3: [(i, j) for i in range(1, n) for j in range(i + 1, n)],
    }[count]
    least = min(cost(cuts) for cuts in divisions)
    assert cost([phase.first for phase in found[1:]]) == pytest.approx(least, abs=1e-6)


def test_too_many_phases_are_refused():
    with pytest.raises(ValueError, match="Expected 1 to 2 phases of 2 values, but got 3"):
        find_phases(np.zeros(2), 3)
