"""The agent's policy as one Python file that needs numpy alone, and chooses the same actions."""

import importlib.util
import tempfile
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import IO

import numpy as np

from ao2viz.core.config import AnticipatingConfig
from ao2viz.core.decision import DecideBy
from ao2viz.core.forest import Forest
from ao2viz.core.inference import look_around
from ao2viz.core.local_linear import make_workspace
from ao2viz.core.mind import Mind
from ao2viz.explain.faithful import spread
from ao2viz.explain.whole import MOST_STATES
from ao2viz.explain.words import count
from ao2viz.exports.content import Content
from ao2viz.exports.escaping import one_line
from ao2viz.resources import static


def write_policy(content: Content, stream: IO[bytes]) -> None:
    """The file: `act(observation)` gives what `env.step` takes.

    Every option's outlook is computed here once, by the same compiled code that decides, so that
    what is left to do is the same few sums in the same order, to the bit.

    Raises:
        ValueError: If the agent decides in a way that the file does not; says how to switch.
    """
    _check(content)
    spec, saved = content.spec, content.saved
    template = (static() / "policy.py.template").read_text("utf-8")
    if spec.action_grid is None:
        env_actions = f"ENV_ACTIONS = {[a + spec.action_offset for a in range(spec.n_actions)]!r}"
        result = "ENV_ACTIONS[choose(observation)]"
    else:
        env_actions = f"ENV_ACTIONS = np.array({spec.action_grid.tolist()!r}, np.float32)"
        result = "ENV_ACTIONS[choose(observation)].copy()"
    parts = {
        # Within the quotes of a docstring neither quotes nor backslashes may stand as they are.
        "env_id": one_line(spec.env_id).replace("\\", "/").replace('"', "'"),
        "n_options": f"{len(content.view):,}",
        "version": metadata.version("ao2viz"),
        "n_steps": f"{saved.n_steps:,}",
        "seed": saved.seed,
        "features": [one_line(f.name) for f in spec.features],
        "actions": [one_line(name) for name in spec.action_names],
        "env_actions": env_actions,
        "attention": content.view.attention.tolist(),
        "options": "".join(_rows(content)),
        "result": result,
    }
    told = _try_out(template.format(**parts, faithfulness=""), content)
    stream.write(template.format(**parts, faithfulness=told).encode())


def _try_out(source: str, content: Content) -> str:
    """On how many recorded states the file chooses as the agent does; it is run for that."""
    mind = Mind(content.saved.config, content.saved.state)
    seen = [decision.observation for decision in content.decisions]
    where = "recorded state"
    if not seen:
        seen, where = list(content.view.values[content.view.is_alive]), "option"
    states = spread(seen, MOST_STATES)
    with tempfile.TemporaryDirectory(prefix="ao2viz-") as folder:
        path = Path(folder) / "policy.py"
        path.write_text(source, "utf-8")
        module = load_module("ao2viz_exported_policy", path)
    agreed = sum(module.choose(state) == mind.act(state) for state in states)
    return f"Tried at {count(len(states), where)}: it chooses as the agent does at {agreed:,}."


def load_module(name: str, path: Path) -> ModuleType:
    """Runs a file of Python that we wrote, apart from all others."""
    found = importlib.util.spec_from_file_location(name, path)
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def _check(content: Content) -> None:
    config = content.saved.config
    if config.decide_by is not DecideBy.PATH:
        raise ValueError(
            "This agent decides by vote, which a policy file cannot. Let one path decide first: "
            'agent.set_decide_by("path"), and save or export it then.'
        )
    if isinstance(config, AnticipatingConfig) and config.think_ahead > 0:
        raise ValueError(
            f"This agent thinks {config.think_ahead} steps ahead, which a policy file cannot. "
            "Switch it off first: agent.set_think_ahead(0), and save or export it then."
        )
    if config.action_smoothing < 1:
        raise ValueError(
            "This agent's actions are smoothed (action_smoothing below 1), so what it does depends "
            "on what it did before, which a policy file cannot tell from an observation. Train one "
            "with action_smoothing 1."
        )


def _rows(content: Content) -> Iterator[str]:
    """One line of source for each living option, the oldest first."""
    spec, config = content.spec, content.saved.config
    forest = Forest(spec.n_features, spec.n_actions, np.zeros(spec.n_features))
    forest.set_state(content.saved.state)
    work = make_workspace(config.voters, spec.n_features, spec.n_actions)
    levels = np.zeros(spec.n_actions)
    alive = np.flatnonzero(content.view.is_alive).tolist()
    for done, option in enumerate(alive):
        if isinstance(config, AnticipatingConfig):
            look_around(forest.columns, option, config.share_ridge, work, levels)
            slopes = work.slopes
        else:
            levels[:] = forest.columns.weights[option]
            slopes = np.zeros((spec.n_actions, spec.n_features))
        row = [*forest.columns.scaled[option], *levels, *slopes.ravel()]
        # `repr` of a float reads back as the same float.
        yield f"        [{option}, {', '.join(repr(float(number)) for number in row)}],\n"
        content.progress((done + 1) / len(alive))
