"""The settings of an agent: two presets, validated once, changed later only in how to decide."""

import difflib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from enum import Enum
from typing import Any

from ao2viz.core.decision import DecideBy


class Preset(Enum):
    """Which agent: the paper's, or ours that also learns what follows each action."""

    PAPER = "paper"
    ANTICIPATING = "anticipating"


class Credit(Enum):
    """How the `paper` preset turns the rewards of a trace into weights."""

    ACCUMULATE = "accumulate"
    """Every reward is added, discounted, to each action of the trace that led to it."""
    RETURN = "return"
    """The discounted sum of the next `trace_length` rewards moves the weight's running mean."""
    BOOTSTRAP = "bootstrap"
    """As `return`, plus what the option at the end of the trace expects."""


@dataclass(frozen=True)
class AnticipatingConfig:
    """Settings of the `anticipating` preset; `help(AO2)` says what each one does."""

    decide_by: DecideBy = DecideBy.PATH  # Who chooses the action; may change at any time.
    gamma: float = 0.995  # Discount per step, in (0, 1].
    levels: int = 3  # Halvings of similarity from a root (radius 1) to the finest option.
    attention_width: float = 4.0  # One unit of distance is this many standard deviations.
    warmup_steps: int = 250  # Random steps before the first attention is set.
    attention_relevance: float = 1.0  # How far attention goes to what the choice depends on.
    attention_growth: float = 0.15  # Regrow when attention is due to change by this fraction.
    epsilon_start: float = 1.0  # Chance of a random action at first, in [0, 1].
    epsilon_end: float = 0.03  # Chance of a random action from `epsilon_steps` on, in [0, 1].
    epsilon_steps: int = 5_000  # Steps over which exploration falls.
    voters: int = 32  # The most options that a vote, an outlook or a prediction rests on.
    experience_cap: int = 20  # Visits after which a running mean forgets the oldest.
    law_degree: int = 3  # Of the laws of what actions do in general, at the most; 0: none.
    effect_ridge: float = 0.01  # Steadies the local linear prediction of what follows.
    share_ridge: float = 0.02  # Steadies the planes that votes and outlooks rest on.
    slip: float = 0.05  # Chance of a random action that every value reckons with.
    imagine_limit: int = 20  # The most repetitions of an action while imagining.
    trace_length: int = 20  # Latest options whose weights are renewed after each step.
    refreshes: int = 2  # Imaginations renewed elsewhere after each step.
    backups: int = 200  # Options whose weights are renewed elsewhere after each step.
    story_length: int = 0  # Steps of real traces kept beside imagination; 0: none.
    sleep_sweeps: int = 300  # The most sweeps over all options when `learn` ends.
    cleansing: float = 0.0  # How much may change when options are let go after learning; 0: none.
    think_ahead: int = 0  # Steps of action sequences imagined for each decision; 0: none.
    think_limit: int = 0  # Milliseconds of that for each decision; 0: as long as it takes.
    action_smoothing: float = 1.0  # Share of the chosen action in what is executed, in (0, 1].
    impression: float = 0.0  # How far each step shifts attention (the paper's beta); 0: never.
    max_depth: int = 0  # The most steps from a root down to an option; 0: no limit.


@dataclass(frozen=True)
class PaperConfig:
    """Settings of the `paper` preset: the closest reading of Hakimzadeh et al."""

    decide_by: DecideBy = DecideBy.PATH  # Who chooses the action; may change at any time.
    gamma: float = 0.95  # Discount per step, in (0, 1].
    threshold: float = 0.9  # A state less similar than this to every option makes a new one.
    trace_length: int = 5  # Steps that share the credit for a reward.
    credit: Credit = Credit.ACCUMULATE  # How rewards become weights.
    failure_only: bool = False  # Learn from reward 0, and -1 when the task fails.
    step_size: float = 0.1  # The smallest step of a weight's running mean, in (0, 1].
    epsilon: float = 0.0  # Chance of a random action while learning, in [0, 1].
    voters: int = 16  # The most options that speak in a vote.
    share_ridge: float = 0.1  # Steadies the local linear shares of a vote.
    action_smoothing: float = 1.0  # Share of the chosen action in what is executed, in (0, 1].
    impression: float = 0.0  # How far each step shifts attention (the paper's beta); 0: never.
    max_depth: int = 0  # The most steps from a root down to an option; 0: no limit.


Config = AnticipatingConfig | PaperConfig
_CLASSES: Mapping[Preset, type[Config]] = {
    Preset.ANTICIPATING: AnticipatingConfig,
    Preset.PAPER: PaperConfig,
}

MAX_VOTERS = 64
"""The most options that a decision may rest on."""

# name: (smallest, largest), both allowed.
_RANGES: Mapping[str, tuple[float, float]] = {
    "gamma": (1e-6, 1.0),
    "levels": (0, 12),
    "attention_width": (1e-3, 1e6),
    "attention_relevance": (0.0, 4.0),
    "warmup_steps": (1, 10**9),
    "attention_growth": (1e-6, 1e6),
    "epsilon_start": (0.0, 1.0),
    "epsilon_end": (0.0, 1.0),
    "epsilon_steps": (1, 10**12),
    "voters": (2, MAX_VOTERS),
    "experience_cap": (1, 10**9),
    "law_degree": (0, 3),
    "effect_ridge": (1e-9, 1e6),
    "share_ridge": (1e-9, 1e6),
    "slip": (0.0, 1.0),
    "imagine_limit": (1, 10_000),
    "trace_length": (1, 10_000),
    "refreshes": (0, 10_000),
    "backups": (0, 1_000_000),
    "story_length": (0, 10_000),
    "sleep_sweeps": (0, 1_000_000),
    "cleansing": (0.0, 1.0),
    "think_ahead": (0, 8),
    "think_limit": (0, 60_000),
    "threshold": (0.0, 1.0),
    "step_size": (1e-9, 1.0),
    "epsilon": (0.0, 1.0),
    "action_smoothing": (1e-6, 1.0),
    "impression": (0.0, 1.0),
    "max_depth": (0, 10_000),
}


def make_config(preset: Preset, settings: Mapping[str, Any]) -> Config:
    """The preset's config with these settings, each checked; enums may be given as strings.

    Raises:
        ValueError: If a name is unknown (the valid ones are listed) or a value out of range.
    """
    return change_config(_CLASSES[preset](), settings)


def change_config(config: Config, settings: Mapping[str, Any]) -> Config:
    """A copy with some settings changed and checked; see `make_config`."""
    check_names(preset_of(config), settings)
    checked = {name: _check(name, value, getattr(config, name)) for name, value in settings.items()}
    return replace(config, **checked)


def check_names(preset: Preset, names: Iterable[str], beside: tuple[str, ...] = ()) -> None:
    """Checks that the preset has settings of these names, or that they are among `beside`.

    Raises:
        ValueError: Naming the first that is neither, and those that there are.
    """
    known = [*beside, *(field.name for field in fields(_CLASSES[preset]))]
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f" Did you mean {near[0]!r}?" if near else ""
            raise ValueError(
                f"There is no setting {name!r} in the {preset.value} preset.{hint} Valid "
                f"settings: {', '.join(known)}."
            )


def config_to_dict(config: Config) -> dict[str, bool | int | float | str]:
    """Every setting as plain JSON values; `make_config` reads it back."""
    return {
        field.name: value.value if isinstance(value := getattr(config, field.name), Enum) else value
        for field in fields(config)
    }


def range_of(name: str) -> tuple[float, float]:
    """Smallest and largest value of a setting that is a number, both allowed."""
    return _RANGES[name]


def to_preset(preset: Preset | str) -> Preset:
    """A preset, given as itself or by name.

    Raises:
        ValueError: If there is no preset of this name.
    """
    try:
        return Preset(preset)
    except ValueError:
        names = " or ".join(repr(kind.value) for kind in Preset)
        raise ValueError(f"Expected preset to be {names}, but got {preset!r}.") from None


def preset_of(config: Config) -> Preset:
    """Which preset a config belongs to."""
    return Preset.PAPER if isinstance(config, PaperConfig) else Preset.ANTICIPATING


def _check(name: str, value: Any, default: Any) -> Any:
    if isinstance(default, Enum):
        kind = type(default)
        try:
            return value if isinstance(value, kind) else kind(value)
        except ValueError:
            names = ", ".join(repr(member.value) for member in kind)
            raise ValueError(f"Expected {name} to be one of {names}, but got {value!r}.") from None
    if isinstance(default, bool):
        if not isinstance(value, bool):
            raise ValueError(f"Expected {name} to be true or false, but got {value!r}.")
        return value
    low, high = _RANGES[name]
    whole = isinstance(default, int)
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or (isinstance(value, float) and not math.isfinite(value)):
        raise ValueError(f"Expected {name} to be a finite number, but got {value!r}.")
    if whole and value != int(value):
        raise ValueError(f"Expected {name} to be a whole number, but got {value!r}.")
    if not low <= value <= high:
        raise ValueError(f"Expected {name} between {low:g} and {high:g}, but got {value!r}.")
    return int(value) if whole else float(value)
