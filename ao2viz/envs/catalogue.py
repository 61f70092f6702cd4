"""The environments we know by name: features, units, ranges, actions, the paper's settings."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Feature:
    """One number of an observation."""

    name: str
    unit: str = ""  # Empty: a plain number.
    scale: float = 1.0  # Shown value = observed value · scale (radians shown as degrees).
    range: float | None = None  # Half-width used by the paper's similarity; None: from the space.


@dataclass(frozen=True)
class Entry:
    """What we know of one environment; every part has a fallback for unknown ones."""

    env_id: str
    title: str
    features: tuple[Feature, ...] = ()
    actions: tuple[str, ...] = ()
    paper_settings: Mapping[str, Any] = field(default_factory=dict)  # Of the `paper` preset.
    paper_score: float | None = None  # Average of AO2 in the paper's Table II.
    solved_at: float | None = None  # The return at which people call it solved.


_DEGREES = 57.29577951308232


_CARTPOLE_FEATURES = (
    Feature("cart position", "m", range=4.8),
    Feature("cart velocity", "m/s", range=4.0),
    Feature("pole angle", "°", _DEGREES, range=0.4189),
    Feature("pole angular velocity", "°/s", _DEGREES, range=4.0),
)
_PAPER_CARTPOLE: Mapping[str, Any] = {
    "threshold": 0.9,
    "trace_length": 5,
    "gamma": 0.95,
    "credit": "accumulate",
    "failure_only": True,
}
# The paper's for Acrobot, and for tasks that it does not have, where nothing was chosen.
_PAPER_ACROBOT: Mapping[str, Any] = {
    "threshold": 0.99,
    "trace_length": 80,
    "gamma": 0.99,
    "credit": "bootstrap",
}

CATALOGUE: Mapping[str, Entry] = {
    entry.env_id: entry
    for entry in (
        Entry(
            "CartPole-v0",
            "Cart pole, 200 steps",
            _CARTPOLE_FEATURES,
            ("push left", "push right"),
            _PAPER_CARTPOLE,
            paper_score=194.0,
            solved_at=195.0,
        ),
        Entry(
            "CartPole-v1",
            "Cart pole, 500 steps",
            _CARTPOLE_FEATURES,
            ("push left", "push right"),
            _PAPER_CARTPOLE,
            solved_at=475.0,
        ),
        Entry(
            "Pendulum-v1",
            "Pendulum swing-up",
            (
                Feature("height (cos of angle)", range=2.0),
                Feature("side (sin of angle)", range=2.0),
                Feature("angular velocity", "°/s", _DEGREES, range=16.0),
            ),
            (),
            {
                "threshold": 0.99,
                "trace_length": 18,
                "gamma": 0.99,
                "credit": "return",
            },
            paper_score=-196.6,
        ),
        Entry(
            "Acrobot-v1",
            "Acrobot swing-up",
            (
                Feature("cos of upper angle", range=2.0),
                Feature("sin of upper angle", range=2.0),
                Feature("cos of lower angle", range=2.0),
                Feature("sin of lower angle", range=2.0),
                Feature("upper angular velocity", "°/s", _DEGREES, range=8.0),
                Feature("lower angular velocity", "°/s", _DEGREES, range=16.0),
            ),
            ("torque −1", "no torque", "torque +1"),
            _PAPER_ACROBOT,
            paper_score=-89.5,
            solved_at=-100.0,
        ),
        Entry(
            "MountainCar-v0",
            "Mountain car",
            (Feature("position"), Feature("velocity", "per step")),
            ("push left", "no push", "push right"),
            _PAPER_ACROBOT,
            solved_at=-110.0,
        ),
        Entry(
            "LunarLander-v3",
            "Lunar lander",
            (
                # Observed in half widths and heights of the window, and by the step of 1/50 s.
                Feature("across from the pad", "m", 10.0),
                Feature("height", "m", 20 / 3),
                Feature("velocity across", "m/s", 5.0),
                Feature("velocity up", "m/s", 7.5),
                Feature("angle", "°", _DEGREES),
                Feature("angular velocity", "°/s", 2.5 * _DEGREES),
                Feature("left leg on the ground"),
                Feature("right leg on the ground"),
            ),
            ("no engine", "left engine", "main engine", "right engine"),
            _PAPER_ACROBOT,
            solved_at=200.0,
        ),
    )
}
