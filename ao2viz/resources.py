"""Where the files that ship with ao2viz are, in a checkout and in an installed wheel alike."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def _shipped(name: str) -> Path:
    installed = _PACKAGE / "_data" / name
    return installed if installed.is_dir() else _PACKAGE.parent / name


def saved_schemas() -> Path:
    """The folder of the trained agents that ship with the app."""
    return _shipped("saved_schemas")


def static() -> Path:
    """The folder of what browsers load from us."""
    return _shipped("static")


def learner_curves() -> Path:
    """The learning curves of the paper's comparison, as `ao2viz paper` wrote them."""
    return _shipped("docs/paper") / "curves.json"
