"""The tables in Markdown, and the page around them."""

from pathlib import Path

import pytest

from ao2viz.baselines.algorithm import Acting, Algorithm
from ao2viz.experiments.plan import Run
from ao2viz.experiments.provenance import provenance
from ao2viz.experiments.report import write_into
from ao2viz.experiments.statistics import summarise
from ao2viz.experiments.table import read
from tests.experiments.evaluations import both_ways, evaluation, run

ROWS = [
    *both_ways(1.0, 3.0, of=run(0)),
    *both_ways(4.0, 6.0, of=run(1)),
    *both_ways(0.0, 0.0, of=run(0), steps=500),
    *both_ways(0.0, 0.0, of=run(1), steps=500),
    *both_ways(-1500.0, -1500.0, of=run(0, "Pendulum-v1", levels=4)),
]


def report(page=None, rows=ROWS) -> str:
    return write_into(page, summarise(rows), "r.parquet")


DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.mark.parametrize("name", ["results", "behaviour", "ablations"])
def test_the_tables_in_the_documentation_are_those_of_their_runs(name):
    page = (DOCS / f"{name}.md").read_text("utf-8")
    table = DOCS / f"{name}.parquet"
    assert write_into(page, summarise(read(table)), table.name) == page


def test_a_new_page_has_both_tables():
    page = report()
    assert page.startswith("# Results\n\n<!-- results: begin -->\n")
    assert page.endswith("<!-- results: end -->\n")
    assert f"`ao2viz results r.parquet --markdown`, from runs of {provenance()}; 2 greedy" in page
    assert (
        "| CartPole-v1 | `anticipating` |  | 1,000 | 2 | 3.5 (2.0 … 5.0) | 3.5 (2.0 … 5.0) "
        "| 3.5 [2.0, 5.0] | 3.5 [2.0, 5.0] | 500 | 3.2, 3.2 (≤ 5) | 1.5 |" in page
    )
    assert "| Pendulum-v1 | `anticipating` | `levels=4` | 1,000 | 1 | −1,500.0 (−1,500.0 …" in page
    assert "### Pendulum-v1, `anticipating`, `levels=4`, 1,000 steps\n" in page
    assert "| 1 | 5.0 ± 1.0 | 5.0 ± 1.0 | 500 | 3.2, 3.2 (≤ 5) | 1.5 |" in page
    assert "| mean | 3.5 | 3.5 | 500 |" in page


def test_every_seed_is_shown_at_every_checkpoint():
    page = report()
    assert "### CartPole-v1, `anticipating`, 1,000 steps" in page
    assert "### CartPole-v1, `anticipating`, 500 steps" in page
    assert "| CartPole-v1 | `anticipating` |  | 500 | 2 |" in page


def test_a_column_that_says_nothing_is_left_out():
    assert "settings" in report()
    assert "settings" not in report(rows=both_ways())


def test_tables_have_as_many_cells_as_headings():
    for line in report().splitlines():
        if line.startswith("| ") and "task" in line:
            width = line.count("|")
        if line.startswith("| CartPole") or line.startswith("| Pendulum"):
            assert line.count("|") == width


def test_a_way_of_deciding_that_is_not_there_is_a_dash():
    page = report(rows=[evaluation(1.0, 3.0)])
    assert "| 0 | 2.0 ± 1.0 | – | 500 | 3.2 (≤ 5) | 1.5 |" in page


def test_a_network_has_its_own_ways_and_no_stack():
    rival = Run("CartPole-v1", Algorithm.PPO, "{}", 7)
    greedy = evaluation(4.0, 6.0, of=rival, decide_by=Acting.GREEDY)
    drawn = evaluation(1.0, 3.0, of=rival, decide_by=Acting.SAMPLED)
    page = report(rows=[greedy, drawn])
    assert "| seeds | drawn | greedy | IQM drawn | IQM greedy | parameters | stack |" in page
    assert "| 2.0 (2.0 … 2.0) | 5.0 (5.0 … 5.0) | 2.0 | 5.0 | 500 | – | 1.5 |" in page
    assert "| seed | drawn | greedy | parameters | stack | CPU s |" in page
    assert "| 7 | 2.0 ± 1.0 | 5.0 ± 1.0 | 500 | – | 1.5 |" in page
    assert "2 episodes each" in page
    beside = report(rows=[greedy, drawn, *both_ways(7.0, 9.0)])
    assert "| by vote or drawn | by one path or greedy |" in beside
    assert "| options or parameters | stack |" in beside
    assert "| seed | by vote | by one path | options | stack | CPU s |" in beside
    assert "| seed | drawn | greedy | parameters | stack | CPU s |" in beside
    assert "| 0 | 8.0 ± 1.0 | 8.0 ± 1.0 | 500 | 3.2, 3.2 (≤ 5) | 1.5 |" in beside


def test_what_people_wrote_around_the_tables_stays():
    page = (
        "# Mine\n\nbefore\n\n<!-- results: in short -->\nold\n<!-- results: end -->\n\nbetween\n"
        "<!-- results: every seed -->\n<!-- results: end -->\nafter"
    )
    made = report(page)
    assert made.startswith("# Mine\n\nbefore\n\n<!-- results: in short -->\n\nMade by")
    assert "old" not in made
    assert made.endswith("<!-- results: end -->\nafter")
    assert made.index("| task |") < made.index("\nbetween\n") < made.index("| seed |")
    assert "## In short" not in made
    assert report(made) == made, "Writing twice changes nothing."


def test_a_page_without_a_place_is_refused():
    with pytest.raises(ValueError, match="where the tables go, one of <!-- results: begin -->"):
        report("# Mine\n")


@pytest.mark.parametrize(
    "page",
    [
        "<!-- results: begin -->\nno end",
        "<!-- results: in short -->\n<!-- results: every seed -->\n<!-- results: end -->\n",
    ],
)
def test_a_place_without_an_end_is_refused(page):
    with pytest.raises(ValueError, match="Expected <!-- results: end --> after"):
        report(page)
