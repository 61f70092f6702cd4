"""The tables of an experiment in Markdown, as they stand in docs/results.md."""

import re
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

from ao2viz.baselines.algorithm import Acting
from ao2viz.core.decision import DecideBy
from ao2viz.experiments.measure import Evaluation
from ao2viz.experiments.plan import Way, say_settings
from ao2viz.experiments.statistics import Summary

_MISSING = "–"
_COLUMNS: Sequence[Mapping[Way, str]] = (
    {DecideBy.VOTE: "by vote", Acting.SAMPLED: "drawn"},
    {DecideBy.PATH: "by one path", Acting.GREEDY: "greedy"},
)
"""Ways of AO2 and of a network that share a column, and how it is headed."""
_SIZES = {DecideBy: "options", Acting: "parameters"}


class Block(Enum):
    """What can be put between two marks of a page."""

    ALL = "begin"
    IN_SHORT = "in short"
    EVERY_SEED = "every seed"

    @property
    def mark(self) -> str:
        """The line before it."""
        return f"<!-- results: {self.value} -->"


END = "<!-- results: end -->"
"""The line after any block."""


@dataclass(frozen=True)
class _Pair:
    """The same agents at the same checkpoint, deciding in both ways."""

    any: Summary
    by: Mapping[Way, Summary]

    @property
    def columns(self) -> list[Summary | None]:
        """What stands in each of `_COLUMNS`."""
        return [
            next((self.by[way] for way in column if way in self.by), None) for column in _COLUMNS
        ]

    @property
    def title(self) -> str:
        settings = say_settings(self.any.settings).strip()
        changed = f", `{settings}`" if settings else ""
        return f"{self.any.env}, `{self.any.preset.value}`{changed}, {self.any.steps:,} steps"


def write_into(page: str | None, summaries: Sequence[Summary], source: str) -> str:
    """A page with its tables made anew; whatever stands outside the marks is left alone.

    Args:
        page: Markdown with at least one mark; None begins a page.
        summaries: What to tell.
        source: The name of the table's file.

    Raises:
        ValueError: If there is no mark, or one that has no end.
    """
    if page is None:
        page = f"# Results\n\n{Block.ALL.mark}\n{END}\n"
    blocks = _make_blocks(summaries, source)
    found = 0
    for block, text in blocks.items():
        # Up to the next mark of any kind, which has to be an end.
        pattern = rf"({re.escape(block.mark)}\n)(.*?)(<!-- results: (?:[a-z ]+) -->|\Z)"
        for match in re.findall(pattern, page, re.DOTALL):
            if match[2] != END:
                raise ValueError(f"Expected {END} after {block.mark}, but there is none.")
        page, count = re.subn(
            pattern,
            lambda match, text=text: f"{match[1]}\n{text}\n{match[3]}",
            page,
            flags=re.DOTALL,
        )
        found += count
    if not found:
        marks = ", ".join(block.mark for block in Block)
        raise ValueError(
            f"Expected a line that says where the tables go, one of {marks}, and {END} where they "
            f"end."
        )
    return page


def _make_blocks(summaries: Sequence[Summary], source: str) -> dict[Block, str]:
    pairs = _pair(summaries)
    lead = _describe(summaries, source)
    in_short, every_seed = _in_short(pairs), _every_seed(pairs)
    return {
        Block.ALL: f"{lead}\n## In short\n\n{in_short}\n## Every seed\n\n{every_seed}",
        Block.IN_SHORT: f"{lead}\n{in_short}",
        Block.EVERY_SEED: every_seed,
    }


def _pair(summaries: Sequence[Summary]) -> list[_Pair]:
    grouped: dict[tuple[str, str, str, int], dict[Way, Summary]] = defaultdict(dict)
    for one in summaries:
        grouped[one.env, one.preset.value, one.settings, one.steps][one.decide_by] = one
    return [_Pair(next(iter(by.values())), by) for by in grouped.values()]


def _describe(summaries: Sequence[Summary], source: str) -> str:
    """Where the figures come from and what they mean."""
    evaluations = [evaluation for one in summaries for evaluation in one.evaluations]
    episodes = sorted({len(evaluation.returns) for evaluation in evaluations})
    made_by = sorted({str(evaluation.made_by) for evaluation in evaluations})
    is_drawn = any(one.decide_by is Acting.SAMPLED for one in summaries)
    played = "episodes" if is_drawn else "greedy episodes"
    return (
        f"Made by `ao2viz results {source} --markdown`, from runs of {' and '.join(made_by)}; "
        f"{' or '.join(f'{n:,}' for n in episodes)} {played} each. Mean over seeds (least … "
        f"greatest); IQM: interquartile mean over seeds with its 95 % bootstrap interval; stack: "
        f"options from the root to the most similar one, mean by vote, by one path (≤ the most).\n"
    )


def _in_short(pairs: Sequence[_Pair]) -> str:
    """One line for each checkpoint of each group of seeds."""
    rows = []
    for pair in pairs:
        one = pair.any
        settings = say_settings(one.settings).strip()
        rows.append(
            [
                one.env,
                f"`{one.preset.value}`",
                f"`{settings}`" if settings else "",
                f"{one.steps:,}",
                f"{len(one.evaluations)}",
                *(_say(_range, each) for each in pair.columns),
                *(_say(_iqm, each) for each in pair.columns),
                f"{one.options:,.0f}",
                _stack(pair.columns),
                f"{one.cpu_s:,.1f}",
            ]
        )
    *ways, size = _headings(pairs)
    headings = [
        "task", "preset", "settings", "steps", "seeds", *ways, *(f"IQM {way}" for way in ways),
        size, "stack", "CPU s",
    ]  # fmt: skip
    return to_table(headings, rows)


def _every_seed(pairs: Sequence[_Pair]) -> str:
    """A table for each group of seeds and each checkpoint."""
    return "\n".join(f"### {pair.title}\n\n{_seeds(pair)}" for pair in pairs)


def _seeds(pair: _Pair) -> str:
    rows = []
    for one in pair.any.evaluations:
        found = [_of_seed(each, one.run.seed) for each in pair.columns]
        rows.append(
            [
                f"{one.run.seed}",
                *map(_mean, found),
                f"{one.options:,}",
                _stack(found),
                f"{one.cpu_s:,.1f}",
            ]
        )
    rows.append(
        [
            "mean",
            *(_say(lambda one: number(one.means.mean()), each) for each in pair.columns),
            f"{pair.any.options:,.0f}",
            _stack(pair.columns),
            f"{pair.any.cpu_s:,.1f}",
        ]
    )
    return to_table(["seed", *_headings([pair]), "stack", "CPU s"], rows)


def _headings(pairs: Sequence[_Pair]) -> list[str]:
    """What the returns in each of `_COLUMNS` are, and what the size counts."""
    kinds = {type(way) for pair in pairs for way in pair.any.evaluations[0].run.ways}
    named = [[words for way, words in column.items() if type(way) in kinds] for column in _COLUMNS]
    named.append([words for kind, words in _SIZES.items() if kind in kinds])
    return [" or ".join(words) for words in named]


def _of_seed(one: Summary | None, seed: int) -> Evaluation | None:
    found = () if one is None else one.evaluations
    return next((each for each in found if each.run.seed == seed), None)


def _stack(columns: Sequence[Evaluation | Summary | None]) -> str:
    """Mean length of the decision stack in each way of deciding, and the most of any."""
    found = [one for one in columns if one is not None and one.stack_most]
    if not found:  # A network has none.
        return _MISSING
    means = ", ".join(f"{one.stack_mean:.1f}" for one in found)
    return f"{means} (≤ {max(one.stack_most for one in found)})"


def number(value: float) -> str:
    """A return with one decimal and a real minus."""
    return f"{value:,.1f}".replace("-", "−")


def _mean(evaluation: Evaluation | None) -> str:
    if evaluation is None:
        return _MISSING
    error = evaluation.standard_error
    return number(evaluation.mean_return) + ("" if error is None else f" ± {error:.1f}")


def _range(one: Summary) -> str:
    means = one.means
    return f"{number(means.mean())} ({number(means.min())} … {number(means.max())})"


def _iqm(one: Summary) -> str:
    if one.interval is None:
        return number(one.iqm)
    low, high = one.interval
    return f"{number(one.iqm)} [{number(low)}, {number(high)}]"


def _say(how: Callable[[Summary], str], one: Summary | None) -> str:
    return _MISSING if one is None else how(one)


def to_table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table, less the columns that are empty in every row."""
    kept = [i for i in range(len(headings)) if any(row[i] for row in rows)]
    head, *body = (f"| {' | '.join(row[i] for i in kept)} |\n" for row in (headings, *rows))
    return "".join([head, f"|{'---|' * len(kept)}\n", *body])
