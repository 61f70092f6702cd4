"""What the paper reports, to be laid beside what we measure."""

from collections.abc import Mapping
from dataclasses import dataclass

from ao2viz.baselines.algorithm import Algorithm
from ao2viz.core.config import Preset
from ao2viz.experiments.plan import Learner

CARTPOLE, PENDULUM, ACROBOT = ENVS = ("CartPole-v0", "Pendulum-v1", "Acrobot-v1")
"""The paper's tasks; it says Pendulum-v0, the same task under a name that is gone."""


@dataclass(frozen=True)
class Published:
    """The two figures of a cell."""

    best: float
    average: float


_AO2 = {
    CARTPOLE: Published(197.2, 194.0),
    PENDULUM: Published(-126.6, -196.6),
    ACROBOT: Published(-77.12, -89.5),
}
_PPO = {
    CARTPOLE: Published(196.8, 191.5),
    PENDULUM: Published(-164.19, -241.16),
    ACROBOT: Published(-101.63, -214.37),
}
TABLE_II: Mapping[Learner, Mapping[str, Published]] = {
    Preset.PAPER: _AO2,
    Preset.ANTICIPATING: _AO2,
    Algorithm.DAC_A2C: {
        CARTPOLE: Published(197.1, 193.9),
        PENDULUM: Published(-437.25, -496.28),
        ACROBOT: Published(-98.15, -261.48),
    },
    Algorithm.PPOC: {
        CARTPOLE: Published(197.1, 193.7),
        PENDULUM: Published(-513.84, -623.17),
        ACROBOT: Published(-104.58, -268.17),
    },
    Algorithm.DAC_PPO: {
        CARTPOLE: Published(197.0, 196.1),
        PENDULUM: Published(-141.18, -204.81),
        ACROBOT: Published(-59.38, -69.24),
    },
    Algorithm.PPO: _PPO,
    Algorithm.SB3_PPO: _PPO,
}
"""Table II; AO2's row beside both of our presets, PPO's beside both implementations."""

AO2_SCORE: Mapping[str, float] = {env: cell.average for env, cell in _AO2.items()}
"""What counts as having reached the paper's AO2."""


@dataclass(frozen=True)
class Trait:
    """One of the paper's behaviour experiments, all on Pendulum."""

    name: str
    settings: str  # JSON object, as a run's.
    published: Published


TRAITS = (
    Trait("smooth actions", '{"action_smoothing": 0.9}', Published(-167, -212)),
    Trait("exploration", '{"epsilon": 0.1}', Published(-135, -168)),
    Trait("personal impression", '{"impression": 0.04}', Published(-164, -241)),
    Trait("hierarchy", '{"max_depth": 0}', Published(-112, -251)),
)

SIZES: Mapping[str, str] = {CARTPOLE: "680 KB", PENDULUM: "about 4 MB"}
"""Of the final option set, in the text."""

TITLES: Mapping[Learner, str] = {
    Preset.PAPER: "AO2 paper",
    Preset.ANTICIPATING: "AO2 anticipating",
    Algorithm.DAC_A2C: "DAC+A2C",
    Algorithm.PPOC: "PPOC",
    Algorithm.DAC_PPO: "DAC+PPO",
    Algorithm.PPO: "PPO",
    Algorithm.SB3_PPO: "SB3 PPO",
    Algorithm.SB3_SAC: "SB3 SAC",
    Algorithm.SB3_QRDQN: "SB3 QR-DQN",
}
"""In the order of the paper's table, the references last."""
