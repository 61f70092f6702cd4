"""Every format: its name, its file name, what it holds and what it needs. Light to import."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum


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
    REPLAY = "replay"
    MINARI = "minari"
    TENSORBOARD = "tensorboard"
    OPTION = "option"
    OPTION_JSON = "option-json"


class Scope(Enum):
    """How much of an agent is exported; the values are what people read."""

    AGENT = "the whole agent"
    EPISODE = "this episode"
    MOMENT = "this moment"
    OPTION = "the selected option"


@dataclass(frozen=True)
class About:
    """What people must know of a format."""

    suffix: str  # Of the file's name; empty where the format is a folder.
    holds: str  # In a few words.
    libraries: tuple[str, ...] = ()  # Of the extra `exports`, by the names they are imported with.

    @property
    def is_folder(self) -> bool:
        """Whether what is written is a folder of files, not one file."""
        return not self.suffix


ABOUT: Mapping[Format, About] = {
    Format.JSON: About(".json", "everything, for programs"),
    Format.CSV: About(".csv", "a row for each recorded step"),
    Format.PATHS_CSV: About(".csv", "a row for each option on each path of each step"),
    Format.PARQUET: About(".parquet", "a row for each recorded step, with lists", ("pyarrow",)),
    Format.MARKDOWN: About(".md", "summary, attention, settings, steps"),
    Format.LATEX: About(".tex", "the steps of an episode as a table"),
    Format.HTML: About(".html", "a page with every step of an episode"),
    Format.GRAPHML: About(".graphml", "the forest as a graph"),
    Format.GEXF: About(".gexf", "the forest as a graph, with places"),
    Format.DOT: About(".dot", "the forest as a graph, with places"),
    Format.CYTOSCAPE: About(".json", "the forest for Cytoscape"),
    Format.NODE_LINK: About(".json", "the forest for D3 and networkx"),
    Format.POLICY: About(".py", "the policy as code that needs numpy alone"),
    Format.RULES: About(".txt", "IF-THEN rules, simplified", ("sklearn",)),
    Format.SVG: About(".svg", "the forest, with the path of a step"),
    Format.PNG: About(".png", "the forest, with the path of a step"),
    Format.PATH_SVG: About(".svg", "the path of a step, as a stack"),
    Format.PATH_PNG: About(".png", "the path of a step, as a stack"),
    Format.MP4: About(".mp4", "an episode beside its paths, as a film", ("av",)),
    Format.GIF: About(".gif", "an episode beside its paths, as a film"),
    Format.REPLAY: About(".html", "an episode in three dimensions"),
    Format.MINARI: About("", "recorded episodes as a data set", ("minari", "pyarrow")),
    Format.TENSORBOARD: About("", "training and episodes as scalars", ("tensorboardX",)),
    Format.OPTION: About(".md", "one option: value, weights, their reasons, experience, uses"),
    Format.OPTION_JSON: About(".json", "one option, for programs"),
}

PURPOSES: Mapping[str, tuple[Format, ...]] = {
    "to read and to share": (Format.HTML, Format.MARKDOWN, Format.LATEX, Format.REPLAY),
    "pictures and films": (
        Format.SVG,
        Format.PNG,
        Format.PATH_SVG,
        Format.PATH_PNG,
        Format.MP4,
        Format.GIF,
    ),
    "tables and programs": (Format.CSV, Format.PATHS_CSV, Format.PARQUET, Format.JSON),
    "graphs": (Format.GRAPHML, Format.GEXF, Format.DOT, Format.CYTOSCAPE, Format.NODE_LINK),
    "the policy": (Format.POLICY, Format.RULES),
    "learning tools": (Format.MINARI, Format.TENSORBOARD),
    "one option": (Format.OPTION, Format.OPTION_JSON),
}
"""Every format once, by what people want it for."""

_OF_THE_AGENT = {*PURPOSES["graphs"], *PURPOSES["the policy"]}
_OF_ONE_EPISODE = {Format.HTML, Format.LATEX, Format.REPLAY, Format.MP4, Format.GIF}


def scopes_of(format: Format) -> tuple[Scope, ...]:
    """What a format can be about, the usual one first."""
    if format in PURPOSES["one option"]:
        return (Scope.OPTION,)
    if format in _OF_THE_AGENT:
        return (Scope.AGENT,)
    if format in _OF_ONE_EPISODE:
        return (Scope.EPISODE,)
    if format in {Format.PATH_SVG, Format.PATH_PNG}:
        return (Scope.MOMENT,)
    if format in {Format.SVG, Format.PNG}:
        return (Scope.AGENT, Scope.MOMENT)
    return (Scope.EPISODE, Scope.AGENT)
