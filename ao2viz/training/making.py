"""The agent that a start asks for, and errors as people read them."""

from ao2viz.agent import AO2
from ao2viz.envs.task import make_env
from ao2viz.store.files import read
from ao2viz.training.states import Start


def make_agent(start: Start) -> AO2:
    """A new agent, or that of the file to go on with, with an environment that draws.

    Raises:
        ValueError: If environment, settings or file do not fit; environments may raise anything.
    """
    if start.total_steps < 1:
        raise ValueError(f"Expected at least one step to take, but got {start.total_steps}.")
    if start.resume_from is None:
        env = make_env(start.env_id, render=True)
        return AO2(env, start.preset, start.seed, **start.overrides)
    saved = read(start.resume_from)
    # "module:EnvId" of the command also tells where the environment of the file comes from.
    known = saved.spec.env_id
    env_id = start.env_id if start.env_id.rpartition(":")[2] == known else known
    return AO2.from_saved(saved, make_env(env_id, render=True))


def in_words(error: Exception) -> str:
    """An error in one line; of those that are not ours with the name of its kind."""
    text = " ".join(str(error).split())
    if isinstance(error, OSError) and error.strerror:
        text = error.strerror
    elif not isinstance(error, ValueError) or not text:
        text = f"{type(error).__name__}: {text}" if text else type(error).__name__
    return text if text.endswith((".", "!", "?")) else f"{text}."
