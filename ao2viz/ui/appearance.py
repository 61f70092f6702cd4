"""How one browser wants its page to look, and what it remembers of that; pure."""

import json
from dataclasses import dataclass, replace
from typing import assert_never

from ao2viz.figures.palette import Theme

KEY = "ao2viz"
"""Under this name a browser keeps what was chosen in it."""


@dataclass(frozen=True)
class Appearance:
    """What was chosen, and what the system of the browser prefers where nothing was."""

    theme: Theme | None = None  # None: as the system.
    is_still: bool | None = None  # Nothing glides; None: as the system.
    hint_is_gone: bool = True  # Until the browser says that it was never dismissed.
    system_is_light: bool = False
    system_is_still: bool = False
    is_known: bool = False  # The browser has told what it remembers.

    @property
    def shown_theme(self) -> Theme:
        """The theme to show."""
        if self.theme is not None:
            return self.theme
        return Theme.LIGHT if self.system_is_light else Theme.DARK

    @property
    def rests(self) -> bool:
        """Whether nothing is to glide."""
        return self.system_is_still if self.is_still is None else self.is_still


@dataclass(frozen=True)
class Recall:
    """What a browser remembers of earlier visits."""

    appearance: Appearance


@dataclass(frozen=True)
class ChooseTheme:
    """Shows the page in a theme; None: as the system prefers."""

    theme: Theme | None


@dataclass(frozen=True)
class SwitchTheme:
    """Shows the page in the other theme."""


@dataclass(frozen=True)
class ChooseMotion:
    """Lets nothing glide, or lets it; None: as the system prefers."""

    is_still: bool | None


@dataclass(frozen=True)
class DismissHint:
    """Never shows the hint of the first visit again."""


AppearanceCommand = Recall | ChooseTheme | SwitchTheme | ChooseMotion | DismissHint


@dataclass(frozen=True)
class Remember:
    """Asks the browser to keep this for its next visit."""

    text: str


def change(appearance: Appearance, command: AppearanceCommand) -> Appearance:
    """The appearance after a command."""
    match command:
        case Recall(remembered):
            return remembered
        case ChooseTheme(theme):
            return replace(appearance, theme=theme)
        case SwitchTheme():
            is_dark = appearance.shown_theme is Theme.DARK
            return replace(appearance, theme=Theme.LIGHT if is_dark else Theme.DARK)
        case ChooseMotion(is_still):
            return replace(appearance, is_still=is_still)
        case DismissHint():
            return replace(appearance, hint_is_gone=True)
        case _:
            assert_never(command)


def to_text(appearance: Appearance) -> str:
    """What a browser is to keep."""
    theme = appearance.theme
    return json.dumps(
        {
            "theme": None if theme is None else theme.value,
            "is_still": appearance.is_still,
            "hint_is_gone": appearance.hint_is_gone,
        }
    )


def from_text(told: str | None) -> Appearance:
    """What a browser told of itself; whatever makes no sense is as on a first visit.

    Args:
        told: JSON of an object: `light` and `still`, whether its system prefers that, and
            `chosen`, the text of `to_text` that it kept, or null.
    """
    system = _read(told)
    chosen = _read(system.get("chosen"))
    themes = {theme.value: theme for theme in Theme}
    is_still = chosen.get("is_still")
    return Appearance(
        theme=themes.get(str(chosen.get("theme"))),
        is_still=is_still if isinstance(is_still, bool) else None,
        hint_is_gone=chosen.get("hint_is_gone") is True,
        system_is_light=system.get("light") is True,
        system_is_still=system.get("still") is True,
        is_known=True,
    )


def _read(text: object) -> dict[str, object]:
    try:
        found = json.loads(text) if isinstance(text, str) else {}
    except (json.JSONDecodeError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
