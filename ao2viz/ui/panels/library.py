"""The dialog of agent files: open, download, upload, and where new ones go."""

from pathlib import Path

import viser

from ao2viz.store.files import SUFFIX
from ao2viz.training.states import Save, accepts
from ao2viz.ui import html
from ao2viz.ui.commands import ChooseSource
from ao2viz.ui.dialog_commands import ChooseFolder, ConfirmUpload, DownloadAgent, Uploaded
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_press
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.shelf import MAX_UPLOAD_BYTES
from ao2viz.ui.view import View

_NONE = "none yet"
_WORDS = (
    "Bundled agents, and those in the folders that this dashboard was started with. Uploaded "
    f"files, up to {MAX_UPLOAD_BYTES // 2**20} MiB, are checked to the last number before they are "
    "kept; nothing in them can run."
)


class LibraryDialog:
    """The shelf, and the folder that agents go to."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox, view: View) -> None:
        self._paths: dict[str, Path] = {}
        self._folders: dict[str, Path] = {}
        gui.add_html(html.dialog())
        gui.add_html(f'<div class="ao"><p class="ao-dim">{html.esc(_WORDS)}</p></div>')
        self._agent = gui.add_dropdown("Agent", (_NONE,))
        self._agent_shown = Mirror(self._agent)
        gui.add_html(html.row(3))
        self._watch = gui.add_button("Watch it", color="gray", icon=viser.Icon.EYE)
        on_press(self._watch, self._to_source, client_id, inbox)
        self._download = gui.add_button("Download it", color="gray", icon=viser.Icon.DOWNLOAD)
        on_press(self._download, self._to_download, client_id, inbox)
        self._run = gui.add_button("Download the run", color="gray", icon=viser.Icon.DOWNLOAD)
        on_click(self._run, DownloadAgent(None), client_id, inbox)
        self._folder = gui.add_dropdown(
            "Folder", (_NONE,), hint="Where agents are saved and uploaded to."
        )
        self._folder_shown = Mirror(self._folder)
        on_change(self._folder, self._to_folder, client_id, inbox)
        self._upload = gui.add_upload_button(
            f"Upload an agent ({SUFFIX})", color="gray", icon=viser.Icon.UPLOAD, mime_type=SUFFIX
        )

        @self._upload.on_upload
        async def _(event: viser.GuiEvent) -> None:
            file = event.target.value
            inbox.put(client_id, Uploaded(file.name, file.content))

        self._question = gui.add_html("", visible=False)
        self._replace = gui.add_button("Replace the file", color="orange", visible=False)
        on_click(self._replace, ConfirmUpload(True), client_id, inbox)
        self._keep = gui.add_button("Keep what is there", color="gray", visible=False)
        on_click(self._keep, ConfirmUpload(False), client_id, inbox)
        self.sync(view)

    def sync(self, view: View) -> None:
        """Shows what is on the shelf."""
        self._paths = {item.label: item.path for item in view.shelf}
        labels = tuple(self._paths) or (_NONE,)
        if self._agent.options != labels:
            watched = next((k for k, path in self._paths.items() if path == view.source), labels[0])
            self._agent_shown.show_among(labels, watched)
        self._watch.disabled = self._download.disabled = not self._paths
        self._run.disabled = not accepts(view.run.status, Save)
        self._folders = {str(folder): folder for folder in view.folders}
        self._folder_shown.show_among(tuple(self._folders) or (_NONE,), str(view.folder))
        asks = view.upload is not None
        self._question.visible = self._replace.visible = self._keep.visible = asks
        if view.upload is not None:
            self._question.content = (
                f'<div class="ao"><p role="alert">There is a file {html.esc(view.upload.name)} '
                "already. Replace it by the one that was uploaded?</p></div>"
            )

    def _to_source(self) -> ChooseSource | None:
        path = self._paths.get(self._agent.value)
        return ChooseSource(path) if path is not None else None

    def _to_download(self) -> DownloadAgent | None:
        path = self._paths.get(self._agent.value)
        return DownloadAgent(path) if path is not None else None

    def _to_folder(self, words: str) -> ChooseFolder | None:
        folder = self._folders.get(words)
        return ChooseFolder(folder) if folder is not None else None
