"""`ao2viz cleanse`: a smaller agent that decides the same."""

from dataclasses import asdict
from pathlib import Path

from ao2viz.agent import AO2
from ao2viz.cli.console import say, show_json, stderr
from ao2viz.cli.files import check_output


def run(file: Path, *, out: Path, tolerance: float, overwrite: bool, as_json: bool) -> None:
    """Cleanses an agent, saves it, and says what went and which decisions changed.

    Raises:
        ValueError: If the file is no agent of the anticipating preset, or `out` cannot be written.
    """
    check_output(out, overwrite=overwrite)
    agent = AO2.load(file)
    with stderr().status(f"Cleansing {len(agent.forest):,} options …"):
        done = agent.cleanse(tolerance)
        agent.save(out)
    if as_json:
        show_json({"file": str(out), "tolerance": tolerance, **asdict(done)})
        return
    gone = done.options_before - done.options_after
    say(f"{gone:,} of {done.options_before:,} options went; {done.options_after:,} are left.")
    say(
        f"Decisions changed at {done.values_changed:,} of {done.options_before:,} options' values "
        f"and in {done.states_changed:,} of {done.states:,} recorded states."
    )
    say(f"Saved to {out}.")
