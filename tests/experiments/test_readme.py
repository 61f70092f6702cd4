"""The figures that the README quotes are those of the committed table of results."""

import re
from pathlib import Path

from ao2viz.core.decision import DecideBy
from ao2viz.envs.catalogue import CATALOGUE
from ao2viz.experiments.report import number
from ao2viz.experiments.statistics import summarise
from ao2viz.experiments.table import read

ROOT = Path(__file__).resolve().parents[2]
ROW = re.compile(r"\| (\S+-v\d) \| ([\d,]+) \| ([\d,]+) \| (\S+) \| (\S*) ?\|")


def test_the_readme_quotes_the_results():
    summaries = summarise(read(ROOT / "docs/results.parquet"))
    rows = ROW.findall((ROOT / "README.md").read_text())
    assert len(rows) == 5
    for env, steps, options, told, papers in rows:
        (found,) = (
            one
            for one in summaries
            if (one.env, one.preset.value, one.settings) == (env, "anticipating", "{}")
            and f"{one.steps:,}" == steps
            and one.decide_by is DecideBy.PATH
        )
        assert (f"{found.options:,.0f}", number(found.means.mean())) == (options, told)
        assert len(found.evaluations) == 10
        score = CATALOGUE[env].paper_score
        assert papers == ("" if score is None else number(score))
