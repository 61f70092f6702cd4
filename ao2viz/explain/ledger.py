"""Where a weight of the `paper` preset comes from: every reward in it, by episode and step."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.ledger import Ledger
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.words import capitalised, count, number, signed


@dataclass(frozen=True)
class Entry:
    """One reward's part in a weight: portion = coefficient · gamma^delay · reward."""

    episode: int  # Of the training, counted from 0.
    step: int  # Of the agent's life in which the action was taken, the first being 1.
    delay: int  # Steps from there to the reward.
    reward: float
    portion: float


@dataclass(frozen=True)
class Account:
    """The ledger of one weight, closed."""

    option: int
    action: int
    weight: float
    movements: int  # How often something moved it.
    entries: tuple[Entry, ...]  # In the order in which they came.
    expected: float  # What was expected after the rewards, where credit bootstraps.
    is_exact: bool  # The movements, made again, give the weight to the bit.
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.

    def by_episode(self) -> dict[int, float]:
        """What each training episode contributed, the most important first."""
        sums: dict[int, float] = {}
        for entry in self.entries:
            sums[entry.episode] = sums.get(entry.episode, 0.0) + entry.portion
        return dict(sorted(sums.items(), key=lambda item: -abs(item[1])))


def close_ledger(ledger: Ledger, weight: float, history: NDArray[np.float64]) -> Account:
    """The account of a ledger.

    Args:
        ledger: Kept while the agent was learned again.
        weight: As the agent has it.
        history: [E, 4] its training history, by which steps are known to belong to episodes.
    """
    entries, expected = [], 0.0
    for movement, (portions, after) in zip(ledger.movements, ledger.portions(), strict=True):
        # Episode n holds the steps after the end of n − 1, up to its own end.
        episode = int(np.searchsorted(history[:, 0], movement.first_step))
        entries += [
            Entry(episode, movement.first_step, int(delay), float(reward), float(portion))
            for delay, reward, portion in zip(
                movement.delays, movement.rewards, portions, strict=True
            )
        ]
        expected += after
    return Account(
        option=ledger.option,
        action=ledger.action,
        weight=weight,
        movements=len(ledger.movements),
        entries=tuple(entries),
        expected=float(expected),
        is_exact=ledger.replay() == weight,
    )


def tell_account(account: Account, spec: TaskSpec) -> tuple[str, ...]:
    """The explanation in sentences: the sum, then the episodes that count the most."""
    name = spec.action_names[account.action]
    head = f"Option {account.option} expects {number(account.weight)} of {name}: the sum of "
    head += f"{count(len(account.entries), 'reward')} in {count(account.movements, 'movement')}"
    if account.expected:
        head += f", and {number(account.expected)} that was expected after them"
    lines = [f"{head}."]
    episodes = account.by_episode()
    for episode, portion in list(episodes.items())[:10]:
        own = [entry for entry in account.entries if entry.episode == episode]
        most = max(own, key=lambda entry: abs(entry.portion))
        lines.append(
            f"{capitalised('training episode')} {episode}: {signed(portion)} in "
            f"{count(len(own), 'reward')}, the most of it {signed(most.portion)} from "
            f"{number(most.reward)} that came {count(most.delay, 'step')} after step {most.step:,}."
        )
    if len(episodes) > 10:
        rest = sum(list(episodes.values())[10:])
        lines.append(f"{count(len(episodes) - 10, 'further episode')}: {signed(rest)}.")
    if not account.is_exact:
        lines.append("The movements do not give the weight to the bit; something else moved it.")
    return tuple(lines)
