"""One option as a page of notes and as JSON."""

import json
from typing import IO

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import unlimited
from ao2viz.explain.agreement import Faithfulness, tell_faithfulness
from ao2viz.explain.faithful import Trials
from ao2viz.explain.option import WholeOption, explain_option
from ao2viz.explain.origin import tell_origin
from ao2viz.explain.plain import to_plain
from ao2viz.explain.telling import CHECKS
from ao2viz.explain.words import amounts, count, number
from ao2viz.exports.content import Content
from ao2viz.exports.escaping import to_markdown
from ao2viz.exports.pages import table

NAME = "ao2viz-option"
VERSION = 1


def write_option(content: Content, stream: IO[bytes]) -> None:
    """What the option stands for, expects, has tried, and the story behind each weight."""
    told, faithful = _ask(content)
    stream.write("\n".join(_page(told, faithful, content)).encode() + b"\n")


def write_option_json(content: Content, stream: IO[bytes]) -> None:
    """The same for programs; fields as of `ao2viz explain FILE option --json`."""
    told, faithful = _ask(content)
    spec = content.spec
    document = {
        "format": NAME,
        "version": VERSION,
        "environment": spec.env_id,
        "features": [{"name": f.name, "unit": f.unit, "scale": f.scale} for f in spec.features],
        "actions": list(spec.action_names),
        "option": to_plain(told) | {"faithfulness": to_plain(faithful)},
    }
    stream.write(json.dumps(document, ensure_ascii=False, allow_nan=False).encode())


def _ask(content: Content) -> tuple[WholeOption, Faithfulness]:
    if content.option == NO_OPTION:
        raise ValueError("Expected an option to write about; name it with --option, option=7.")
    mind = Mind(content.saved.config, content.saved.state)
    told = explain_option(mind, content.option, content.saved.episodes)
    n_features = content.spec.n_features
    trials = Trials(mind, content.spec, content.decisions, lambda: unlimited(n_features))
    return told, trials.on(CHECKS[WholeOption])


def _page(told: WholeOption, faithful: Faithfulness, content: Content) -> list[str]:
    spec = content.spec
    place = f"depth {told.depth}" if told.depth else "a root"
    facts = f"Of {spec.title}; {place}, made at step {told.born:,}."
    values = zip(spec.features, amounts(told.value, spec), strict=True)
    actions = [
        (name, number(float(weight), 5), f"{tried:,}")
        for name, weight, tried in zip(
            spec.action_names, told.weights, told.visits.tolist(), strict=True
        )
    ]
    lines = [f"# Option {told.option}", "", to_markdown(facts), ""]
    lines += table(["feature", "stands for"], [(f.name, shown) for f, shown in values])
    lines += ["", "## What it expects, and has tried", ""]
    lines += table(["action", "expected return", "visits"], actions)
    for origin in told.origins:
        name = to_markdown(spec.action_names[origin.action])
        lines += ["", f"## Why so much for {name}", ""]
        lines += [f"{to_markdown(line)}  " for line in tell_origin(origin, spec)]
    for words, ids in (("Parents", told.parents), ("Children", told.children)):
        lines += ["", f"{words}: {', '.join(map(str, ids)) or 'none'}."]
    lines += ["", f"## Where it had a say: {count(len(told.uses), 'recorded step')}", ""]
    if told.uses:
        uses = [
            (str(u.episode), str(u.step), spec.action_names[u.action], number(u.share))
            for u in told.uses
        ]
        lines += table(["episode", "step", "action", "share of the say"], uses)
    return [*lines, "", to_markdown(tell_faithfulness(faithful))]
