"""What holds for every test."""

import signal


def pytest_configure() -> None:
    # What a shell starts in the background ignores Ctrl-C, and so does all that it starts in turn:
    # the commands that tests interrupt would never end.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
