"""Watch a reinforcement learning agent think: AO2, an agent without a neural network."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ao2viz.agent import AO2
    from ao2viz.core.config import Preset
    from ao2viz.core.decision import DecideBy, Decision
    from ao2viz.core.forest import ForestView
    from ao2viz.core.growth import GrowthEvent, GrowthKind
    from ao2viz.exports.export import export
    from ao2viz.exports.formats import Format
    from ao2viz.recording.episode import Episode

    __version__: str

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

_HOMES = {
    "AO2": "ao2viz.agent",
    "DecideBy": "ao2viz.core.decision",
    "Decision": "ao2viz.core.decision",
    "Episode": "ao2viz.recording.episode",
    "ForestView": "ao2viz.core.forest",
    "Format": "ao2viz.exports.formats",
    "GrowthEvent": "ao2viz.core.growth",
    "GrowthKind": "ao2viz.core.growth",
    "Preset": "ao2viz.core.config",
    "export": "ao2viz.exports.export",
}


def __getattr__(name: str) -> Any:
    # Imported when first asked for: every import of the package comes through here, also that of
    # the command line, which can answer Ctrl-C only once it has begun itself.
    if name == "__version__":
        value = _find_version()
    elif name in _HOMES:
        value = getattr(import_module(_HOMES[name]), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def _find_version() -> str:
    from importlib import metadata  # noqa: PLC0415 -- slow, and rarely asked for.

    try:
        return metadata.version("ao2viz")
    except metadata.PackageNotFoundError:  # Run from a folder, without installing.
        return "unknown"
