"""Every format: what it holds, its file name, what it needs, and who writes it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import IO

from ao2viz.exports.content import Content
from ao2viz.exports.documents import write_json
from ao2viz.exports.films import write_gif, write_mp4
from ao2viz.exports.graphs import (
    write_cytoscape,
    write_dot,
    write_gexf,
    write_graphml,
    write_node_link,
)
from ao2viz.exports.images import (
    write_forest_png,
    write_forest_svg,
    write_path_png,
    write_path_svg,
)
from ao2viz.exports.pages import write_latex, write_markdown
from ao2viz.exports.policy import write_policy
from ao2viz.exports.records import fill_minari, fill_tensorboard
from ao2viz.exports.report import write_report
from ao2viz.exports.rules import write_rules
from ao2viz.exports.tables import write_parquet, write_paths_csv, write_steps_csv


class Format(Enum):
    """What an agent can be exported as."""

    JSON = "json"
    CSV = "csv"
    PATHS_CSV = "paths-csv"
    PARQUET = "parquet"
    MARKDOWN = "markdown"
    LATEX = "latex"
    HTML = "html"
    GRAPHML = "graphml"
    GEXF = "gexf"
    DOT = "dot"
    CYTOSCAPE = "cytoscape"
    NODE_LINK = "node-link"
    POLICY = "policy"
    RULES = "rules"
    SVG = "svg"
    PNG = "png"
    PATH_SVG = "path-svg"
    PATH_PNG = "path-png"
    MP4 = "mp4"
    GIF = "gif"
    MINARI = "minari"
    TENSORBOARD = "tensorboard"


@dataclass(frozen=True)
class FileExporter:
    """A format that is one file."""

    suffix: str  # Of the file's name.
    holds: str  # In a few words.
    write: Callable[[Content, IO[bytes]], None]
    libraries: tuple[str, ...] = ()  # Of the extra `exports`, by the names they are imported with.


@dataclass(frozen=True)
class FolderExporter:
    """A format that is a folder of files."""

    holds: str
    fill: Callable[[Content, Path], None]  # The folder is there and empty.
    libraries: tuple[str, ...] = ()


Exporter = FileExporter | FolderExporter

EXPORTERS: Mapping[Format, Exporter] = {
    Format.JSON: FileExporter(".json", "everything, for programs", write_json),
    Format.CSV: FileExporter(".csv", "a row for each recorded step", write_steps_csv),
    Format.PATHS_CSV: FileExporter(
        ".csv", "a row for each option on each path of each step", write_paths_csv
    ),
    Format.PARQUET: FileExporter(
        ".parquet", "a row for each recorded step, paths as lists", write_parquet, ("pyarrow",)
    ),
    Format.MARKDOWN: FileExporter(".md", "summary, attention, settings, steps", write_markdown),
    Format.LATEX: FileExporter(".tex", "the steps of an episode as a table", write_latex),
    Format.HTML: FileExporter(".html", "a page with every step of an episode", write_report),
    Format.GRAPHML: FileExporter(".graphml", "the forest as a graph", write_graphml),
    Format.GEXF: FileExporter(".gexf", "the forest as a graph, with places", write_gexf),
    Format.DOT: FileExporter(".dot", "the forest as a graph, with places", write_dot),
    Format.CYTOSCAPE: FileExporter(".json", "the forest for Cytoscape", write_cytoscape),
    Format.NODE_LINK: FileExporter(".json", "the forest for D3 and networkx", write_node_link),
    Format.POLICY: FileExporter(".py", "the policy as code that needs numpy alone", write_policy),
    Format.RULES: FileExporter(".txt", "IF-THEN rules, simplified", write_rules, ("sklearn",)),
    Format.SVG: FileExporter(".svg", "the forest, with the path of a step", write_forest_svg),
    Format.PNG: FileExporter(".png", "the forest, with the path of a step", write_forest_png),
    Format.PATH_SVG: FileExporter(".svg", "the path of a step, as a stack", write_path_svg),
    Format.PATH_PNG: FileExporter(".png", "the path of a step, as a stack", write_path_png),
    Format.MP4: FileExporter(".mp4", "an episode beside its paths, as a film", write_mp4, ("av",)),
    Format.GIF: FileExporter(".gif", "an episode beside its paths, as a film", write_gif),
    Format.MINARI: FolderExporter(
        "recorded episodes as a data set", fill_minari, ("minari", "pyarrow")
    ),
    Format.TENSORBOARD: FolderExporter(
        "training and episodes as scalars", fill_tensorboard, ("tensorboardX",)
    ),
}


def suffix_of(format: Format) -> str:
    """How the names of such files end; empty for a folder."""
    exporter = EXPORTERS[format]
    return exporter.suffix if isinstance(exporter, FileExporter) else ""
