"""Numbers, values and names as people read them; plain text, not HTML."""

import numpy as np
from numpy.typing import NDArray

from ao2viz.envs.catalogue import Feature
from ao2viz.envs.task import TaskSpec
from ao2viz.recording.episode import Episode


def number(value: float, digits: int = 3) -> str:
    """A number with a real minus sign and about so many significant digits."""
    if not np.isfinite(value):
        return "unknown" if np.isnan(value) else ("∞" if value > 0 else "−∞")
    if value != 0 and (abs(value) < 1e-4 or abs(value) >= 1e6):
        text = f"{value:.{digits - 1}e}"
    else:
        rounded = float(f"{value:.{digits - 1}e}")  # 0.9999 has the decimals of 1.00.
        size = int(np.floor(np.log10(abs(rounded)))) if value else 0
        text = f"{value:.{max(0, min(6, digits - 1 - size))}f}"
    return "0" if float(text) == 0 and value == 0 else text.replace("-", "−")


def signed(value: float) -> str:
    """A number that is added: "+1.50", "−0.200"."""
    return number(value) if value < 0 else f"+{number(value)}"


def told_apart(*values: float, digits: int = 3) -> list[str]:
    """Numbers to be compared, with enough digits to tell them apart where they differ."""
    for enough in range(digits, 13):
        texts = [number(value, enough) for value in values]
        if len(set(texts)) == len(set(values)):
            return texts
    return [f"{value!r}".replace("-", "−") for value in values]


def amount(value: float, feature: Feature) -> str:
    """A feature's value in the unit it is shown in: "−3.1°", "0.12 m/s"."""
    text = number(value * feature.scale)
    if not feature.unit:
        return text
    return f"{text}{feature.unit}" if feature.unit.startswith("°") else f"{text} {feature.unit}"


def amounts(observation: NDArray[np.float64], spec: TaskSpec) -> list[str]:
    """Every feature of an observation or of an option's value, [D]."""
    return [amount(float(v), f) for v, f in zip(observation, spec.features, strict=True)]


def percent(share: float) -> str:
    """A share as a whole percentage; "under 1 %" instead of a zero that is none."""
    if share > 0 and round(100 * share) == 0:
        return "under 1 %"
    return f"{100 * share:.0f} %"


def count(n: int, noun: str) -> str:
    """As in "1 step", "2 steps", "12,000 steps"."""
    return f"{n:,} {noun}" if n == 1 else f"{n:,} {noun}s"


def say_outcome(episode: Episode) -> str:
    """How an episode went, in words."""
    ending = "still under way"
    if episode.terminated:
        ending = "ended by the task"
    elif episode.truncated:
        ending = "cut off by the time limit"
    earned = f"{episode.total_reward:.6g}".replace("-", "−")
    return f"return {earned} in {len(episode):,} steps, {ending}"


def capitalised(text: str) -> str:
    """A sentence's first letter as a capital, the rest as it is."""
    return text[:1].upper() + text[1:]
