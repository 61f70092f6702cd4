"""What learning again told, as HTML; escaping as in `html`."""

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.forgetting import Forgotten
from ao2viz.explain.ledger import Account
from ao2viz.explain.telling import tell
from ao2viz.explain.words import count, percent
from ao2viz.ui.html import esc, notice
from ao2viz.ui.jobs import JobState

_SHOWN_STATES = 1  # The changed states stand below as buttons.


def heading(n_episodes: int, problem: str) -> str:
    """What forgetting an episode is, or why there is none to forget."""
    if problem:
        return notice(problem)
    return (
        '<div class="ao"><h4>Had it never learned from an episode</h4><p class="ao-dim">Learns the '
        "agent again twice, as it was and without that episode, and asks both at every recorded "
        f"state. It takes twice as long as learning did. {count(n_episodes, 'training episode')}, "
        "counted from 0.</p></div>"
    )


def forgotten(job: JobState | None, spec: TaskSpec) -> str:
    """How far forgetting has come, and what came out."""
    if job is not None and isinstance(job.latest, Forgotten):
        lines = tell(job.latest, spec)
        return _told([*lines[:_SHOWN_STATES], lines[-1]])
    return _under_way(job)


def account(job: JobState | None, spec: TaskSpec) -> str:
    """How far a ledger has come, and every episode that counts in it."""
    if job is not None and isinstance(job.latest, Account):
        return _told(tell(job.latest, spec))
    return _under_way(job)


def _told(lines: list[str] | tuple[str, ...]) -> str:
    *said, faithful = [esc(line) for line in lines]
    told = "".join(f"<p>{line}</p>" for line in said)
    return f'<div class="ao" role="status">{told}<p class="ao-dim">{faithful}</p></div>'


def _under_way(job: JobState | None) -> str:
    if job is None:
        return ""
    if job.is_done:
        return f'<div class="ao"><p class="ao-error" role="status">{esc(job.error)}</p></div>'
    return (
        f'<div class="ao"><p class="ao-dim" role="status">Learning again, '
        f"{percent(share_of(job))}, {job.seconds:.0f} s …</p></div>"
    )


def share_of(job: JobState | None) -> float:
    """The share of the learning that is done."""
    return job.latest if job is not None and isinstance(job.latest, float) else 0.0
