"""Who writes which format. Heavy to import: it brings plotly, networkx and viser."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import IO

from ao2viz.exports.content import Content
from ao2viz.exports.documents import write_json
from ao2viz.exports.films import write_gif, write_mp4
from ao2viz.exports.formats import Format
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
from ao2viz.exports.options import write_option, write_option_json
from ao2viz.exports.pages import write_latex, write_markdown
from ao2viz.exports.policy import write_policy
from ao2viz.exports.records import fill_minari, fill_tensorboard
from ao2viz.exports.replay_3d import write_replay
from ao2viz.exports.report import write_report
from ao2viz.exports.rules import write_rules
from ao2viz.exports.tables import write_parquet, write_paths_csv, write_steps_csv

FILES: Mapping[Format, Callable[[Content, IO[bytes]], None]] = {
    Format.JSON: write_json,
    Format.CSV: write_steps_csv,
    Format.PATHS_CSV: write_paths_csv,
    Format.PARQUET: write_parquet,
    Format.MARKDOWN: write_markdown,
    Format.LATEX: write_latex,
    Format.HTML: write_report,
    Format.GRAPHML: write_graphml,
    Format.GEXF: write_gexf,
    Format.DOT: write_dot,
    Format.CYTOSCAPE: write_cytoscape,
    Format.NODE_LINK: write_node_link,
    Format.POLICY: write_policy,
    Format.RULES: write_rules,
    Format.SVG: write_forest_svg,
    Format.PNG: write_forest_png,
    Format.PATH_SVG: write_path_svg,
    Format.PATH_PNG: write_path_png,
    Format.MP4: write_mp4,
    Format.GIF: write_gif,
    Format.REPLAY: write_replay,
    Format.OPTION: write_option,
    Format.OPTION_JSON: write_option_json,
}
"""Formats that are one file; the stream begins empty."""

FOLDERS: Mapping[Format, Callable[[Content, Path], None]] = {
    Format.MINARI: fill_minari,
    Format.TENSORBOARD: fill_tensorboard,
}
"""Formats that are a folder, which is there and empty."""
