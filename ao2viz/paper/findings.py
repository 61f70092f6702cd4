"""From what was measured to the report: tables beside the paper's, curves, sizes, every seed."""

import json
import platform
from collections import defaultdict
from collections.abc import Mapping, Sequence
from importlib import metadata

import numpy as np

from ao2viz.baselines.algorithm import Acting
from ao2viz.core.config import Preset
from ao2viz.core.decision import DecideBy
from ao2viz.envs.task import describe, make_env
from ao2viz.experiments.measure import Evaluation
from ao2viz.experiments.plan import Task
from ao2viz.experiments.report import number
from ao2viz.experiments.statistics import Summary, summarise
from ao2viz.explain.words import count
from ao2viz.paper.document import Paragraph, Part, Picture, Section, Table
from ao2viz.paper.figures import EPISODES_A_POINT, curves_drawing, training_drawing, training_points
from ao2viz.paper.phases import find_phases
from ao2viz.paper.plan import FLAT, is_main
from ao2viz.paper.published import (
    AO2_SCORE,
    ENVS,
    PENDULUM,
    SIZES,
    TABLE_II,
    TITLES,
    TRAITS,
    Learner,
)

TITLE = "The paper's experiments, run side by side"
MISSED = "▼"
"""Behind a figure of ours that is below the paper's."""

Along = Mapping[Learner, Sequence[Summary]]
"""Each learner's checkpoints on one task."""

_NONE = "–"
_NOT_YET = "Not run yet."
MAIN_WAYS = (DecideBy.PATH, Acting.GREEDY)
"""How agents decide in the figures that are laid beside the paper's."""
_PHASES = 3
_LIBRARIES = ("ao2viz", "gymnasium", "numba", "numpy", "torch", "stable-baselines3", "sb3-contrib")


def report(evaluations: Sequence[Evaluation], tasks: Sequence[Task], command: str) -> list[Section]:
    """The whole report, of as much as there is.

    Args:
        evaluations: Rows of the table.
        tasks: What was to be run; what else the table holds is left out.
        command: The command line that makes it.
    """
    wanted = {task.run: set(task.schedule.checkpoints) for task in tasks}
    rows = [one for one in evaluations if one.steps in wanted.get(one.run, ())]
    whole = [
        task
        for task in tasks
        if {one.steps for one in rows if one.run == task.run} == set(task.schedule.checkpoints)
    ]
    main = [one for one in rows if is_main(one.run)]
    along = {env: _along(env, main) for env in ENVS}
    return [
        Section("What this is", _about(rows, tasks, whole, command)),
        *(Section(env, _task(env, found, tasks)) for env, found in along.items()),
        Section("Pendulum: the training curve of AO2", _training(main)),
        Section("Behaviour experiments", _behaviour(rows)),
        Section("Sizes of the option sets", _sizes(main)),
        Section("Every seed", _every_seed(along)),
    ]


def _about(
    rows: Sequence[Evaluation], tasks: Sequence[Task], whole: Sequence[Task], command: str
) -> list[Part]:
    made_by = " and ".join(sorted({str(one.made_by) for one in rows})) or "nothing yet"
    episodes = " or ".join(str(n) for n in sorted({len(one.returns) for one in rows})) or _NONE
    seeds = sorted({task.run.seed for task in tasks})
    versions = ", ".join(f"{name} {_version(name)}" for name in _LIBRARIES)
    days = sorted({f"{one.finished_at:%Y-%m-%d}" for one in rows}) or [_NONE]
    dates = " to ".join(dict.fromkeys([days[0], days[-1]]))
    missing = "" if len(whole) == len(tasks) else "; what is missing is missing below as well"
    return [
        Paragraph(
            "Table II of the paper, its learning curves, its pendulum experiments and its option "
            "sets, run anew by this command, which goes on where it was stopped:"
        ),
        Paragraph(command, is_code=True),
        Paragraph(
            f"{len(whole)} of {len(tasks)} runs are done{missing}. Measured with {made_by}, "
            f"{dates}, seeds from {seeds[0]} on, which no setting was "
            f"chosen by. This report was written with Python {platform.python_version()}, "
            f"{versions}."
        ),
        Paragraph(
            f"Average: the mean over seeds of the mean return of {episodes} episodes, played by "
            f"the agent at the end of training, on starts that no training draws and that all "
            f"share. Best: that of the best seed. (The paper does not say what its best is.) Never "
            f"the best checkpoint. AO2 decides by one path, networks act greedily; beside it the "
            f"other way, AO2's vote and networks that draw. IQM: interquartile mean over seeds, "
            f"with its 95 % bootstrap interval. {MISSED} marks what is below the paper's figure. "
            f"Size: options of AO2, parameters of a network. CPU s: of learning, mean over seeds, "
            f"the environment included, on a shared machine."
        ),
        Paragraph(
            "PPO, PPOC and the double actor-critics are written here after their papers, so all "
            "of this is our re-run, not the authors'; the SB3 rows are the libraries' own, with "
            "the settings of rl-baselines3-zoo. What was tried before stands in baselines.md."
        ),
    ]


def _task(env: str, along: Along, tasks: Sequence[Task]) -> list[Part]:
    parts: list[Part] = []
    if curves := [
        (learner, [s for s in found if s.decide_by in MAIN_WAYS])
        for learner, found in along.items()
    ]:
        caption = f"{env}: mean return at each checkpoint, mean over seeds"
        parts.append(Picture(f"curves-{env}", caption, curves_drawing(env, curves)))
    parts.append(
        Table(
            [
                "learner", "paper: best", "ours: best", "paper: average", "ours: average",
                "IQM [95 %]", "vote or drawn", "seeds", "steps", "size", "CPU s",
                f"steps to {number(AO2_SCORE[env])}, the paper's AO2 (seeds)",
            ],
            [
                _cells(learner, env, along.get(learner, []), tasks)
                for learner in TITLES
                if any(task.run.env == env and task.run.preset is learner for task in tasks)
            ],
        )
    )  # fmt: skip
    return parts


def _cells(
    learner: Learner, env: str, found: Sequence[Summary], tasks: Sequence[Task]
) -> list[str]:
    published = TABLE_II.get(learner, {}).get(env)
    wanted = sum(
        task.run.env == env and task.run.preset is learner and is_main(task.run) for task in tasks
    )
    told = (_NONE, _NONE) if published is None else (_say(published.best), _say(published.average))
    steps = [one.steps for one in found]
    last = {one.decide_by: one for one in found if one.steps == max(steps)}
    one = next((last[way] for way in MAIN_WAYS if way in last), None)
    if one is None:
        return [TITLES[learner], told[0], _NONE, told[1], *[_NONE] * 3, f"0 of {wanted}", *[""] * 4]
    best, average = float(one.means.max()), float(one.means.mean())
    other = next((number(s.means.mean()) for way, s in last.items() if way not in MAIN_WAYS), _NONE)
    interval = "" if one.interval is None else " [{}, {}]".format(*map(number, one.interval))
    return [
        TITLES[learner],
        told[0],
        _marked(best, None if published is None else published.best),
        told[1],
        _marked(average, None if published is None else published.average),
        f"{number(one.iqm)}{interval}",
        other,
        f"{len(one.evaluations)} of {wanted}",
        f"{one.steps:,}",
        f"{one.options:,.0f}",
        f"{one.cpu_s:,.0f}",
        _reached([s for s in found if s.decide_by in MAIN_WAYS], AO2_SCORE[env]),
    ]


def _reached(along: Sequence[Summary], score: float) -> str:
    """The first checkpoint at which each seed was there, the median, and how many ever were."""
    firsts: dict[int, int] = {}
    seeds = {each.run.seed for one in along for each in one.evaluations}
    for one in sorted(along, key=lambda one: one.steps):
        for each in one.evaluations:
            if each.mean_return >= score:
                firsts.setdefault(each.run.seed, one.steps)
    if not firsts:
        return f"none (0 of {len(seeds)})"
    middle = int(np.median(list(firsts.values())))
    return f"{middle:,} ({len(firsts)} of {len(seeds)})"


def _training(main: Sequence[Evaluation]) -> list[Part]:
    by_seed: dict[int, list[Evaluation]] = defaultdict(list)
    for one in main:
        if one.run.env == PENDULUM and one.run.preset is Preset.PAPER and one.episode_ends:
            by_seed[one.run.seed].append(one)
    points = [training_points(rows) for _, rows in sorted(by_seed.items())]
    length = min((len(steps) for steps, _ in points), default=0)
    if length < _PHASES:
        return [Paragraph(_NOT_YET)]
    points = [(steps[:length], returns[:length]) for steps, returns in points]
    steps = points[0][0]
    phases = find_phases(np.mean([returns for _, returns in points], axis=0), _PHASES)
    levels = ", ".join(
        f"{number(phase.level)} up to {steps[phase.past - 1]:,.0f} steps" for phase in phases
    )
    caption = (
        f"AO2 paper on Pendulum while it learns: mean return of {EPISODES_A_POINT} episodes of 200 "
        f"steps, {count(len(points), 'seed')} and their mean"
    )
    return [
        Paragraph(
            "The paper shows the mean reward of every 200 steps and sees two jumps that separate "
            "three phases. Dividing the mean of our seeds into the three stretches that fit it "
            f"best (least squares, exactly) gives the levels {levels}. Three always come out; "
            "whether they are jumps or a slope, the picture tells."
        ),
        Picture("training-Pendulum", caption, training_drawing(points)),
    ]


def _behaviour(rows: Sequence[Evaluation]) -> list[Part]:
    by_settings: dict[str, list[Evaluation]] = defaultdict(list)
    for one in rows:
        if not is_main(one.run) and one.decide_by is DecideBy.PATH:
            by_settings[one.run.settings].append(one)
    described = [
        *((trait.name, trait.settings, trait.published) for trait in TRAITS),
        ("no hierarchy: flat", FLAT, None),
    ]
    cells = []
    for name, settings, published in described:
        found = [one.mean_return for one in by_settings.get(settings, [])]
        told = (
            [_NONE, _NONE] if published is None else [_say(published.best), _say(published.average)]
        )
        ours = [_NONE, _NONE]
        if found:
            ours = [
                _marked(max(found), None if published is None else published.best),
                _marked(float(np.mean(found)), None if published is None else published.average),
            ]
        set_to = ", ".join(f"{key} {value}" for key, value in json.loads(settings).items())
        cells.append([name, set_to, told[0], ours[0], told[1], ours[1], f"{len(found)}"])
    trained = {one.steps for found in by_settings.values() for one in found}
    steps = f", {max(trained):,} steps" if trained else ""
    return [
        Paragraph(
            f"On Pendulum, the paper preset, by one path{steps}. The hierarchy is how this preset "
            f"grows anyway, so its row is the preset as it is; the flat one is what it compares "
            f"with. More, over both presets, stands in behaviour.md."
        ),
        Table(
            ["trait", "settings", "paper: best", "ours: best", "paper: average", "ours: average",
             "seeds"],
            cells,
        ),
    ]  # fmt: skip


def _sizes(main: Sequence[Evaluation]) -> list[Part]:
    cells = []
    for env in ENVS:
        spec = describe(make_env(env))
        each = 8 * (spec.n_features + spec.n_actions)
        for preset in Preset:
            found = [
                one
                for one in main
                if one.run.env == env
                and one.run.preset is preset
                and one.decide_by is DecideBy.PATH
            ]
            last = max((one.steps for one in found), default=0)
            options = [one.options for one in found if one.steps == last]
            if options:
                mean = float(np.mean(options))
                cells.append(
                    [env, TITLES[preset], SIZES.get(env, _NONE), f"{mean:,.0f}",
                     f"{mean * each / 1024:,.0f} KB", f"{last:,}"]
                )  # fmt: skip
    if not cells:
        return [Paragraph(_NOT_YET)]
    return [
        Paragraph(
            "The paper gives the sizes of two option sets in bytes and no number of options. Ours: "
            "options, mean over seeds, and what their values and weights take as 8-byte numbers."
        ),
        Table(["task", "preset", "paper", "options", "values and weights", "steps"], cells),
    ]


def _every_seed(tasks: Mapping[str, Along]) -> list[Part]:
    rows = []
    for env, along in tasks.items():
        for learner, found in along.items():
            last = max(one.steps for one in found)
            ways = {one.decide_by: one for one in found if one.steps == last}
            other = {
                each.run.seed: each
                for way, one in ways.items()
                if way not in MAIN_WAYS
                for each in one.evaluations
            }
            for way in MAIN_WAYS:
                for each in ways[way].evaluations if way in ways else ():
                    beside = other.get(each.run.seed)
                    rows.append(
                        [
                            env,
                            TITLES[learner],
                            f"{each.run.seed}",
                            f"{each.steps:,}",
                            _with_error(each),
                            _NONE if beside is None else _with_error(beside),
                            f"{each.options:,}",
                            f"{each.cpu_s:,.1f}",
                        ]
                    )
    if not rows:
        return [Paragraph(_NOT_YET)]
    return [
        Table(
            ["task", "learner", "seed", "steps", "by one path or greedy", "by vote or drawn",
             "size", "CPU s"],
            rows,
        )
    ]  # fmt: skip


def _along(env: str, main: Sequence[Evaluation]) -> Along:
    """Each learner's checkpoints, in the order of the paper's table."""
    found = summarise(one for one in main if one.run.env == env)
    by: Along = {learner: [one for one in found if one.preset is learner] for learner in TITLES}
    return {learner: summaries for learner, summaries in by.items() if summaries}


def _with_error(one: Evaluation) -> str:
    error = one.standard_error
    return number(one.mean_return) + ("" if error is None else f" ± {error:.1f}")


def _say(value: float) -> str:
    return f"{value:g}".replace("-", "−")


def _marked(value: float, published: float | None) -> str:
    missed = published is not None and round(value, 1) < round(published, 1)
    return f"{number(value)} {MISSED}" if missed else number(value)


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "none"
