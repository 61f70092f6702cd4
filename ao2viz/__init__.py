"""Watch a reinforcement learning agent think: AO2, an agent without a neural network."""

from importlib import metadata

from ao2viz.agent import AO2
from ao2viz.core.config import Preset
from ao2viz.core.decision import DecideBy, Decision
from ao2viz.core.forest import ForestView
from ao2viz.core.growth import GrowthEvent, GrowthKind
from ao2viz.exports.export import export
from ao2viz.exports.formats import Format
from ao2viz.recording.episode import Episode

try:
    __version__ = metadata.version("ao2viz")
except metadata.PackageNotFoundError:  # Run from a folder, without installing.
    __version__ = "unknown"

__all__ = [
    "AO2",
    "DecideBy",
    "Decision",
    "Episode",
    "ForestView",
    "Format",
    "GrowthEvent",
    "GrowthKind",
    "Preset",
    "__version__",
    "export",
]
