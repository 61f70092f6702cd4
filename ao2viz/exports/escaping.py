"""Names and sentences as harmless text in every format: files and strangers choose names."""

import html
import re
from dataclasses import replace

from ao2viz.envs.task import TaskSpec

# A table program takes a cell that begins so for a formula. Source: OWASP, "CSV Injection".
_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\uff1d", "\uff0b", "\uff0d", "\uff20")

_MARKDOWN = re.compile(r"([\\`*_\[\]<>|#~&!$@])")
_LATEX = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\ensuremath{<}",
    ">": r"\ensuremath{>}",
    "|": r"\ensuremath{|}",
    '"': "''",
    "`": r"\textasciigrave{}",
    "−": r"\ensuremath{-}",
    "∞": r"\ensuremath{\infty}",
    "×": r"\ensuremath{\times}",
    "→": r"\ensuremath{\rightarrow}",
    "°": r"\textdegree{}",
    "·": r"\textperiodcentered{}",
    "…": r"\ldots{}",
}


def printable_names(spec: TaskSpec) -> TaskSpec:
    """The task with names in which every character can be printed, as those in files are.

    A name that was made in Python may hold any: those that break or turn round lines, or that XML
    and UTF-8 do not have, become spaces.
    """
    features = (replace(f, name=_printable(f.name), unit=_printable(f.unit)) for f in spec.features)
    return replace(
        spec,
        title=_printable(spec.title),
        features=tuple(features),
        action_names=tuple(_printable(name) for name in spec.action_names),
    )


def _printable(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text)


def one_line(text: object) -> str:
    """Text without line breaks and control characters, which no format needs in a name."""
    return _printable(" ".join(str(text).split()))


def to_html(text: object) -> str:
    """Text that can stand anywhere in HTML and SVG, attributes included."""
    return html.escape(one_line(text), quote=True)


def to_cell(text: object) -> str:
    """Text for a cell of a CSV file that no table program takes for a formula."""
    line = one_line(text)
    return f"'{line}" if line.startswith(_FORMULA) else line


def to_markdown(text: object) -> str:
    """Text within a line of Markdown: no markup, no table cell's end, no address to follow."""
    escaped = _MARKDOWN.sub(r"\\\1", one_line(text))
    escaped = escaped.replace("://", r"\://")
    return re.sub(r"(?i)\bwww\.", lambda found: f"{found[0][:-1]}\\.", escaped)


def to_latex(text: object) -> str:
    """Text for LaTeX, with the signs that our sentences use in every engine's reach."""
    return "".join(_LATEX.get(c, c) for c in one_line(text))


def to_dot(text: object) -> str:
    """A quoted string of Graphviz's DOT; a backslash would begin one of its own escapes."""
    line = one_line(text).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{line}"'
