"""Exports are whole or not there, and say in one line what is wrong."""

import resource
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import ao2viz
from ao2viz import Format, extras
from ao2viz.core.config import Preset
from ao2viz.exports.formats import ABOUT
from ao2viz.exports.writers import FILES, FOLDERS
from ao2viz.resources import saved_schemas
from ao2viz.store.saved import SavedAgent
from tests.exports.conftest import Export

SHIPPED = saved_schemas() / "CartPole-v1.ao2"


def test_every_format_has_a_writer_and_is_told_about() -> None:
    assert set(ABOUT) == set(Format)
    assert set(FILES) == {format for format in Format if not ABOUT[format].is_folder}
    assert set(FOLDERS) == {format for format in Format if ABOUT[format].is_folder}
    needed = {library for about in ABOUT.values() for library in about.libraries}
    assert needed == set(extras._EXTRAS["exports"])


def test_exports_make_nothing_slower_that_does_not_export() -> None:
    program = (
        "import sys, ao2viz.cli.commands\nfrom ao2viz import *\n"
        "print({'plotly', 'networkx', 'viser', 'jinja2', 'PIL', 'sklearn'} & set(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    )
    assert done.stdout.strip() == "set()"


@pytest.mark.parametrize("format", ["json", Format.JSON])
def test_an_agent_its_saved_form_and_its_file_export_alike(
    tmp_path: Path, format: Format | str
) -> None:
    agent = ao2viz.AO2.load(SHIPPED)
    written = [
        ao2viz.export(source, tmp_path / "deep" / f"{i}.json", format, episode=0)
        for i, source in enumerate((agent, agent.to_saved(), SHIPPED, str(SHIPPED)))
    ]
    assert len({path.read_bytes() for path in written}) == 1


def test_an_agent_without_episodes_says_how_to_record_one(
    cartpole: SavedAgent, write: Export
) -> None:
    silent = replace(cartpole, episodes=())
    for format in ("csv", "paths-csv", "parquet", "latex"):
        with pytest.raises(ValueError, match="ao2viz record FILE"):
            write(silent, format)
    write(silent, "json")
    write(silent, "markdown")


@pytest.mark.parametrize(
    ("chosen", "words"),
    [
        ({"episode": 2}, "There is no episode 2; there are episodes 0 to 1"),
        ({"episode": -1}, "There is no episode -1"),
        ({"step": 40}, "There is no step 40; there are steps 0 to 39"),
    ],
)
def test_what_is_not_there_is_told(
    cartpole: SavedAgent, write: Export, tmp_path: Path, chosen: dict, words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        write(cartpole, "json", **chosen)
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_format_is_answered_with_those_that_are(cartpole: SavedAgent) -> None:
    with pytest.raises(ValueError, match="one of the formats json, csv"):
        ao2viz.export(cartpole, "x", "jsno")


def test_nothing_is_replaced_unless_asked(cartpole: SavedAgent, write: Export) -> None:
    path = write(cartpole, "json")
    path.write_text("mine")
    with pytest.raises(ValueError, match="there already"):
        write(cartpole, "json")
    assert path.read_text() == "mine"
    write(cartpole, "json", overwrite=True)
    assert path.read_text() != "mine"
    path.unlink()
    path.mkdir()
    with pytest.raises(ValueError, match="is a folder"):
        write(cartpole, "json", overwrite=True)


@pytest.mark.parametrize(
    "format", [format.value for format, about in ABOUT.items() if about.libraries]
)
def test_a_missing_library_is_told_with_the_extra_that_brings_it(
    cartpole: SavedAgent,
    write: Export,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    format: str,
) -> None:
    for library in ABOUT[Format(format)].libraries:
        monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(ValueError, match=r"pip install 'ao2viz\[exports\]'"):
        write(cartpole, format)
    assert list(tmp_path.iterdir()) == []


STEPPED = ["json", "csv", "parquet", "markdown", "latex"]


@pytest.mark.parametrize("format", STEPPED)
def test_progress_grows_to_the_end_and_can_stop_it(
    cartpole: SavedAgent, write: Export, tmp_path: Path, format: str
) -> None:
    shares: list[float] = []
    path = write(cartpole, format, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert len(shares) >= 40
    old = path.read_bytes()

    def stop(share: float) -> None:
        if share > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match=r"^$"):
        write(cartpole, format, progress=stop, overwrite=True)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]
    assert path.read_bytes() == old


def test_a_forbidden_folder_is_told_in_one_line(cartpole: SavedAgent) -> None:
    if not Path("/proc").is_dir():
        pytest.skip("There is no folder here that even root cannot write to.")
    with pytest.raises(OSError, match=r"/proc/x\.json"):
        ao2viz.export(cartpole, "/proc/x.json", "json")


@pytest.mark.parametrize("format", ["json", "parquet", "csv", "html", "mp4"])
def test_a_full_disk_leaves_nothing_and_gets_one_line(tmp_path: Path, format: str) -> None:
    def limit() -> None:
        # No file may grow further than this: for who writes, that is a disk that is full.
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    old = tmp_path / "out"
    old.write_text("old")
    agent = saved_schemas() / "MountainCar-v0.ao2"  # Its episodes are short.
    done = subprocess.run(
        [
            *(sys.executable, "-m", "ao2viz", "export", str(agent)),
            *("--format", format, "--out", str(old), "--overwrite"),
        ],
        check=False,
        cwd=Path(__file__).resolve().parents[2],
        capture_output=True,
        text=True,
        preexec_fn=limit,
        timeout=120,
    )
    assert done.returncode == 2, done.stderr
    assert done.stderr.splitlines() == [f"Error: {old}: File too large"]
    assert old.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["out"]


def test_both_presets_can_be_exported(tmp_path: Path) -> None:
    agent = ao2viz.AO2("CartPole-v1", Preset.PAPER, seed=1).learn(60)
    agent.record_episode(5)
    for format in STEPPED:
        assert ao2viz.export(agent, tmp_path / format, format).stat().st_size > 500
