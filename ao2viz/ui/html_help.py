"""All keys and commands as HTML. Escaping as in `html`."""

from collections.abc import Sequence

from ao2viz.ui.html import esc
from ao2viz.ui.inbox import Key


def help_page(keys: Sequence[Key]) -> str:
    """Every command of the palette, by what it is about; its key before it where it has one."""
    groups: dict[str, list[str]] = {}
    for key in keys:
        about, _, words = key.label.partition(": ")
        shown = f"<kbd>{esc(key.shown)}</kbd>" if key.shown else ""
        words = words or about
        item = f'<tr><td class="ao-keys">{shown}</td><td>{esc(words)}</td></tr>'
        groups.setdefault(about, []).append(item)
    tables = "".join(
        f'<section><h4>{esc(about)}</h4><table role="presentation">{"".join(items)}</table>'
        "</section>"
        for about, items in groups.items()
    )
    return (
        '<div class="ao ao-help"><p>Keys work wherever no text is being typed. Whatever has no '
        "key is in the command palette: Ctrl+K, or the list with a magnifying glass on top of the "
        f'right dock.</p><div class="ao-columns">{tables}</div></div>'
    )
