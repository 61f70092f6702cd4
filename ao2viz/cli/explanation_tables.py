"""The numbers of an explanation as tables for the terminal; text from files is never markup."""

from rich.table import Table
from rich.text import Text

from ao2viz.cli.console import show_table
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.flips import Flip, Flips
from ao2viz.explain.telling import Told
from ao2viz.explain.why import Why
from ao2viz.explain.words import amount, number, percent, signed


def show_tables(answer: Told, spec: TaskSpec) -> None:
    """Prints the tables that belong to an answer, if any do."""
    if isinstance(answer, Why) and answer.voters:
        show_table(_table_path(answer))
        show_table(_table_actions(answer, spec))
    if isinstance(answer, Flips):
        show_table(_table_flips(answer, spec))


def _make_table(title: str, first: str, headings: list[str]) -> Table:
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    table.add_column(Text(first), overflow="fold")
    for heading in headings:
        table.add_column(Text(heading), justify="right", overflow="fold")
    return table


def _table_path(why: Why) -> Table:
    """The stack, root first: each option with its distance and what it is made of."""
    path = why.voters[0].path
    names = [gap.feature for gap in path[-1].gaps]
    table = _make_table("Path", "option", ["distance", *(f"{name}" for name in names)])
    for depth, step in enumerate(path):
        shares = {gap.feature: f"{gap.known} ({_share(gap.share)})" for gap in step.gaps}
        cells = [shares.get(name, "") for name in names]
        table.add_row(
            Text(f"{'  ' * depth}{step.option}"), number(step.distance), *map(Text, cells)
        )
    return table


def _share(share: float) -> str:
    return "?" if share != share else percent(share)  # noqa: PLR0124  NaN: not known any more.


def _table_actions(why: Why, spec: TaskSpec) -> Table:
    headings = ["expected", "own weight", "neighbours"]
    if why.weighings[0].offsets:
        headings += [feature.name for feature in spec.features]
    table = _make_table("Actions", "action", headings)
    for part in sorted(why.weighings, key=lambda part: -part.total):
        mark = " ←" if part.action == why.decision.action else ""
        table.add_row(
            Text(spec.action_names[part.action] + mark),
            number(part.total, 5),
            number(part.own, 5),
            signed(part.evened),
            *(signed(offset) for offset in part.offsets),
        )
    return table


def _table_flips(flips: Flips, spec: TaskSpec) -> Table:
    table = _make_table("Flips", "feature", ["less", "then", "more", "then", "distance"])
    for both in flips.features:
        feature = spec.features[both.feature]
        nearest = [flip.distance for flip in (both.less, both.more) if flip is not None]
        table.add_row(
            Text(feature.name),
            *_flip_cells(both.less, spec),
            *_flip_cells(both.more, spec),
            number(min(nearest)) if nearest else "",
        )
    return table


def _flip_cells(flip: Flip | None, spec: TaskSpec) -> tuple[Text, Text]:
    if flip is None:
        return Text(""), Text("")
    shown = amount(flip.border, spec.features[flip.feature])
    return Text(shown), Text(spec.action_names[flip.action])
