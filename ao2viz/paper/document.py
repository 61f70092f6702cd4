"""A report as plain values, and the two things it becomes: Markdown, and one page of HTML."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import metadata

import jinja2
from markupsafe import Markup

from ao2viz.experiments.report import to_table
from ao2viz.exports.report import page_policy
from ao2viz.figures.drawing import LIGHT, Drawing, to_svg
from ao2viz.resources import static


@dataclass(frozen=True)
class Paragraph:
    """Text; `code` is set in a fixed width, line by line."""

    text: str
    is_code: bool = False


@dataclass(frozen=True)
class Table:
    """Rows of texts under headings; columns that are empty in every row are left out."""

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True, eq=False)
class Picture:
    """A chart, and the name of its file beside the Markdown."""

    name: str
    caption: str
    drawing: Drawing  # Its ink is `currentColor`.


Part = Paragraph | Table | Picture


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it."""

    title: str
    parts: Sequence[Part]


def to_markdown(title: str, sections: Sequence[Section]) -> str:
    """The report as Markdown; pictures are files beside it, see `pictures_of`."""
    lines = [f"# {title}", ""]
    for section in sections:
        lines += [f"## {section.title}", ""]
        for part in section.parts:
            match part:
                case Paragraph():
                    lines.append(f"```sh\n{part.text}\n```" if part.is_code else part.text)
                case Table():
                    lines.append(to_table(part.headings, part.rows).rstrip())
                case Picture():
                    lines.append(f"![{part.caption}]({part.name}.svg)\n\n*{part.caption}*")
            lines.append("")
    return "\n".join(lines)


def pictures_of(sections: Sequence[Section]) -> Mapping[str, str]:
    """Each picture's file name and its SVG, dark on white."""
    return {
        f"{picture.name}.svg": to_svg(_on_white(picture.drawing)).replace("currentColor", LIGHT.ink)
        for picture in _pictures(sections)
    }


def to_page(title: str, sections: Sequence[Section]) -> str:
    """The report as one page that loads nothing; every text is escaped by the template."""
    folder = static()
    css = (folder / "report" / "report.css").read_text("utf-8")
    template = (folder / "paper" / "paper.html.jinja").read_text("utf-8")
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    return environment.from_string(template).render(
        policy=page_policy(css),
        css=Markup(css),
        title=title,
        sections=[
            (section.title, [_for_page(part) for part in section.parts]) for section in sections
        ],
        version=metadata.version("ao2viz"),
    )


def _for_page(part: Part) -> dict[str, object]:
    match part:
        case Paragraph():
            return {"kind": "code" if part.is_code else "text", "text": part.text}
        case Table():
            kept = [i for i in range(len(part.headings)) if any(row[i] for row in part.rows)]
            return {
                "kind": "table",
                "headings": [part.headings[i] for i in kept],
                "rows": [[row[i] for i in kept] for row in part.rows],
            }
        case Picture():
            svg = Markup(to_svg(part.drawing, is_inline=True))  # Its texts are escaped already.
            return {"kind": "picture", "caption": part.caption, "svg": svg}


def _pictures(sections: Sequence[Section]) -> Iterator[Picture]:
    for section in sections:
        for part in section.parts:
            if isinstance(part, Picture):
                yield part


def _on_white(drawing: Drawing) -> Drawing:
    return replace(drawing, paper=LIGHT.paper)
