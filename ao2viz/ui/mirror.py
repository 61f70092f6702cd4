"""Shows a value in a control without taking back what a person has just put there."""

from typing import Any


class Mirror:
    """Assigns a control's value when what is to be shown changes, and only then.

    Between two looks at the inbox a person may have changed the control. Comparing with the
    control would find a difference and undo the change; comparing with what was shown last does
    not.
    """

    def __init__(self, handle: Any) -> None:
        self.handle = handle
        self._shown = handle.value

    def show(self, value: Any) -> None:
        """Shows a value; the same as last time changes nothing."""
        if value != self._shown:
            self._shown = value
            self.handle.value = value

    def settle(self, value: Any) -> None:
        """Shows a value unless a person is moving the control; to be called with every tick.

        While it moves, what is to be shown lags behind: to assign it would pull the control back.
        """
        held = self.handle.value
        if held == self._shown and held != value:
            self.handle.value = held = value
        self._shown = held

    def insist(self) -> None:
        """Sends once more what is shown, for a browser that may show something else.

        When a person moves a control while the program does, each may see the other's value last.
        """
        value = self.handle.value
        self.handle.value = self.handle.min  # An equal value would not be sent.
        self.handle.value = value

    def show_among(self, options: tuple[str, ...], value: str) -> None:
        """Shows a choice in a list that may have changed, which may have chosen another."""
        if self.handle.options != options:
            self.handle.options = options
            self._shown = self.handle.value
        self.show(value)

    def show_within(self, largest: float, value: float) -> None:
        """Shows a number on a slider whose range may have changed; never one beyond its end."""
        if self.handle.max != largest:
            self._shown = self.handle.value = self.handle.min
            self.handle.max = largest
        self.show(value)
