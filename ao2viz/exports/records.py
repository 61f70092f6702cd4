"""Episodes for other people's training tools: Minari data sets, TensorBoard event files."""

import contextlib
import os
import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ao2viz.envs.motion import Motion
from ao2viz.envs.task import TaskSpec, make_env
from ao2viz.exports.content import Content
from ao2viz.recording.episode import Episode


def fill_minari(content: Content, folder: Path) -> None:
    """A folder of Minari data sets with one in it, `ENV/ao2viz-v0`: the chosen episodes.

    Seeds are in it, so that whoever has the environment can play every episode again.

    Raises:
        ValueError: If there is no episode, or the environment cannot be made.
    """
    import minari  # noqa: PLC0415 -- an extra.
    from minari.data_collector import EpisodeBuffer  # noqa: PLC0415

    content.need_episodes()
    env = make_env(content.env_id)
    buffers = []
    for done, (_, episode) in enumerate(content.episodes):
        ends = np.zeros((2, len(episode)), np.bool_)
        # An episode that was still under way ends here because the recording does.
        ends[0 if episode.terminated else 1, -1] = True
        buffers.append(
            EpisodeBuffer(
                id=done,
                seed=episode.seed,
                observations=list(episode.observations.astype(env.observation_space.dtype)),
                actions=list(_executed(episode, content.spec)),
                rewards=episode.rewards.tolist(),
                terminations=ends[0].tolist(),
                truncations=ends[1].tolist(),
            )
        )
        content.progress(0.9 * (done + 1) / len(content.episodes))
    with _datasets_in(folder), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # It asks for authors, whom we do not know.
        minari.create_dataset_from_buffers(
            dataset_name(content.spec),
            buffers,
            env=env,
            algorithm_name="AO2",
            description=f"Episodes of an AO2 agent, seed {content.saved.seed}, after "
            f"{content.saved.n_steps} steps; recorded with ao2viz.",
            data_format="arrow",
        )


def dataset_name(spec: TaskSpec) -> str:
    """What Minari calls the data set, `ENV/ao2viz-v0`, in letters that it allows."""
    name = re.sub(r"[^A-Za-z0-9]+", "-", spec.env_id).strip("-").lower()
    return f"{name or 'environment'}/ao2viz-v0"


def fill_tensorboard(content: Content, folder: Path) -> None:
    """An event file: training over the agent's steps, and each chosen episode over its own."""
    from tensorboardX.proto import event_pb2  # noqa: PLC0415 -- an extra.
    from tensorboardX.record_writer import RecordWriter  # noqa: PLC0415
    from tensorboardX.summary import scalar  # noqa: PLC0415

    messages: Any = event_pb2  # Its classes are made when it is imported.
    rows = list(_scalars(content))
    # Written step by step here, and not by a thread: an error of the disk is raised, not lost.
    writer = RecordWriter(str(folder / "events.out.tfevents.0.ao2viz"))
    try:
        writer.write(
            messages.Event(wall_time=0.0, file_version="brain.Event:2").SerializeToString()
        )
        for done, (tag, at, value) in enumerate(rows):
            event = messages.Event(wall_time=float(at), step=at, summary=scalar(tag, value))
            writer.write(event.SerializeToString())
            content.progress((done + 1) / len(rows))
        writer.flush()
    finally:
        writer.close()


def _scalars(content: Content) -> Iterator[tuple[str, int, float]]:
    """Tag, step and value; the tags of one group stand beside one another."""
    for end, total, length, options in content.saved.history.tolist():
        yield "training/return", int(end), total
        yield "training/steps", int(end), length
        yield "training/options", int(end), options
    for number, step in content.all_steps():
        decision = step.decision
        yield f"episode_{number}/margin", step.number, decision.margin
        yield f"episode_{number}/reward", step.number, step.reward
        yield f"episode_{number}/path_length", step.number, float(len(decision.path))
        if len(decision.voters):
            yield f"episode_{number}/distance", step.number, decision.distance


def _executed(episode: Episode, spec: TaskSpec) -> Iterator[NDArray | int]:
    """What the environment was given at each step."""
    motion = Motion(spec, episode.action_smoothing)
    for action in episode.actions.tolist():
        yield motion.execute(action)


@contextlib.contextmanager
def _datasets_in(folder: Path) -> Iterator[None]:
    """Lets Minari, which reads the place from the environment variables, write to a folder."""
    name = "MINARI_DATASETS_PATH"
    before = os.environ.get(name)
    os.environ[name] = str(folder.resolve())
    try:
        yield
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before
