"""What one browser chose: its place in an episode, its selection, its half-filled form."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ao2viz.core.config import Preset
from ao2viz.core.decision import NO_OPTION
from ao2viz.exports.formats import Format, Scope
from ao2viz.recording.cycle import Stage
from ao2viz.ui.appearance import Appearance
from ao2viz.ui.branches import Branch, BranchWish
from ao2viz.ui.dialog_commands import Dialog
from ao2viz.ui.look import ChartLook, Look

OTHER_ENV = "other …"
"""The choice in the list of environments that lets people type an id."""


@dataclass(frozen=True)
class Form:
    """What a run will be started or saved with."""

    env: str = "CartPole-v1"
    custom_env: str = ""
    preset: Preset = Preset.ANTICIPATING
    seed: int = 0
    steps: int = 20_000
    file_name: str = "my-agent"
    settings: Mapping[str, str] = field(default_factory=dict)  # As typed, where they were.
    folder: Path | None = None  # Where agents go; None: the first that is allowed.
    resets: int = 0  # Raised by a reset, so that what was typed gives way.

    @property
    def env_id(self) -> str:
        """The environment meant, whichever way it was given."""
        return self.custom_env.strip() if self.env == OTHER_ENV else self.env

    @property
    def may_be_made(self) -> bool:
        """Whether making the environment runs nothing but what is registered already.

        "module:Env" would import code by a name that any browser may type.
        """
        return self.env != OTHER_ENV or ":" not in self.env_id


@dataclass(frozen=True)
class Upload:
    """A file that came from a browser, and where it is to go."""

    path: Path
    content: bytes


@dataclass(frozen=True)
class Place:
    """What the inspector shows."""

    option: int
    action: int | None = None  # Whose reasons are open.


@dataclass(frozen=True)
class Supposition:
    """A state that a person supposes instead of the one that was seen."""

    seen: tuple[float, ...]  # At the moment that it began from; at any other it means nothing.
    state: tuple[float, ...]  # Environment units.


@dataclass(frozen=True)
class Wanted:
    """A moment that an address or the command line asked for; counted from 0."""

    episode: int | None = None  # None: the first.
    step: int | None = None  # None: from the beginning, playing.


@dataclass(frozen=True)
class Session:
    """Everything one browser chose; the run itself belongs to all."""

    source: Path | None = None  # The agent file that is watched; None: the training run.
    episode: int = 0
    position: float = 0.0  # In steps; its whole part is shown. Fractions carry slow playing.
    is_playing: bool = True
    play_speed: float = 1.0
    loops: bool = False  # An episode begins anew at its end.
    wanted: Wanted | None = None  # Where to go once the file is open.
    stop_text: str = ""  # The condition at which playing holds; a valid one.
    stop_problem: str = ""  # What was wrong with the one that was typed last.
    remark: str = ""  # What the latest command about the replay came to, in words.
    branch: Branch | None = None  # What is watched instead of the main line.
    wish: BranchWish | None = None  # A branch that is being played.
    looks_back: int | None = None  # The step of training whose forest is shown; None: now.
    branch_limit: int = 0  # Steps that the agent goes on for in a branch; 0: to the end.
    selected: int = NO_OPTION
    opened: int | None = None  # The action whose weight is opened to its reasons.
    trail: tuple[Place, ...] = ()  # What was inspected, as a browser's history.
    trail_at: int = -1  # Where in it we are.
    supposition: Supposition | None = None
    forgotten: int = 0  # The training episode that would be forgotten, counted from 0.
    other: Path | None = None  # The agent file that is compared with what is watched.
    duel_seed: int = 1
    duel_step: int = 0
    muted: int = 5  # So many options would be played without, one at a time,
    muted_episodes: int = 10  # so many episodes each.
    looks_at_whole: int = 0  # Raised to ask for the whole agent to be seen.
    export: Format = Format.HTML
    scope: Scope = Scope.EPISODE
    shows_ahead: bool = True  # Where the agent expects to go is drawn.
    look: Look = field(default_factory=Look)
    charts: ChartLook = field(default_factory=ChartLook)
    form: Form = field(default_factory=Form)
    form_source: Path | None = None  # The file whose task the form was last filled in for.
    appearance: Appearance = field(default_factory=Appearance)
    dialog: Dialog | None = None  # What is open in the middle of the page.
    walked: int = 0  # The step that is walked through, by the agent's count.
    stage: Stage = Stage.SAMPLE  # Where in it we are.
    waits_for_step: bool = False  # To be walked through once it was taken.
    overwrite: Path | None = None  # The file that waits for a yes before it is replaced.
    upload: Upload | None = None  # What waits for a yes before it replaces a file.
    fits: int = 0  # Raised to ask for the whole forest in view.
    focuses: int = 0  # Raised to ask for the path in view.
    selection_focuses: int = 0  # Raised to ask for the selected option in view.
    tidies: int = 0  # Raised to ask for a fresh arrangement.
