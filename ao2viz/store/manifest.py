"""The manifest of an agent file: what it says, how it is checked, how old ones are upgraded."""

import json
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import metadata
from typing import Any

from ao2viz.core.config import Preset, config_to_dict, make_config
from ao2viz.envs.task import TaskSpec
from ao2viz.store.archive import Member
from ao2viz.store.errors import AgentFileError, quote
from ao2viz.store.fields import MAX_INT, Fields, Json, parse_object
from ao2viz.store.saved import Generator, SavedAgent
from ao2viz.store.task import task_from_json, task_to_json

FORMAT = "ao2viz-agent"
FORMAT_VERSION = 2
MAX_EPISODES = 1_000

# From each older version to the next, on plain data; the reader below knows only the newest.


def _forget_splitting(manifest: Json) -> Json:
    """Format 1 could split options where their advice misled; outlooks made that needless."""
    settings = manifest.get("settings")
    if not isinstance(settings, dict):
        return manifest
    kept = {name: value for name, value in settings.items() if name != "split_distance"}
    return manifest | {"settings": kept}


# Settings that a file may lack: an agent without them did what these say.
_BEHAVIOUR = {"action_smoothing": 1.0, "impression": 0.0, "max_depth": 0}
_IF_LACKING: Mapping[Preset, Json] = {
    Preset.ANTICIPATING: {
        "cleansing": 0.0,
        "think_ahead": 0,
        "think_limit": 0,
        "law_degree": 0,
        **_BEHAVIOUR,
    },
    Preset.PAPER: _BEHAVIOUR,
}

UPGRADES: Mapping[int, Callable[[Json], Json]] = {1: _forget_splitting}


@dataclass(frozen=True)
class EpisodeHeader:
    """What the manifest says of a recorded episode; its arrays are members."""

    seed: int
    steps: int
    total_reward: float
    terminated: bool
    truncated: bool
    started_at: int
    is_training: bool


@dataclass(frozen=True, eq=False)
class Manifest:
    """A checked manifest."""

    created_at: str
    versions: Mapping[str, str]
    spec: TaskSpec
    preset: Preset
    settings: Mapping[str, Any]
    seed: int
    n_steps: int
    n_options: int
    mean_return: float | None  # Of the latest up to 100 training episodes.
    generator: Generator
    growth_dropped: int
    episodes: tuple[EpisodeHeader, ...]
    members: Mapping[str, Member]


def to_json(saved: SavedAgent, members: Mapping[str, Member], created_at: str) -> bytes:
    """The manifest of an agent whose arrays are `members`."""
    recent = saved.history[-100:, 1]
    manifest: Json = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "created_at": created_at,
        "versions": library_versions(),
        "task": task_to_json(saved.spec),
        "preset": saved.preset.value,
        "settings": config_to_dict(saved.config),
        "seed": saved.seed,
        "n_steps": saved.n_steps,
        "n_options": len(saved.forest_view()),
        "mean_return": float(recent.mean()) if len(recent) else None,
        "generator": dict(saved.generator),
        "growth_dropped": saved.growth_dropped,
        "episodes": [
            {
                "seed": episode.seed,
                "steps": len(episode),
                "total_reward": episode.total_reward,
                "terminated": episode.terminated,
                "truncated": episode.truncated,
                "started_at": episode.started_at,
                "is_training": episode.is_training,
            }
            for episode in saved.episodes
        ],
        "members": {name: member.to_json() for name, member in members.items()},
    }
    return json.dumps(manifest, allow_nan=False, ensure_ascii=False, indent=1).encode()


def from_json(content: bytes) -> Manifest:
    """Reads, upgrades and checks a manifest.

    Raises:
        AgentFileError: Naming the first field that is not as it should be.
    """
    top = Fields(upgrade(parse_object(content)), "manifest")
    preset = Preset(top.one_of("preset", [kind.value for kind in Preset]))
    settings = _settings(preset, top.mapping("settings"))
    spec = task_from_json(Fields(top.mapping("task"), "task"))
    return Manifest(
        created_at=top.text("created_at"),
        versions={
            name: top.check_text(name, text) for name, text in top.mapping("versions").items()
        },
        spec=spec,
        preset=preset,
        settings=settings,
        seed=top.whole("seed", most=2**63 - 1),
        n_steps=top.whole("n_steps"),
        n_options=top.whole("n_options"),
        mean_return=None if top.raw("mean_return") is None else top.number("mean_return"),
        generator=_generator(Fields(top.mapping("generator"), "generator")),
        growth_dropped=top.whole("growth_dropped"),
        episodes=tuple(
            _episode(Fields(raw, f"episode {i}"))
            for i, raw in enumerate(top.items("episodes", MAX_EPISODES))
        ),
        members={name: Member.from_json(name, raw) for name, raw in top.mapping("members").items()},
    )


def upgrade(manifest: Json) -> Json:
    """Brings a manifest to `FORMAT_VERSION`; an up-to-date one comes back as it was.

    Raises:
        AgentFileError: If it is not an agent's, or from a newer ao2viz.
    """
    if manifest.get("format") != FORMAT:
        raise AgentFileError(
            f"Expected the manifest of an agent ({FORMAT!r}), but its format is "
            f"{quote(manifest.get('format'))}."
        )
    version = Fields(manifest, "manifest").whole("format_version")
    if version > FORMAT_VERSION:
        raise AgentFileError(
            f"This agent needs a newer ao2viz: its format is {version}, and {FORMAT_VERSION} is "
            f"the newest known here."
        )
    while version < FORMAT_VERSION:
        if version not in UPGRADES:
            raise AgentFileError(f"There has never been a format {version} of agent files.")
        manifest = UPGRADES[version](manifest) | {"format_version": version + 1}
        version += 1
    return manifest


def library_versions() -> dict[str, str]:
    """What an agent was made with."""
    libraries = ("ao2viz", "gymnasium", "numba", "numpy")
    return {"python": platform.python_version()} | {name: _version(name) for name in libraries}


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:  # Run from a folder, without installing.
        return "unknown"


def _settings(preset: Preset, settings: Json) -> Json:
    settings = _IF_LACKING[preset] | settings
    fields = Fields(settings, "settings")
    for name, value in settings.items():
        fields.check_text("the name of a setting", name)
        if isinstance(value, str):
            fields.check_text(name, value)
        elif type(value) is int:
            fields.whole(name, least=-MAX_INT)
    known = config_to_dict(make_config(preset, {})).keys()
    if unknown := [name for name in settings if name not in known]:
        raise AgentFileError(
            f"A setting does not fit: There is no setting {quote(unknown[0])} in the "
            f"{preset.value} preset."
        )
    try:
        make_config(preset, settings)
    except ValueError as error:
        raise AgentFileError(f"A setting does not fit: {error}") from error
    if lacking := known - settings.keys():
        raise AgentFileError(f"Expected all settings, but {sorted(lacking)[0]!r} is missing.")
    return settings


def _generator(fields: Fields) -> Generator:
    state: dict[str, str | int] = {"bit_generator": fields.one_of("bit_generator", ["PCG64"])}
    for name in ("state", "inc"):
        text = fields.text(name)
        digits = text.removeprefix("0x")
        if not (0 < len(digits) <= 32 and set(digits) <= set("0123456789abcdef")):
            raise AgentFileError(f"Expected {name!r} of the generator in hexadecimal.")
        state[name] = text
    state["has_uint32"] = fields.whole("has_uint32", most=1)
    state["uinteger"] = fields.whole("uinteger", most=2**32 - 1)
    return state


def _episode(fields: Fields) -> EpisodeHeader:
    return EpisodeHeader(
        seed=fields.whole("seed", most=2**63 - 1),
        steps=fields.whole("steps", least=1, most=2**31),
        total_reward=fields.number("total_reward"),
        terminated=fields.truth("terminated"),
        truncated=fields.truth("truncated"),
        started_at=fields.whole("started_at"),
        is_training=fields.truth("is_training"),
    )
