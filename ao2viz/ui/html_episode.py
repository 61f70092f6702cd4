"""The margin and the reward along an episode, as HTML; escaping as in `html`."""

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.config import Config
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.moments import MomentKind, course_of
from ao2viz.explain.words import count, number
from ao2viz.figures.palette import DARK, LIGHT, to_css
from ao2viz.recording.episode import Episode
from ao2viz.ui.html import esc

_COLORS = [to_css(*both) for both in zip(DARK.actions, LIGHT.actions, strict=True)]
CHART_PX = 150
"""Height of the chart; the cursor is as tall."""

_WIDTH = 300.0  # Units across; steps that share one are drawn as their extremes.
_TOP, _MARGIN_END, _REWARD_TOP, _REWARD_END = 8.0, 84.0, 100.0, 142.0
_OUTLIERS = 98.0  # Percentile; what is greater stands at the rim.


_BELOW = _MARGIN_END + 6
_MARKS: tuple[tuple[MomentKind, str, str, tuple[float, float], str], ...] = (
    (
        MomentKind.LOW_MARGIN,
        "below",
        to_css(DARK.warn, LIGHT.warn),
        (_MARGIN_END, _MARGIN_END + 5),
        "",
    ),
    (MomentKind.EXPLORED, "above", _COLORS[4], (_TOP - 7, _TOP - 1), "3 2"),
    (MomentKind.CREATED, "below", _COLORS[2], (_BELOW, _BELOW + 5), ""),
    (MomentKind.UNSEEN, "above", to_css(DARK.path, LIGHT.path), (_TOP - 7, _TOP - 1), ""),
    (MomentKind.REWARD_DROP, "at the bottom", _COLORS[5], (_REWARD_END + 1, CHART_PX), ""),
)


def episode_chart(
    episode: Episode | None, spec: TaskSpec | None, config: Config | None = None
) -> str:
    """The chart without its cursor; the same for every step of the episode."""
    if episode is None or spec is None or len(episode) == 0:
        return '<div class="ao"><p class="ao-dim">No episode to show yet.</p></div>'
    course = course_of(episode, config)
    margins = course.margins
    high = float(np.percentile(np.abs(margins), _OUTLIERS)) or 1.0
    low = min(0.0, max(float(margins.min()), -high))
    last = max(1, len(episode))
    lines = [
        _line(np.clip(margins, low, high), (low, high), (_MARGIN_END, _TOP), last, _COLORS[0]),
        _line(
            episode.rewards, _ends(episode.rewards), (_REWARD_END, _REWARD_TOP), last, _COLORS[2]
        ),
        *(
            _ticks(course.flags[kind], last, rows, color, dash)
            for kind, _, color, rows, dash in _MARKS
        ),
    ]
    facts = [
        f"margin: 0 to {number(high)}",
        f"reward: {number(float(episode.rewards.min()))} to {number(float(episode.rewards.max()))}",
    ]
    told = f"Margin and reward of {count(len(episode), 'step')}; {'; '.join(facts)}."
    marks = [
        _tick(f"{kind.value}, {where} ({int(course.flags[kind].sum())})", color)
        for kind, where, color, _, _ in _MARKS
        if course.flags[kind].any()
    ]
    return (
        f'<div class="ao ao-episode"><div class="ao-between">{_tick(facts[0], _COLORS[0])}'
        f'{_tick(facts[1], _COLORS[2])}</div><svg role="img" aria-label="{esc(told)}" viewBox="0 0 '
        f'{_WIDTH:g} {CHART_PX}" preserveAspectRatio="none" height="{CHART_PX}" width="100%">'
        f'<line x1="0" x2="{_WIDTH:g}" y1="{_MARGIN_END:g}" y2="{_MARGIN_END:g}" class="ao-axis"/>'
        f"{''.join(lines)}</svg>{''.join(marks)}</div>"
    )


def episode_cursor(episode: Episode | None, position: int) -> str:
    """A line on the chart that follows, where the step that is shown stands."""
    if episode is None or len(episode) == 0:
        return ""
    at = 100 * min(position, len(episode)) / len(episode)
    line = f'<span class="ao-cursor-line" style="left:{at:.2f}%;height:{CHART_PX}px"></span>'
    return f'<div class="ao ao-cursor">{line}</div>'


def episode_words(episode: Episode | None, position: int) -> str:
    """The numbers of the step that is shown."""
    if episode is None or len(episode) == 0:
        return ""
    words = f"After the last step: return {number(episode.total_reward)}."
    if position < len(episode):
        margin = number(episode.decisions[position].margin)
        reward = number(float(episode.rewards[position]))
        total = number(float(episode.rewards[:position].sum()))
        words = f"Step {position}: margin {margin}, reward {reward}; return so far {total}."
    return f'<div class="ao ao-gaps">{esc(words)}</div>'


def _line(
    values: NDArray[np.float64],
    ends: tuple[float, float],
    rows: tuple[float, float],
    last: int,
    color: str,
) -> str:
    """A line whose low end stands at the first row, in the columns that there are."""
    low, high = ends
    columns = (np.arange(len(values)) * _WIDTH / last).astype(np.int64)
    points = []
    for column in np.unique(columns):
        inside = values[columns == column]
        for value in dict.fromkeys((float(inside.min()), float(inside.max()))):
            share = (value - low) / (high - low) if high > low else 0.5
            points.append(f"{column},{rows[0] + (rows[1] - rows[0]) * share:.1f}")
    if len(points) == 1:
        points.append(points[0].replace(points[0].split(",")[0], f"{_WIDTH:g}", 1))
    return f'<polyline points="{" ".join(points)}" class="ao-line" style="stroke:{color}"/>'


def _ticks(
    where: NDArray[np.bool_], last: int, rows: tuple[float, float], color: str, dash: str
) -> str:
    columns = np.unique((np.flatnonzero(where) * _WIDTH / last).astype(np.int64))
    path = "".join(f"M{column} {rows[0]:g}V{rows[1]:g}" for column in columns)
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    return f'<path d="{path}" class="ao-line" style="stroke:{color}"{dashes}/>' if path else ""


def _tick(words: str, color: str) -> str:
    return (
        f'<span class="ao-gaps ao-tick"><span style="background:{color}"></span>{esc(words)}</span>'
    )


def _ends(values: NDArray[np.float64]) -> tuple[float, float]:
    return float(values.min()), float(values.max())
