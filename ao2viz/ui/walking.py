"""Walking through the stages of a single step, in one browser; pure.

The run takes the step as a whole, so it stays the same to the bit. What is walked through is what
the step turned out to be.
"""

from dataclasses import dataclass, replace

from ao2viz.recording.cycle import Cycle, Stage
from ao2viz.training.states import Step, accepts
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.downloads import Notify
from ao2viz.ui.session import Session
from ao2viz.ui.watched import decision_of
from ao2viz.ui.world import World


@dataclass(frozen=True, eq=False)
class Walk:
    """A stage of a step that is shown."""

    cycle: Cycle
    stage: Stage


def walk_of(session: Session, world: World) -> Walk | None:
    """The stage that is shown; None while no step is walked through, or another is looked at."""
    cycle = world.update.cycle
    if session.source is not None or cycle is None or session.walked != cycle.n_steps:
        return None
    if decision_of(session, world) is not cycle.decision:
        return None
    return Walk(cycle, session.stage)


def walk_on(session: Session, world: World) -> tuple[Session, tuple[Step | Notify, ...]]:
    """The next stage; after the last one, the next step. The session watches the run already."""
    cycle, episode = world.update.cycle, world.update.episode
    if cycle is not None and episode is not None:
        at_step = replace(session, position=float(len(episode) - 1), is_playing=False)
        if session.walked != cycle.n_steps:
            return replace(at_step, walked=cycle.n_steps, stage=Stage.SAMPLE), ()
        if session.stage is not Stage.CLEANSE:
            return replace(at_step, stage=list(Stage)[session.stage.number + 1]), ()
    if not accepts(world.update.status, Step):
        what = f"Only a paused run can be walked through; it is {world.update.status.value}."
        return session, (Notify("Not now", what),)
    return replace(session, waits_for_step=True), (Step(),)


def follow_step(session: Session, before: RunUpdate, now: RunUpdate) -> Session:
    """Begins to walk through the step that was asked for, once it was taken."""
    if not session.waits_for_step or now.cycle is before.cycle or now.cycle is None:
        return session
    return replace(session, waits_for_step=False, walked=now.cycle.n_steps, stage=Stage.SAMPLE)


def can_walk(session: Session, world: World) -> bool:
    """Whether there is a next stage."""
    walk = walk_of(session, world)
    has_stages = walk is not None and walk.stage is not Stage.CLEANSE
    return has_stages or accepts(world.update.status, Step)
