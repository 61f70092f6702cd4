"""The names of the compared algorithms; knows nothing of what they are made of."""

from enum import Enum


class Algorithm(Enum):
    """Who AO2 is compared with."""

    PPO = "ppo"
    """Proximal policy optimisation, ours: the case of one option (Schulman et al. 2017)."""
    PPOC = "ppoc"
    """Proximal policy option-critic, ours (Klissarov et al. 2017; Bacon et al. 2017)."""
    DAC_A2C = "dac+a2c"
    """Double actor-critic with advantage actor-critics, ours (Zhang and Whiteson 2019)."""
    DAC_PPO = "dac+ppo"
    """Double actor-critic with PPO, ours (Zhang and Whiteson 2019)."""
    SB3_PPO = "sb3-ppo"
    """PPO of stable-baselines3, with the settings of rl-baselines3-zoo."""
    SB3_SAC = "sb3-sac"
    """Soft actor-critic of stable-baselines3; continuous actions only."""
    SB3_QRDQN = "sb3-qrdqn"
    """Quantile regression DQN of sb3-contrib; discrete actions only."""

    @property
    def is_reference(self) -> bool:
        """Whether others have written it, and we only call it."""
        return self in (Algorithm.SB3_PPO, Algorithm.SB3_SAC, Algorithm.SB3_QRDQN)


class Acting(Enum):
    """How a stochastic policy is asked."""

    GREEDY = "greedy"
    """The most probable option and action, or the mean action."""
    SAMPLED = "sampled"
    """Drawn, as while it learns."""


def to_algorithm(name: Algorithm | str) -> Algorithm:
    """The algorithm of that name.

    Raises:
        ValueError: If there is none; says which there are.
    """
    try:
        return Algorithm(name)
    except ValueError:
        names = ", ".join(one.value for one in Algorithm)
        raise ValueError(f"Expected one of {names}, but got {name!r}.") from None
