"""Agents and episodes as JSON, for programs; `static/export.schema.json` describes it."""

import json
from typing import IO, Any

from ao2viz.core.config import config_to_dict
from ao2viz.core.decision import Decision, Plan
from ao2viz.explain.plain import to_plain
from ao2viz.exports.content import (
    Content,
    Numbered,
    number_or_none,
    option_or_none,
    path_elements,
)

NAME = "ao2viz-export"
VERSION = 1
"""Of the document. Raised whenever a reader of the version before would misunderstand it."""


def write_json(content: Content, stream: IO[bytes]) -> None:
    """Everything that people read on the screen, in numbers and in words, as one JSON value."""
    document = to_document(content)
    stream.write(json.dumps(document, ensure_ascii=False, allow_nan=False).encode())


def to_document(content: Content) -> dict[str, Any]:
    """The JSON value; numbers that are not finite become null."""
    saved, spec, view = content.saved, content.spec, content.view
    extra: dict[int, list[int]] = {}
    for parent, child in view.links.tolist():
        extra.setdefault(child, []).append(parent)
    total = sum(len(episode) for _, episode in content.episodes)
    return {
        "format": NAME,
        "version": VERSION,
        "agent": {
            "environment": spec.env_id,
            "title": spec.title,
            "preset": saved.preset.value,
            "settings": config_to_dict(saved.config),
            "seed": saved.seed,
            "steps": saved.n_steps,
        },
        "features": [
            {"name": f.name, "unit": f.unit, "scale": f.scale, "attention": attention}
            for f, attention in zip(spec.features, view.attention.tolist(), strict=True)
        ],
        "actions": [
            {
                "name": name,
                "environment_action": spec.action_grid[i].tolist()
                if spec.action_grid is not None
                else i + spec.action_offset,
            }
            for i, name in enumerate(spec.action_names)
        ],
        "options": [
            {
                "id": option,
                "parent": option_or_none(view.parents[option]),
                "further_parents": extra.get(option, []),
                "depth": int(view.depths[option]),
                "born": int(view.born[option]),
                "value": view.values[option].tolist(),
                "weights": view.weights[option].tolist(),
                "visits": view.visits[option].tolist(),
            }
            for option in view.is_alive.nonzero()[0].tolist()
        ],
        "training": [
            {"end_step": int(end), "return": total, "steps": int(steps), "options": int(options)}
            for end, total, steps, options in saved.history.tolist()
        ],
        "faithfulness": to_plain(content.faithfulness),
        "episodes": [_episode(content, numbered, total) for numbered in content.episodes],
    }


def _episode(content: Content, numbered: Numbered, total: int) -> dict[str, Any]:
    number, episode = numbered
    before = sum(len(e) for n, e in content.episodes if n < number)
    steps = []
    for step in content.steps(numbered):
        steps.append(
            {
                "step": step.number,
                "reward": step.reward,
                "headline": step.said.headline,
                "reason": step.said.reason,
                "marks": list(step.said.marks),
                "is_faithful": step.is_faithful,
                "decision": _decision(step.decision),
            }
        )
        content.progress((before + len(steps)) / total)
    return {
        "number": number,
        "seed": episode.seed,
        "return": episode.total_reward,
        "terminated": episode.terminated,
        "truncated": episode.truncated,
        "is_training": episode.is_training,
        "action_smoothing": episode.action_smoothing,
        "started_at": episode.started_at,
        "steps": steps,
        "final_observation": episode.observations[-1].tolist(),
    }


def _decision(decision: Decision) -> dict[str, Any]:
    return {
        "observation": decision.observation.tolist(),
        "action": decision.action,
        "decide_by": decision.decide_by.value,
        "explored": decision.explored,
        "is_tie": decision.is_tie,
        "action_values": decision.action_values.tolist(),
        "margin": decision.margin,
        "voters": [
            {
                "option": int(option),
                "share": float(decision.shares[k]),
                "weights": decision.voter_weights[k].tolist(),
                "path": path_elements(decision, k),
            }
            for k, option in enumerate(decision.voters)
        ],
        "slopes": decision.slopes.tolist(),
        "runner_up_option": option_or_none(decision.runner_up_option),
        "runner_up_distance": number_or_none(decision.runner_up_distance),
        "created_option": option_or_none(decision.created),
        "plan": None if decision.plan is None else _plan(decision.plan),
    }


def _plan(plan: Plan) -> dict[str, Any]:
    return {
        "actions": plan.actions.tolist(),
        "states": plan.states.tolist(),
        "rewards": plan.rewards.tolist(),
        "continues": plan.continues.tolist(),
        "options": plan.options.tolist(),
        "worth": plan.worth,
        "values_without_plan": plan.outlook_values.tolist(),
    }
