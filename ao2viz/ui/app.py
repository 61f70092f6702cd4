"""The dashboard: one loop that takes commands in and brings the screen up to date."""

import contextlib
import threading
import time
import traceback
import webbrowser
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import viser

from ao2viz import resources
from ao2viz.core.config import Preset
from ao2viz.core.decision import NO_OPTION
from ao2viz.envs.catalogue import CATALOGUE
from ao2viz.exports.learner_curves import read_learner_curves
from ao2viz.figures.behind import Behind
from ao2viz.store.saved import SavedAgent
from ao2viz.training.runner import ProcessRunner, Runner
from ao2viz.training.states import RunCommand, RunStatus, Start
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.appearance import Remember
from ao2viz.ui.branches import Brancher
from ao2viz.ui.browser import Browser
from ao2viz.ui.commands import Select
from ao2viz.ui.copies import Copies, read_agent
from ao2viz.ui.defaults import DefaultsStore
from ao2viz.ui.dialog_commands import Dialog
from ao2viz.ui.downloads import Notify, SaveFile
from ao2viz.ui.frames import FrameStore
from ao2viz.ui.gallery import Gallery
from ao2viz.ui.inbox import Connect, Disconnect, Inbox
from ao2viz.ui.jobs import Begin
from ao2viz.ui.library import Library
from ao2viz.ui.places import open_place
from ao2viz.ui.questions import CallOff
from ao2viz.ui.recall import recall
from ao2viz.ui.reduce import Effect, PickOption, advance, follow, reduce
from ao2viz.ui.security import asked_query, make_server, make_token
from ao2viz.ui.session import Form, Session, Wanted
from ao2viz.ui.shelf import KeepUpload, SendAgent
from ao2viz.ui.stage import Stage
from ao2viz.ui.thinker import Thinker
from ao2viz.ui.view import View, project
from ao2viz.ui.world import World

TICK_S = 0.05
"""So often the screen is brought up to date; what a person does is answered at once."""
_BREATH_S = 0.005  # Between two looks, however much people do: what was sent must get away.

_FIRST = "CartPole-v1"  # Opened when nothing else is asked for.
_RELIST_S = 2.0  # Files that others put on the shelf appear after so long.


class Dashboard:
    """Serves the page until stopped. The app loop is the only writer of viser's handles."""

    def __init__(
        self,
        agent: Path | None = None,
        *,
        host: str = "127.0.0.1",
        port: int = 8080,
        folder: Path | None = None,
        more_folders: tuple[Path, ...] = (),
        shipped: Path | None = None,
        make_runner: Callable[[], Runner] = ProcessRunner,
        env_ids: tuple[str, ...] = tuple(CATALOGUE),
        wanted: Wanted | None = None,
        curves: tuple[Behind, ...] | None = None,
        saved: SavedAgent | None = None,
    ) -> None:
        """Makes a dashboard; nothing listens before `start`.

        Args:
            agent: The file to open; None opens a bundled one.
            host: What to listen on. Anything but this computer gets a token in its address.
            port: 0 takes any that is free; a taken one makes viser take the next.
            folder: Where agents are saved and looked for; None: the working directory.
            more_folders: Further folders that people may choose to save to.
            shipped: The folder of the bundled agents; None: the one that comes with ao2viz.
            make_runner: Makes what trains.
            env_ids: The environments offered by name.
            wanted: The episode and step that a page opens with, unless its address asks for more.
            curves: Learners that can be laid behind a run; None: those of the paper's comparison.
            saved: What `agent` holds, if it has been read; it need not be read again then.
        """
        self._host, self._wanted_port = host, port
        self._token = make_token() if host not in ("127.0.0.1", "localhost", "::1") else None
        self._make_runner = make_runner
        self._folder = folder if folder is not None else Path.cwd()
        extra = agent.resolve() if agent is not None else None
        shipped = shipped or resources.saved_schemas()
        self._library = Library(shipped, self._folder, extra, more_folders)
        if extra is not None and saved is not None:
            self._library.know(extra, saved)
        self._copies = Copies(self._folder)
        self._env_ids = env_ids
        self._wanted = wanted
        self._inbox = Inbox()
        self._frames = FrameStore()
        self._gallery = Gallery()
        self._thinker = Thinker()
        self._defaults = DefaultsStore()
        self._brancher = Brancher()
        self._browsers: dict[int, Browser] = {}
        self._sessions: dict[int, Session] = {}
        folders = tuple(dict.fromkeys((self._folder, *more_folders)))
        if curves is None:
            curves = read_learner_curves(resources.learner_curves())
        self._world = World(folder=self._folder, folders=folders, env_ids=env_ids, curves=curves)
        self._relist_at = 0.0
        self._stopping = threading.Event()
        self._server: viser.ViserServer | None = None
        self._stage: Stage | None = None
        self._runner: Runner | None = None
        self._outdated: RunUpdate | None = None
        self._last_bug = ""
        self._loop: threading.Thread | None = None

    @property
    def port(self) -> int:
        """Where it listens; not always the port that was asked for."""
        if self._server is None:
            raise RuntimeError("The dashboard listens to nothing before start().")
        return self._server.get_port()

    @property
    def address(self) -> str:
        """What to type into a browser, the token included."""
        host = "localhost" if self._host in ("0.0.0.0", "::") else self._host
        token = f"?token={self._token}" if self._token is not None else ""
        return f"http://{host}:{self.port}/{token}"

    @property
    def views(self) -> Mapping[int, View]:
        """What each browser shows, by client id; for tests."""
        return {i: project(session, self._world) for i, session in self._sessions.items()}

    def start(self) -> None:
        """Begins to listen; returns at once."""
        server = self._server = make_server(self._host, self._wanted_port, self._token)
        self._stage = Stage(server)
        self._world = replace(self._world, address=self.address)
        self._loop = threading.Thread(target=self._run, name="app loop", daemon=True)

        @server.on_client_connect
        async def _(client: viser.ClientHandle) -> None:
            self._inbox.put(client.client_id, Connect(asked_query()))

        @server.on_client_disconnect
        async def _(client: viser.ClientHandle) -> None:
            self._inbox.put(client.client_id, Disconnect())

        self._loop.start()

    def stop(self) -> None:
        """Ends everything that `start` began."""
        self._stopping.set()
        if self._loop is not None:
            self._loop.join(timeout=10)
        if self._runner is not None:
            self._runner.close()
        self._frames.close()
        self._gallery.close()
        self._thinker.close()
        for browser in list(self._browsers.values()):
            browser.jobs.close()
        self._defaults.close()
        self._brancher.close()
        self._library.close()
        if self._server is not None:
            with contextlib.redirect_stdout(None):
                self._server.stop()

    def _run(self) -> None:
        self._world = replace(self._world, shelf=self._library.shelf())
        now = then = time.monotonic()
        while not self._stopping.is_set():
            then, now = now, time.monotonic()
            try:
                self._tick(now, now - then)
            except Exception as error:  # The screen must outlive its own bugs, and tell of them.
                self._tell_of_bug(error)
            self._stopping.wait(_BREATH_S)
            self._inbox.wait(TICK_S - (time.monotonic() - now))

    def _tick(self, now: float, seconds: float) -> None:
        self._refresh_world(now)
        for client_id, command in self._inbox.drain():
            if isinstance(command, Connect):
                self._connect(client_id, command.query)
            elif isinstance(command, Disconnect):
                gone = self._browsers.pop(client_id, None)
                if gone is not None:
                    gone.jobs.close()
                self._sessions.pop(client_id, None)
                self._inbox.forget(client_id)
            elif client_id in self._sessions:
                self._browsers[client_id].rest.wake()
                session, effects = reduce(self._sessions[client_id], command, self._world)
                self._sessions[client_id] = session
                for effect in effects:
                    self._perform(client_id, effect)
        for client_id, browser in list(self._browsers.items()):
            session = advance(self._sessions[client_id], self._world, seconds)
            self._sessions[client_id] = session
            if session.source is not None:
                self._library.open(session.source)
            if session.other is not None:
                self._library.open(session.other)
            if session.dialog is Dialog.SETTINGS and session.form.may_be_made:
                self._defaults.ask(session.form.env_id)
            try:
                if not browser.needs_sync(session, self._world, now):
                    continue
                view = project(session, self._world)
                browser.sync(view, self._gallery, self._frames, self._thinker)
            except Exception as error:  # One browser's trouble must not keep the others waiting.
                # Handles of a browser that has just gone refuse; its Disconnect is on the way.
                if self._server is not None and client_id in self._server.get_clients():
                    self._tell_of_bug(error)
        keys = {b.picture_key for b in self._browsers.values() if b.picture_key is not None}
        self._gallery.keep_only(keys)

    def _refresh_world(self, now: float) -> None:
        before = self._world.update
        update = self._runner.latest() if self._runner is not None else before
        if update is self._outdated:  # The run has not answered its Start yet.
            update = before
        if update is not before:
            for client_id, session in self._sessions.items():
                self._sessions[client_id] = follow(session, before, update)
            self._tell_about(before, update)
            self._world = replace(self._world, update=update)
        for client_id, notice in self._library.poll_kept():
            self._relist_at = 0.0
            if client_id in self._browsers:
                self._browsers[client_id].notify(notice)
        for client_id, file in self._copies.poll(now):
            if client_id in self._browsers:
                self._hand_over(client_id, file)
        if self._defaults.poll():
            self._world = replace(self._world, defaults=self._defaults.known)
        has_news = self._library.poll()
        if now >= self._relist_at:
            self._relist_at = now + _RELIST_S
            has_news |= self._library.forget_changed()
            shelf = self._library.shelf()
            if shelf != self._world.shelf:
                self._world = replace(self._world, shelf=shelf)
        if has_news:
            self._world = replace(self._world, opened=self._library.opened)
        wishes = [s.wish for s in self._sessions.values() if s.wish is not None]
        if wishes or self._world.branched:
            self._world = replace(self._world, branched=self._brancher.play(wishes))

    def _tell_about(self, before: RunUpdate, update: RunUpdate) -> None:
        """Pops up what people must not miss: failures, refusals and where a file went."""
        if update.message == before.message or not update.message:
            return
        if update.is_error:
            self._tell_all(Notify("Training", update.message, is_error=True))
        elif "saved" in update.message.lower():
            self._relist_at = 0.0
            self._tell_all(Notify("Saved", update.message))

    def _connect(self, client_id: int, query: str) -> None:
        assert self._server is not None
        assert self._stage is not None
        client = self._server.get_clients().get(client_id)
        if client is None:  # Gone again already.
            return
        session = self._first_session()
        session = open_place(session, query, self._world.shelf)
        self._sessions[client_id] = session
        self._browsers[client_id] = Browser(client, self._stage, self._inbox)
        recall(client, self._inbox)

    def _first_session(self) -> Session:
        update, shelf = self._world.update, self._world.shelf
        form = Form(env=self._env_ids[0] if self._env_ids else Form.env, preset=Preset.ANTICIPATING)
        if _FIRST in self._env_ids:
            form = replace(form, env=_FIRST)
        if update.status in (RunStatus.PREPARING, RunStatus.RUNNING) or not shelf:
            return Session(source=None, is_playing=False, form=form)
        first = next((i for i in shelf if i.label.startswith(_FIRST)), shelf[0])
        if self._library.extra is not None:
            return Session(source=shelf[0].path, form=form, wanted=self._wanted)
        # Nobody has asked for this one, so it does not say what to train either.
        return Session(source=first.path, form=form, form_source=first.path, wanted=self._wanted)

    def _perform(self, client_id: int, effect: Effect) -> None:
        match effect:
            case Notify():
                self._browsers[client_id].notify(effect)
            case SaveFile():
                self._browsers[client_id].hand_over(effect)
            case Remember(text):
                self._browsers[client_id].remember(text)
            case KeepUpload(upload):
                self._library.keep(client_id, upload)
            case SendAgent(path):
                if path is None:
                    self._submit(self._copies.ask(client_id, self._world.update))
                else:
                    self._hand_over(client_id, read_agent(path))
            case PickOption(pick):
                option = self._browsers[client_id].pick(pick.origin, pick.direction)
                if option != NO_OPTION:
                    self._inbox.put(client_id, Select(option))
            case Begin():
                self._browsers[client_id].jobs.begin(effect)
            case CallOff(task):
                self._browsers[client_id].jobs.call_off(task)
            case _:
                self._submit(effect)

    def _submit(self, command: RunCommand) -> None:
        if self._runner is None:  # Made when first needed: a page opens sooner without.
            self._runner = self._make_runner()
        if isinstance(command, Start):
            self._outdated = self._runner.latest()
            update = RunUpdate(RunStatus.PREPARING, run_id=self._outdated.run_id)
            self._world = replace(self._world, update=update)
        self._runner.submit(command)

    def _hand_over(self, client_id: int, file: SaveFile | Notify) -> None:
        browser = self._browsers[client_id]
        if isinstance(file, SaveFile):
            browser.hand_over(file)
        else:
            browser.notify(file)

    def _tell_of_bug(self, error: Exception) -> None:
        """Tells of a bug once, although it may come back with every tick."""
        words = f"{type(error).__name__}: {error}"
        if words != self._last_bug:
            self._last_bug = words
            traceback.print_exception(error)
            self._tell_all(Notify("Something went wrong", words, is_error=True))

    def _tell_all(self, notice: Notify) -> None:
        for browser in list(self._browsers.values()):
            with contextlib.suppress(Exception):
                browser.notify(notice)


def serve(
    agent_path: Path | None = None,
    host: str = "127.0.0.1",
    port: int = 8080,
    open_browser: bool = True,
    *,
    folder: Path | None = None,
    more_folders: tuple[Path, ...] = (),
    wanted: Wanted | None = None,
    curves: tuple[Behind, ...] | None = None,
    saved: SavedAgent | None = None,
) -> None:
    """Serves the dashboard until Ctrl-C, and says in the terminal where and what.

    Args:
        agent_path: The agent to open; None opens a bundled one.
        host: What to listen on; anything but this computer gets a token in its address.
        port: Taken ones are passed over; the terminal says which it became.
        open_browser: Whether to open the page.
        folder: Where agents are saved; None: the working directory.
        more_folders: Further folders that people may choose to save to.
        wanted: The episode and step to open with.
        curves: Learners that can be laid behind a run; None: those of the paper's comparison.
        saved: What the file holds, if it has been read already.

    Raises:
        KeyboardInterrupt: On Ctrl-C, after everything was stopped.
    """
    dashboard = Dashboard(
        agent_path,
        host=host,
        port=port,
        folder=folder,
        more_folders=more_folders,
        wanted=wanted,
        curves=curves,
        saved=saved,
    )
    dashboard.start()
    try:
        shown = agent_path.name if agent_path is not None else "a bundled agent"
        print(f"ao2viz shows {shown} at {dashboard.address}", flush=True)
        if port not in {dashboard.port, 0}:
            print(f"(port {port} was taken)", flush=True)
        print("Press Ctrl-C to stop.", flush=True)
        if open_browser:
            webbrowser.open(dashboard.address)
        threading.Event().wait()
    finally:
        dashboard.stop()
