"""What is raised when a file is not an agent."""


class AgentFileError(ValueError):
    """A file is not a sound .ao2 agent; one line that says what was expected and what came."""


def quote(text: object) -> str:
    """Text from a file, made safe and short for one line of a message."""
    shown = ascii(text)
    return shown if len(shown) <= 80 else shown[:76] + "..."
