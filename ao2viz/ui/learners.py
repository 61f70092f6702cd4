"""Which learners of the paper's comparison are laid behind a run; pure."""

from dataclasses import dataclass, replace

from ao2viz.figures.behind import Behind, Here, here_of
from ao2viz.ui.commands import LayBehind
from ao2viz.ui.session import Session
from ao2viz.ui.watched import history_of, spec_of
from ao2viz.ui.world import World


@dataclass(frozen=True, eq=False)
class Learners:
    """What there is to lay behind, and where the run is beside it."""

    known: tuple[Behind, ...] = ()  # Those of the task that is watched.
    chosen: frozenset[str] = frozenset()  # Names of learners, of other tasks as well.
    env: str = ""  # The task; empty if none is watched.
    envs: tuple[str, ...] = ()  # Tasks that there are curves of.
    here: Here | None = None  # None: no training episode has ended.

    @property
    def laid(self) -> tuple[Behind, ...]:
        """Those that were chosen and are known."""
        return tuple(one for one in self.known if one.learner in self.chosen)


def learners_of(session: Session, world: World) -> Learners:
    """The learners beside what a browser watches."""
    spec = spec_of(session, world)
    env = spec.env_id if spec is not None else ""
    return Learners(
        known=tuple(one for one in world.curves if one.env == env),
        chosen=session.charts.behind,
        env=env,
        envs=tuple(dict.fromkeys(one.env for one in world.curves)),
        here=here_of(history_of(session, world), session.charts.smoothing),
    )


def lay(session: Session, command: LayBehind, world: World) -> Session:
    """The session with a learner laid behind the returns, or all of this task, or taken away."""
    chosen = session.charts.behind
    known = {one.learner for one in learners_of(session, world).known}
    names = known if command.learner is None else {command.learner}
    is_laid = command.is_laid
    if is_laid is None:
        is_laid = not names <= chosen
    chosen = chosen | names if is_laid else chosen - names
    return replace(session, charts=replace(session.charts, behind=chosen))
