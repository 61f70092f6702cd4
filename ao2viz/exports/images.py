"""The forest and a path as SVG and PNG, drawn here: no browser is needed."""

from typing import IO

from ao2viz.core.decision import Decision
from ao2viz.explain.agreement import tell_faithfulness
from ao2viz.exports.content import Content
from ao2viz.figures.drawing import Drawing, to_svg
from ao2viz.figures.pictures import draw_forest, draw_path
from ao2viz.figures.raster import write_png


def write_forest_svg(content: Content, stream: IO[bytes]) -> None:
    """The forest as vectors; with the path of a step if one is chosen."""
    stream.write(to_svg(_forest(content)).encode())


def write_forest_png(content: Content, stream: IO[bytes]) -> None:
    """The forest in pixels; with the path of a step if one is chosen."""
    write_png(_forest(content), stream)


def write_path_svg(content: Content, stream: IO[bytes]) -> None:
    """The path of a step as vectors."""
    stream.write(to_svg(_path(content)).encode())


def write_path_png(content: Content, stream: IO[bytes]) -> None:
    """The path of a step in pixels."""
    write_png(_path(content), stream)


def _forest(content: Content) -> Drawing:
    decision = None if content.step is None else _decision(content, content.step)
    note = "" if decision is None else tell_faithfulness(content.faithfulness)
    return draw_forest(content.view, content.spec, decision, note=note)


def _path(content: Content) -> Drawing:
    decision = _decision(content, content.step or 0)
    note = tell_faithfulness(content.faithfulness)
    return draw_path(decision, content.spec, content.view, note=note)


def _decision(content: Content, step: int) -> Decision:
    return content.chosen.episode.decisions[step]
