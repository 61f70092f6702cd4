"""Plain JSON values out of files, each checked before it is believed."""

import json
from collections.abc import Callable
from typing import Any

from ao2viz.store.errors import AgentFileError, quote

MAX_TEXT = 200
MAX_INT = 2**62

Json = dict[str, Any]


class Fields:
    """One JSON object; gives its fields checked."""

    def __init__(self, fields: Any, where: str) -> None:
        if not isinstance(fields, dict):
            raise AgentFileError(f"Expected {where} to be an object, but it is {quote(fields)}.")
        self._fields, self._where = fields, where

    def raw(self, name: str) -> Any:
        """A field as it is; all of these raise an AgentFileError that names it."""
        if name not in self._fields:
            raise AgentFileError(f"Expected {name!r} in the {self._where}, but there is none.")
        return self._fields[name]

    def _take(self, name: str, expected: str, accept: Callable[[Any], bool]) -> Any:
        value = self.raw(name)
        if not accept(value):
            raise AgentFileError(
                f"Expected {name!r} in the {self._where} to be {expected}, but it is "
                f"{quote(value)}."
            )
        return value

    def whole(self, name: str, least: int = 0, most: int = MAX_INT) -> int:
        """A whole number in a range."""
        return self._take(
            name,
            f"a whole number of at least {least}",
            lambda value: type(value) is int and least <= value <= most,
        )

    def number(self, name: str) -> float:
        """A finite number."""
        return float(
            self._take(
                name,
                "a finite number",
                lambda value: type(value) in (int, float) and abs(value) < 1e300,
            )
        )

    def truth(self, name: str) -> bool:
        """True or false."""
        return self._take(name, "true or false", lambda value: isinstance(value, bool))

    def text(self, name: str) -> str:
        """A short printable text."""
        return self.check_text(name, self.raw(name))

    def check_text(self, name: str, value: Any) -> str:
        """The value, which belongs to the field `name`, as a short printable text."""
        if not (isinstance(value, str) and len(value) <= MAX_TEXT and value.isprintable()):
            raise AgentFileError(
                f"Expected {quote(name)} in the {self._where} to be at most {MAX_TEXT} printable "
                f"characters, but it is {quote(value)}."
            )
        return value

    def one_of(self, name: str, choices: list[str]) -> str:
        """One of a few words."""
        return self._take(name, " or ".join(choices), lambda value: value in choices)

    def mapping(self, name: str) -> Json:
        """An object."""
        return self._take(name, "an object", lambda value: isinstance(value, dict))

    def items(self, name: str, most: int) -> list[Any]:
        """A list that is not too long."""
        return self._take(
            name,
            f"a list of at most {most:,}",
            lambda value: isinstance(value, list) and len(value) <= most,
        )


def parse_object(content: bytes) -> Json:
    """A manifest as plain data.

    Raises:
        AgentFileError: If it is no JSON object.
    """

    def refuse(constant: str) -> None:
        raise ValueError(f"{constant} is not JSON")

    try:
        manifest = json.loads(content.decode(), parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        raise AgentFileError(f"Expected a manifest in JSON, but: {quote(error)}.") from error
    if not isinstance(manifest, dict):
        raise AgentFileError(f"Expected the manifest to be an object, not {quote(manifest)}.")
    return manifest
