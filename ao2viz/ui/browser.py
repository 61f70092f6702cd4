"""Everything on one browser's screen."""

import time

import viser

from ao2viz.core.decision import NO_OPTION, Decision
from ao2viz.explain.ahead import Ahead
from ao2viz.explain.telling import CHECKS
from ao2viz.explain.why import Why
from ao2viz.figures.palette import Theme
from ao2viz.training.states import RunStatus
from ao2viz.ui.asking import ahead_of, decision_then, faithful_of, novelty_of
from ao2viz.ui.camera import Eye
from ao2viz.ui.close_up import CloseUp, Focus
from ao2viz.ui.downloads import Notify, SaveFile
from ao2viz.ui.frames import FrameStore, refit
from ao2viz.ui.gallery import Gallery, PictureKey
from ao2viz.ui.inbox import Inbox, on_canvas_click
from ao2viz.ui.jobs import Jobs
from ao2viz.ui.look import Requests
from ao2viz.ui.overlay import Moment, Overlay, overlay
from ao2viz.ui.panels.branch import BranchPanel
from ao2viz.ui.panels.charts import ChartsPanel
from ao2viz.ui.panels.compare import ComparePanel
from ao2viz.ui.panels.control import ControlPanel
from ao2viz.ui.panels.dialogs import DialogsPanel
from ao2viz.ui.panels.export import ExportPanel
from ao2viz.ui.panels.forest import ForestPanel
from ao2viz.ui.panels.forget import ForgetPanel
from ao2viz.ui.panels.inspect import InspectPanel
from ao2viz.ui.panels.legend import LegendPanel
from ao2viz.ui.panels.moments import MomentsPanel
from ao2viz.ui.panels.page import PagePanel
from ao2viz.ui.panels.past import PastPanel
from ao2viz.ui.panels.watch import WatchPanel
from ao2viz.ui.panels.what_if import WhatIfPanel
from ao2viz.ui.panels.whole import WholePanel
from ao2viz.ui.panels.why import WhyPanel
from ao2viz.ui.picture import Picture
from ao2viz.ui.recall import remember
from ao2viz.ui.rest import Rest
from ao2viz.ui.scene import Canvas
from ao2viz.ui.session import Session
from ao2viz.ui.stage import Stage, set_theme
from ao2viz.ui.staging import at_stage
from ao2viz.ui.supposing import Answer, Supposing
from ao2viz.ui.thinker import Thinker
from ao2viz.ui.view import View
from ao2viz.ui.world import World

_WHY_CHECKS = (*CHECKS[Why], *CHECKS[Ahead])
_PATIENCE_S = 1.5  # Longer than a browser takes to tell what it remembers.


class Browser:
    """The panels and the canvas of one browser. Only the app loop may call it."""

    def __init__(self, client: viser.ClientHandle, stage: Stage, inbox: Inbox) -> None:
        self._client = client
        gui, me = client.gui, client.client_id
        self.picture_key: PictureKey | None = None
        self._picture: Picture | None = None
        self._focus = Focus()
        self._close_up: CloseUp | None = None
        self._overlay: tuple[tuple[object, ...], Overlay | None] = ((), None)
        self._raw_frame: bytes | None = None
        self._then: Decision | None = None  # What a past agent would decide.
        self._theme = Theme.DARK
        self._came_at = time.monotonic()
        with client.atomic():
            self._control = ControlPanel(gui, me, inbox)
            with stage.watch:
                self._watch = WatchPanel(gui, me, inbox)
            with stage.why:
                self._why = WhyPanel(gui)
            with stage.moments:
                self._moments = MomentsPanel(gui, me, inbox)
            with stage.branch:
                self._branch = BranchPanel(gui, me, inbox)
            with stage.past:
                self._past = PastPanel(gui, me, inbox)
            with stage.inspect:
                self._inspect = InspectPanel(gui, me, inbox)
            with stage.agent:
                self._whole = WholePanel(gui, me, inbox)
            with stage.forest:
                self._forest = ForestPanel(gui, me, inbox)
            with stage.charts:
                self._charts = ChartsPanel(gui, me, inbox)
            with stage.what_if:
                self._what_if = WhatIfPanel(gui, me, inbox)
                self._forget = ForgetPanel(gui, me, inbox)
            with stage.compare:
                self._compare = ComparePanel(gui, me, inbox)
            with stage.export:
                self._export = ExportPanel(gui, me, inbox)
            self._legend = LegendPanel(gui, me, inbox)
            self._dialogs = DialogsPanel(gui, me, inbox)
            self._page = PagePanel(gui, me, inbox)
        self._supposing = Supposing()
        self.jobs = Jobs()
        self.rest = Rest()
        self._is_waiting = False  # For an answer or a picture that is on its way.
        self._canvas = Canvas(client)
        self._eye = Eye(client.camera)
        on_canvas_click(client.scene, me, inbox)

    def needs_sync(self, session: Session, world: World, now: float) -> bool:
        """Whether what it shows may have changed since the last `sync`; `now` in seconds."""
        camera = self._client.camera.update_timestamp
        return self.rest.is_over(session, world, camera, is_waiting=self._is_waiting, now=now)

    def sync(self, view: View, gallery: Gallery, frames: FrameStore, thinker: Thinker) -> None:
        """Brings the screen up to date with the view."""
        self._page.sync(view)
        theme = view.appearance.shown_theme
        if theme is not self._theme:
            self._theme = theme
            set_theme(self._client.gui, theme)
            self._canvas.set_palette(theme.palette)
            self._raw_frame = None
        # Nothing big is made in one theme and at once again in another.
        waited = time.monotonic() - self._came_at > _PATIENCE_S
        is_ready = view.appearance.is_known or waited
        frame, problem = self._frame(view, frames) if is_ready else (None, "")
        # A mind as big as its forest takes long to make; what is seen comes before what is thought.
        may_ask = view.forest is None or self._picture is not None
        ahead = ahead_of(view, thinker) if may_ask else None
        asked = self._supposing.ask(view, thinker) if may_ask else None
        answer = asked if isinstance(asked, Answer) else None
        self._then = decision_then(view, thinker) if may_ask else None
        # The canvas comes first: what it is sent arrives before all the words beside it.
        self._sync_canvas(view, gallery, ahead, answer, is_ready=is_ready)
        self._what_if.sync(view, asked, self.jobs)
        self._forget.sync(view, self.jobs)
        self._compare.sync(view, thinker, frames, self.jobs)
        file = self._export.sync(view, self.jobs)
        if file is not None:
            self.hand_over(file)
        self._watch.sync(view, frame)
        faithful = faithful_of(view, thinker, _WHY_CHECKS) if may_ask else None
        novelty = novelty_of(view, thinker) if may_ask else None
        self._why.sync(view, problem, ahead, faithful, novelty)
        self._moments.sync(view)
        self._branch.sync(view)
        self._past.sync(view, self._then)
        self._control.sync(view)
        self._inspect.sync(view, thinker, self.jobs)
        self._whole.sync(view, self.jobs)
        self._forest.sync(view)
        self._charts.sync(view)
        self._dialogs.sync(view)
        work = (gallery, frames, thinker, self.jobs, self._canvas)
        self._is_waiting = not is_ready or any(each.is_busy for each in work)

    def _sync_canvas(
        self,
        view: View,
        gallery: Gallery,
        ahead: Ahead | None,
        answer: Answer | None,
        *,
        is_ready: bool,
    ) -> None:
        picture, picture_key = None, None
        if is_ready and view.forest is not None and view.spec is not None:
            key, back = view.forest_key, view.back
            if back is not None:
                key = (f"past {key[0]}", *key[1:])
                forest = back.moment.view
                picture = gallery.get_past(key, back.past, forest, view.spec, view.look)
            else:
                picture = gallery.get(key, view.forest, view.spec, view.look)
            picture_key = (key, view.look)
        self._picture, self.picture_key = picture, picture_key
        if not is_ready:
            return
        lens = self._eye.look()
        drawn, decision = self._overlay_of(view, ahead, answer)
        self._close_up = self._focus.get(
            self._picture,
            (view.selected, *([] if decision is None else decision.path[-1:].tolist())),
            is_moving=_is_moving(view),
        )
        self._canvas.sync(self._picture, drawn, lens, self._close_up)
        self._legend.sync(view, self._picture, self._close_up)
        requests = Requests(view.fits, view.focuses, view.selection_focuses)
        self._canvas.aim(requests, self._legend.size, lens)

    def pick(self, origin: tuple[float, ...], direction: tuple[float, ...]) -> int:
        """The option under a click; NO_OPTION if there is none."""
        if self._picture is None:
            return NO_OPTION
        close_up = self._close_up
        beside = close_up.options if close_up is not None else None
        return self._picture.pick(origin, direction, beside)

    def hand_over(self, file: SaveFile) -> None:
        """Lets the browser save a file."""
        self._client.send_file_download(file.name, file.content, save_immediately=True)

    def remember(self, text: str) -> None:
        """Lets the browser keep this for its next visit."""
        remember(self._client, text)

    def notify(self, notice: Notify) -> None:
        """Pops up a message. Viser shows it as text, so it needs no escaping."""
        self._client.add_notification(
            notice.title,
            notice.body,
            color="red" if notice.is_error else "blue",
            auto_close_seconds=None if notice.is_error or notice.stays else 6.0,
        )

    def _frame(self, view: View, frames: FrameStore) -> tuple[bytes | None, str]:
        if view.frame is not None:
            if view.frame is self._raw_frame:
                return None, ""
            self._raw_frame = view.frame
            return refit(view.frame, self._theme), ""
        self._raw_frame = None
        if view.episode is None or view.spec is None:
            return None, ""
        return frames.get(view.episode, view.spec, view.transport.position, self._theme)

    def _overlay_of(
        self, view: View, ahead: Ahead | None, answer: Answer | None
    ) -> tuple[Overlay | None, Decision | None]:
        """What lies over the forest, and the decision that it shows."""
        moment = Moment(view.decision, view.selected, view.seen, ahead)
        forest = view.forest
        if view.back is not None:
            forest = view.back.moment.view
            moment = Moment(self._then, view.selected, view.seen)
        elif answer is not None and answer.is_supposed:
            way = answer.ahead if isinstance(answer.ahead, Ahead) else None
            seen = answer.state[None]
            moment = Moment(answer.decision, view.selected, seen, way, is_supposed=True)
        walk = None if moment.is_supposed or view.back is not None else view.walk
        inputs = (
            self._picture,
            moment.decision,
            view.selected,
            view.transport.position,
            moment.ahead,
            answer.state if moment.is_supposed and answer is not None else None,
            *((None, None) if walk is None else (walk.cycle, walk.stage)),
        )
        if len(self._overlay[0]) == len(inputs) and all(
            a is b or (isinstance(a, int) and a == b)
            for a, b in zip(inputs, self._overlay[0], strict=True)
        ):
            return self._overlay[1], moment.decision
        drawn = None
        if self._picture is not None and view.spec is not None and forest is not None:
            drawn = overlay(moment, self._picture, forest, view.spec)
            if walk is not None:
                drawn = at_stage(drawn, walk, self._picture)
        self._overlay = (inputs, drawn)
        return drawn, moment.decision


def _is_moving(view: View) -> bool:
    """Whether another decision will be shown in a moment."""
    if view.source is None and view.run.status is RunStatus.RUNNING:
        return True
    return view.transport.is_enabled and view.transport.is_playing
