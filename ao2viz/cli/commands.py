"""Every command with its arguments; what each one does lives in a module of its own."""

from pathlib import Path
from typing import Annotated

import typer

from ao2viz.cli.console import say
from ao2viz.cli.experiments import paper, results, sweep
from ao2viz.cli.options import AgentFile, Env, Json, StepOf
from ao2viz.core.config import Preset
from ao2viz.explain.questions import Question
from ao2viz.exports.formats import ABOUT, Format

DEFAULT_HOST = "127.0.0.1"
DEFAULT_PORT = 8080

app = typer.Typer(
    name="ao2viz",
    help="Train AO2 agents, and watch them think. Without a command, opens the dashboard.",
    add_completion=False,
    no_args_is_help=False,
    rich_markup_mode="rich",
)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version  # noqa: PLC0415 -- slow, and rarely asked for.

        say(f"ao2viz {version('ao2viz')}")
        raise typer.Exit()


@app.callback()
def options(
    _: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    """Train AO2 agents, and watch them think. Without a command, opens the dashboard."""


@app.command("app")
def open_app(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="[FILE]", help="An agent's .ao2 file; the bundled CartPole agent."),
    ] = None,
    host: Annotated[
        str,
        typer.Option(help="Address to listen on; others than this machine's own need a token."),
    ] = DEFAULT_HOST,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port to listen on; 0 takes a free one.")
    ] = DEFAULT_PORT,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Print the address only, open no browser.")
    ] = False,
    folder: Annotated[
        list[Path] | None,
        typer.Option(help="Folder to save to and open from; more than one leaves the choice."),
    ] = None,
    episode: Annotated[
        int | None, typer.Option(min=0, help="The recorded episode to open, counted from 0.")
    ] = None,
    step: StepOf = None,
    curves: Annotated[
        Path | None,
        typer.Option(
            help="curves.json of ao2viz paper to lay behind runs; the one that ships with ao2viz."
        ),
    ] = None,
) -> None:
    """Open the dashboard in the browser. Ctrl-C stops it."""
    from ao2viz.cli.dashboard import run  # noqa: PLC0415 -- heavy.

    moment = (episode, step)
    run(
        file,
        moment,
        host=host,
        port=port,
        open_browser=not no_browser,
        folders=folder or (),
        curves=curves,
    )


@app.command()
def train(
    env: Annotated[
        str,
        typer.Argument(
            metavar="ENV",
            help="A Gymnasium environment, such as CartPole-v1, or an .ao2 file to go on with.",
        ),
    ],
    steps: Annotated[int, typer.Option(min=1, help="Steps of the environment to learn from.")] = (
        20_000
    ),
    preset: Annotated[
        Preset | None,
        typer.Option(
            help="The agent: ours, or the closest reading of the paper; otherwise anticipating."
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(
            min=0, help="Fixes everything random: the same seed, the same forest; otherwise 0."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="File to save to; otherwise runs/ENV-PRESET-seedSEED.ao2, or the file itself."
        ),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Change a setting of the preset, such as levels=4; may be repeated.",
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the file if there is one already.")
    ] = False,
    env_id: Env = None,
    as_json: Json = False,
) -> int:
    """Train an agent and save it. Ctrl-C saves what was learned so far and says where."""
    from ao2viz.cli.training import run  # noqa: PLC0415 -- heavy.

    return run(
        env,
        steps=steps,
        preset=preset,
        seed=seed,
        out=out,
        settings=settings or [],
        overwrite=overwrite,
        env_id=env_id,
        as_json=as_json,
    )


@app.command()
def evaluate(
    file: AgentFile,
    episodes: Annotated[int, typer.Option(min=1, help="Greedy episodes to play.")] = 100,
    seed: Annotated[
        int, typer.Option(min=0, help="Which episodes: the same seed, the same ones.")
    ] = 0,
    think_ahead: Annotated[
        int | None,
        typer.Option(help="Steps to think ahead in every decision; 0: none. As saved if left out."),
    ] = None,
    env: Env = None,
    as_json: Json = False,
) -> None:
    """Play greedy episodes: mean, standard deviation, standard error and every return."""
    from ao2viz.cli.evaluation import run  # noqa: PLC0415 -- heavy.

    run(file, episodes=episodes, seed=seed, think_ahead=think_ahead, env=env, as_json=as_json)


@app.command()
def record(
    file: AgentFile,
    episodes: Annotated[int, typer.Option(min=1, help="Greedy episodes to record.")] = 1,
    seed: Annotated[
        int, typer.Option(min=0, help="Which episodes: the same seed, the same ones.")
    ] = 0,
    out: Annotated[
        Path | None, typer.Option(help="Write to this file and leave FILE as it is.")
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the --out file if there is one already.")
    ] = False,
    env: Env = None,
    as_json: Json = False,
) -> None:
    """Record greedy episodes, with the decision behind every step, and add them to the file."""
    from ao2viz.cli.evaluation import run_record  # noqa: PLC0415 -- heavy.

    run_record(
        file, episodes=episodes, seed=seed, out=out, overwrite=overwrite, env=env, as_json=as_json
    )


@app.command()
def cleanse(
    file: AgentFile,
    out: Annotated[Path, typer.Option(help="File to save the smaller agent to.")],
    tolerance: Annotated[
        float,
        typer.Option(
            min=0.0,
            max=1.0,
            help="By how much expectations may change, in standard deviations of what options "
            "are worth.",
        ),
    ] = 0.05,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the --out file if there is one already.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Let go of options that decisions hardly need, and save a smaller agent."""
    from ao2viz.cli.cleansing import run  # noqa: PLC0415 -- heavy.

    run(file, out=out, tolerance=tolerance, overwrite=overwrite, as_json=as_json)


# The help lists commands in this order.
app.command()(sweep)
app.command()(results)
app.command()(paper)


@app.command(
    # An empty line between them, or they are set as one paragraph.
    epilog="Formats:\n\n"
    + "\n\n".join(f"{format.value}: {about.holds}" for format, about in ABOUT.items())
)
def export(
    file: AgentFile,
    format: Annotated[
        Format, typer.Option("--format", help="What to write; docs/exports.md says what each is.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(help="File (for some formats folder) to write; otherwise named after FILE."),
    ] = None,
    episode: Annotated[
        int | None,
        typer.Option(min=0, help="Only this recorded episode, counted from 0; otherwise all."),
    ] = None,
    step: Annotated[
        int | None, typer.Option(min=0, help="The step, in formats that show one decision.")
    ] = None,
    option: Annotated[
        int | None, typer.Option(min=0, help="The option, in formats that show one.")
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the file if there is one already.")
    ] = False,
    env: Env = None,
    as_json: Json = False,
) -> None:
    """Write an agent and its recorded decisions in a format that others read."""
    from ao2viz.cli.export import run  # noqa: PLC0415 -- heavy.

    run(
        file,
        format,
        out=out,
        episode=episode,
        step=step,
        option=option,
        overwrite=overwrite,
        env=env,
        as_json=as_json,
    )


@app.command()
def explain(
    file: AgentFile,
    question: Annotated[
        Question, typer.Argument(help="What to ask; docs/explanations.md says what each proves.")
    ] = Question.WHY,
    episode: Annotated[
        int | None,
        typer.Option(min=0, help="The recorded episode, counted from 0; otherwise the latest."),
    ] = None,
    step: StepOf = None,
    observation: Annotated[
        str | None,
        typer.Option(metavar="X,Y,…", help="Ask about what it would do, seeing this, instead."),
    ] = None,
    action: Annotated[
        str | None,
        typer.Option(help="The action that why-not and weight are about: its name or number."),
    ] = None,
    option: Annotated[
        int | None,
        typer.Option(min=0, help="The option that weight or mute is about; otherwise who decided."),
    ] = None,
    steps: Annotated[int, typer.Option(min=1, max=1000, help="How far ahead looks.")] = 50,
    time_limit: Annotated[
        float, typer.Option(min=0.0, help="Seconds that nearest-flip may search.")
    ] = 30.0,
    forget: Annotated[
        int | None, typer.Option(min=0, help="The training episode to forget, counted from 0.")
    ] = None,
    other: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The other agent of disagree.")
    ] = None,
    episodes: Annotated[
        int, typer.Option(min=1, help="Greedy episodes that mute plays for each option.")
    ] = 10,
    env: Env = None,
    as_json: Json = False,
) -> None:
    """Say why an agent decided as it did, what would have changed it, and where it leads."""
    from ao2viz.cli.explaining import Asked, run  # noqa: PLC0415 -- heavy.

    asked = Asked(
        episode, step, observation, action, option, steps, time_limit, forget, other, episodes
    )
    run(file, question, asked, env=env, as_json=as_json)


@app.command()
def info(file: AgentFile, as_json: Json = False) -> None:
    """Say what a file holds: environment, settings, forest, training and recorded episodes."""
    from ao2viz.cli.information import run  # noqa: PLC0415 -- heavy.

    run(file, as_json=as_json)


@app.command("list")
def list_agents(
    folder: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FOLDER]", help="Where to look; otherwise the bundled agents and runs."
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """List the agents in a folder."""
    from ao2viz.cli.information import run_list  # noqa: PLC0415 -- heavy.

    run_list(folder, as_json=as_json)
