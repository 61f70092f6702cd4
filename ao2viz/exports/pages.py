"""Summaries for people who write: Markdown for notes and pull requests, LaTeX for papers."""

from collections.abc import Iterator, Sequence
from typing import IO

from ao2viz.core.config import config_to_dict
from ao2viz.explain.abstract import summarise
from ao2viz.explain.agreement import tell_faithfulness
from ao2viz.explain.words import number, say_outcome
from ao2viz.exports.content import Content, Step
from ao2viz.exports.escaping import to_latex, to_markdown


def summary_rows(content: Content) -> list[tuple[str, str]]:
    """What an agent is, as pairs of a word and a value; plain text."""
    saved = content.saved
    return summarise(
        content.spec, saved.config, saved.seed, saved.n_steps, content.view, saved.history
    )


def write_markdown(content: Content, stream: IO[bytes]) -> None:
    """The agent, its attention, its settings, and every step of the chosen episodes."""
    stream.write("\n".join(_markdown(content)).encode() + b"\n")


def write_latex(content: Content, stream: IO[bytes]) -> None:
    r"""The decisions of the chosen episode as a longtable, for `\input` with booktabs."""
    number_, episode = content.chosen
    spec = content.spec
    heads = ["Step", *(f.name for f in spec.features), "Action", "Path", "Margin", "Reward"]
    columns = "r" * (len(spec.features) + 1) + "llrr"
    lines = [
        r"% \usepackage{booktabs,longtable,textcomp}",
        rf"\begin{{longtable}}{{{columns}}}",
        rf"\caption{{{to_latex(spec.title)}: episode {number_}, seed {episode.seed}, return "
        rf"{to_latex(number(episode.total_reward, 4))}. "
        rf"{to_latex(tell_faithfulness(content.faithfulness))}}}\\",
        r"\toprule",
        " & ".join(to_latex(head) for head in heads) + r" \\",
        r"\midrule",
        r"\endhead",
        r"\bottomrule",
        r"\endfoot",
    ]
    for step in content.steps(content.chosen):
        cells = [
            str(step.number),
            *(
                number(value * f.scale) + (f.unit if f.unit.startswith("°") else "")
                for value, f in zip(step.decision.observation.tolist(), spec.features, strict=True)
            ),
            step.said.headline,
            _path(step),
            number(step.decision.margin),
            number(step.reward),
        ]
        lines.append(" & ".join(to_latex(cell) for cell in cells) + r" \\")
        content.progress((step.number + 1) / len(episode))
    lines.append(r"\end{longtable}")
    stream.write("\n".join(lines).encode() + b"\n")


def _markdown(content: Content) -> Iterator[str]:
    spec, view = content.spec, content.view
    yield f"# {to_markdown(spec.title)}"
    yield ""
    yield from table(["", ""], summary_rows(content))
    yield ""
    yield "## Attention"
    yield ""
    rows = [
        (f.name, f.unit, number(float(w)))
        for f, w in zip(spec.features, view.attention, strict=True)
    ]
    yield from table(["feature", "shown in", "weight of a unit of the environment"], rows)
    yield ""
    yield "## Settings"
    yield ""
    settings = config_to_dict(content.saved.config)
    yield from table(["setting", "value"], [(n, str(v)) for n, v in settings.items()])
    yield ""
    yield to_markdown(tell_faithfulness(content.faithfulness))
    done, total = 0, sum(len(episode) for _, episode in content.episodes)
    for numbered in content.episodes:
        episode = numbered.episode
        yield ""
        yield f"## Episode {numbered.number}"
        yield ""
        yield f"Seed {episode.seed}: {say_outcome(episode)}."
        yield ""
        yield from _table_head(["step", "action", "margin", "path", "reason"])
        for step in content.steps(numbered):
            yield _row(
                [
                    str(step.number),
                    step.said.headline,
                    number(step.decision.margin),
                    _path(step),
                    step.said.reason,
                ]
            )
            done += 1
            content.progress(done / total)


def _path(step: Step) -> str:
    return " → ".join(str(option) for option in step.decision.path.tolist())


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """The lines of a table; its cells are escaped."""
    yield from _table_head(heads)
    for row in rows:
        yield _row(row)


def _table_head(heads: Sequence[str]) -> Iterator[str]:
    yield _row(heads)
    yield f"|{'---|' * len(heads)}"


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(to_markdown(cell) for cell in cells)} |"
