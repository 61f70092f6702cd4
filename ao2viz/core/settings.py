"""Every setting of a preset as people meet it: what it does, what it may be, when it takes effect.

Names, defaults and ranges are those of `ao2viz.core.config`, which checks every value.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import Enum

from ao2viz.core.config import Preset, config_to_dict, make_config, range_of

Plain = bool | int | float | str
"""The value of a setting as plain JSON."""


class TakesEffect(Enum):
    """When a changed setting begins to matter; the values are what people read."""

    AT_ONCE = "at once"
    NEXT_LOOK = "when attention is looked at, between episodes"
    WHEN_DONE = "when learning ends"
    NEW_RUN = "in a new run"


class Group(Enum):
    """What a setting is about; the values are what people read."""

    DECIDING = "Deciding"
    EXPLORING = "Exploring"
    GROWING = "Growing the forest"
    ATTENDING = "Attention"
    LEARNING = "Learning"
    IMAGINING = "Imagining"


@dataclass(frozen=True)
class Setting:
    """One setting of one preset."""

    name: str
    default: Plain  # Of the preset; an environment may bring its own.
    meaning: str
    group: Group
    takes_effect: TakesEffect
    range: tuple[float, float] | None  # Smallest and largest, both allowed; None: no number.
    choices: tuple[str, ...]  # Empty unless it is one of several words.


def settings_of(preset: Preset) -> tuple[Setting, ...]:
    """Every setting of a preset, by group."""
    config = make_config(preset, {})
    found = []
    plain = config_to_dict(config)
    for field in fields(config):
        name, default = field.name, getattr(config, field.name)
        group, meaning = _ABOUT[name]
        if not isinstance(meaning, str):
            meaning = meaning[preset]
        choices = ()
        if isinstance(default, Enum):
            choices = tuple(member.value for member in type(default))
        effect = _EFFECTS[preset].get(name, TakesEffect.NEW_RUN)
        limits = None if choices or isinstance(default, bool) else range_of(name)
        found.append(Setting(name, plain[name], meaning, group, effect, limits, choices))
    order = list(Group)
    return tuple(sorted(found, key=lambda setting: order.index(setting.group)))


_ABOUT: Mapping[str, tuple[Group, str | Mapping[Preset, str]]] = {
    "decide_by": (Group.DECIDING, "who chooses the action; may change at any time"),
    "voters": (Group.DECIDING, "the most options that speak in a vote"),
    "share_ridge": (
        Group.DECIDING,
        "steadies the slopes behind votes and outlooks: larger pulls towards plain closeness",
    ),
    "think_ahead": (
        Group.DECIDING,
        "steps of the action sequences that each decision imagines, 0 to 8; 0: none",
    ),
    "think_limit": (
        Group.DECIDING,
        "milliseconds after which that is cut short, in each decision; 0: never",
    ),
    "action_smoothing": (
        Group.DECIDING,
        "continuous actions only: the share α of the chosen action in what is executed; the rest "
        "is what was executed last. 1: it is executed as chosen",
    ),
    "epsilon_start": (Group.EXPLORING, "chance of a random action at first"),
    "epsilon_end": (Group.EXPLORING, "chance of a random action after epsilon_steps"),
    "epsilon_steps": (Group.EXPLORING, "steps over which exploration falls"),
    "epsilon": (Group.EXPLORING, "chance of a random action while learning"),
    "levels": (
        Group.GROWING,
        "halvings of the radius from a root (1) to the finest option; one more level, finer "
        "options and more of them",
    ),
    "threshold": (
        Group.GROWING,
        "a state that is not more similar than this to its most similar option makes a new one",
    ),
    "max_depth": (
        Group.GROWING,
        "the most steps from a root down to an option; 0: no limit, 1: nothing lies deeper than a "
        "root's child",
    ),
    "cleansing": (
        Group.GROWING,
        "let go of options when learning ends, as long as expectations change by no more than so "
        "many standard deviations of what options are worth; 0: none",
    ),
    "warmup_steps": (Group.ATTENDING, "random steps before the first attention is set"),
    "attention_width": (
        Group.ATTENDING,
        "this many standard deviations of a feature are one unit of distance",
    ),
    "attention_relevance": (
        Group.ATTENDING,
        "how far attention goes to the features that the choice depends on: 0 not at all, it "
        "follows the standard deviations; 1 in proportion",
    ),
    "attention_growth": (
        Group.ATTENDING,
        "regrow when the attention of a feature is due to change by this fraction",
    ),
    "impression": (
        Group.ATTENDING,
        "how far each step shifts attention, the paper's β; 0: not at all",
    ),
    "gamma": (Group.LEARNING, "discount: a reward one step later counts this much less"),
    "trace_length": (
        Group.LEARNING,
        {
            Preset.ANTICIPATING: "latest options whose weights are renewed after each step",
            Preset.PAPER: "steps that share the credit for a reward",
        },
    ),
    "credit": (
        Group.LEARNING,
        "how rewards become weights: accumulate, return or bootstrap",
    ),
    "failure_only": (
        Group.LEARNING,
        "learn from reward 0, and −1 when the task fails, instead of the environment's own reward",
    ),
    "step_size": (Group.LEARNING, "the smallest step of a weight's running mean"),
    "experience_cap": (
        Group.LEARNING,
        "visits after which a running mean forgets the oldest",
    ),
    "story_length": (Group.LEARNING, "steps of real traces kept beside imagination; 0 keeps none"),
    "refreshes": (Group.LEARNING, "imaginations renewed elsewhere after each step"),
    "backups": (Group.LEARNING, "options whose weights are renewed elsewhere after each step"),
    "sleep_sweeps": (Group.LEARNING, "the most sweeps over all options when learn ends"),
    "law_degree": (
        Group.IMAGINING,
        "the highest degree of the laws of what actions do in general; 0: no laws",
    ),
    "effect_ridge": (Group.IMAGINING, "steadies the prediction of what follows an action"),
    "slip": (Group.IMAGINING, "the chance of a random action that every value reckons with"),
    "imagine_limit": (Group.IMAGINING, "the most repetitions of an action while imagining"),
}

# What a learner reads anew whenever it needs it. All else shapes what is in its memory already.
_EFFECTS: Mapping[Preset, Mapping[str, TakesEffect]] = {
    Preset.ANTICIPATING: {
        **dict.fromkeys(
            (
                "decide_by",
                "share_ridge",
                "think_ahead",
                "think_limit",
                "epsilon_start",
                "epsilon_end",
                "epsilon_steps",
                "experience_cap",
                "refreshes",
                "backups",
                "effect_ridge",
                "slip",
                "imagine_limit",
            ),
            TakesEffect.AT_ONCE,
        ),
        "attention_relevance": TakesEffect.NEXT_LOOK,
        "attention_growth": TakesEffect.NEXT_LOOK,
        "sleep_sweeps": TakesEffect.WHEN_DONE,
        "cleansing": TakesEffect.WHEN_DONE,
    },
    Preset.PAPER: dict.fromkeys(
        ("decide_by", "share_ridge", "threshold", "step_size", "epsilon"), TakesEffect.AT_ONCE
    ),
}


def check_changeable(preset: Preset, names: set[str]) -> None:
    """Checks that a learner of this preset can change these settings in the middle of its life.

    Raises:
        ValueError: Naming those that it cannot, and those that it can.
    """
    fixed = sorted(names - set(_EFFECTS[preset]))
    if fixed:
        verb = "takes" if len(fixed) == 1 else "take"
        raise ValueError(
            f"{', '.join(fixed)} {verb} effect in a new run only; in the middle of one can change: "
            f"{', '.join(_EFFECTS[preset])}."
        )
