"""The right dock, below: what can leave the page as a file."""

from functools import partial

import viser

from ao2viz.explain.words import capitalised, percent
from ao2viz.exports.formats import ABOUT, PURPOSES, Format, Scope
from ao2viz.ui import html
from ao2viz.ui.commands import Command
from ao2viz.ui.downloads import SaveFile
from ao2viz.ui.exporting import SUBJECT, Export
from ao2viz.ui.inbox import Inbox, on_change, on_press, on_trigger
from ao2viz.ui.jobs import Jobs, JobState
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.questions import CallOff, ChooseFormat, ChooseScope, Task
from ao2viz.ui.questions import Export as ExportNow
from ao2viz.ui.view import View

_END: str = "End"
_START: str = "Export"


class ExportPanel:
    """What one browser takes away."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._handed: SaveFile | None = None
        put = partial(on_change, client_id=client_id, inbox=inbox)
        self._purpose = gui.add_dropdown("For", tuple(PURPOSES))
        put(self._purpose, lambda purpose: ChooseFormat(PURPOSES[purpose][0]))
        self._purpose_shown = Mirror(self._purpose)
        first = next(iter(PURPOSES.values()))
        self._format = gui.add_dropdown("Format", tuple(kind.value for kind in first))
        put(self._format, lambda name: ChooseFormat(Format(name)))
        self._format_shown = Mirror(self._format)
        self._scope = gui.add_dropdown("What", tuple(scope.value for scope in Scope))
        put(self._scope, lambda words: ChooseScope(Scope(words)))
        self._scope_shown = Mirror(self._scope)
        self._words = gui.add_html("")
        self._button = gui.add_button(_START, icon=viser.Icon.DOWNLOAD, color="gray")
        on_press(self._button, self._export_or_end, client_id, inbox)
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._state = gui.add_html("")
        trigger = gui.add_command("Export: write what is chosen", hotkey="6")
        on_trigger(trigger, ExportNow(), client_id, inbox)
        trigger = gui.add_command("Export: end it")
        on_trigger(trigger, CallOff(Task.EXPORT), client_id, inbox)

    def sync(self, view: View, jobs: Jobs) -> SaveFile | None:
        """Shows what is chosen and how far it is; gives a file that has just been finished."""
        chosen = view.export
        purpose = next(words for words, kinds in PURPOSES.items() if chosen.format in kinds)
        self._purpose_shown.show(purpose)
        names = tuple(kind.value for kind in PURPOSES[purpose])
        self._format_shown.show_among(names, chosen.format.value)
        scopes = tuple(scope.value for scope in chosen.scopes)
        self._scope_shown.show_among(scopes, chosen.scope.value)
        self._words.content = _about(chosen)
        job = jobs.look(Task.EXPORT, SUBJECT)
        is_busy = job is not None and not job.is_done
        label = _END if is_busy else _START
        if self._button.label != label:
            self._button.label = label
            self._button.icon = viser.Icon.PLAYER_STOP if is_busy else viser.Icon.DOWNLOAD
        self._button.disabled = bool(chosen.problem) and not is_busy
        share = job.latest if job is not None and isinstance(job.latest, float) else 0.0
        self._bar.visible = is_busy
        self._bar.value = 100.0 * min(1.0, max(0.0, share))
        self._state.content = _told(job, share)
        done = job.latest if job is not None and job.is_done else None
        if isinstance(done, SaveFile) and done is not self._handed:
            self._handed = done
            return done
        return None

    def _export_or_end(self) -> Command:
        return CallOff(Task.EXPORT) if self._button.label == _END else ExportNow()


def _about(chosen: Export) -> str:
    about = ABOUT[chosen.format]
    name = f"a {about.suffix} file" if about.suffix else "a folder, in a .zip"
    text = f"{capitalised(about.holds)}; {name}."
    if about.libraries:
        text += f" Needs {', '.join(about.libraries)} (pip install 'ao2viz[exports]')."
    problem = f'<p class="ao-warn">{html.esc(chosen.problem)}</p>' if chosen.problem else ""
    return f'<div class="ao"><p class="ao-dim">{html.esc(text)}</p>{problem}</div>'


def _told(job: JobState | None, share: float) -> str:
    if job is None:
        return ""
    if not job.is_done:
        words, kind = f"Writing, {percent(share)}, {job.seconds:.0f} s …", "ao-dim"
    elif isinstance(job.latest, SaveFile):
        size = len(job.latest.content)
        words, kind = f"{job.latest.name} was handed to your browser: {size:,} bytes.", "ao-dim"
    else:
        words, kind = job.error, "ao-error"
    return f'<div class="ao"><p class="{kind}" role="status">{html.esc(words)}</p></div>'
