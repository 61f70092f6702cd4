"""The agent's policy as one Python file that needs numpy alone, and chooses the same actions."""

from collections.abc import Iterator
from importlib import metadata
from typing import IO

import numpy as np

from ao2viz.core.config import AnticipatingConfig
from ao2viz.core.decision import DecideBy
from ao2viz.core.forest import Forest
from ao2viz.core.inference import look_around
from ao2viz.core.local_linear import make_workspace
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
    source = template.format(
        # Within the quotes of a docstring neither quotes nor backslashes may stand as they are.
        env_id=one_line(spec.env_id).replace("\\", "/").replace('"', "'"),
        n_options=f"{len(content.view):,}",
        version=metadata.version("ao2viz"),
        n_steps=f"{saved.n_steps:,}",
        seed=saved.seed,
        features=[one_line(f.name) for f in spec.features],
        actions=[one_line(name) for name in spec.action_names],
        env_actions=env_actions,
        attention=content.view.attention.tolist(),
        options="".join(_rows(content)),
        result=result,
    )
    stream.write(source.encode())


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
