"""The documentation is complete and its links lead somewhere."""

import os
import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest
from typer.core import TyperGroup
from typer.main import get_command

from ao2viz.cli.commands import app
from ao2viz.core.config import AnticipatingConfig, Credit, PaperConfig, Preset
from ao2viz.envs.catalogue import CATALOGUE
from ao2viz.exports.formats import ABOUT, Format

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), ROOT / "benchmarks/README.md"])


def read(name: str) -> str:
    return (ROOT / name).read_text("utf-8")


def section(text: str, heading: str) -> str:
    """What stands under a heading, up to the next one of the same rank."""
    rank = re.escape(heading.split(" ", maxsplit=1)[0])
    found = re.search(rf"^{re.escape(heading)}.*?(?=^{rank} |\Z)", text, re.MULTILINE | re.DOTALL)
    assert found is not None, f"There is no heading {heading!r}."
    return found[0]


def commands() -> dict[str, list[str]]:
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    return {
        name: [
            option
            for parameter in command.params
            for option in parameter.opts
            if option.startswith("--") and option != "--help"
        ]
        for name, command in group.commands.items()
    }


@pytest.mark.parametrize("name", commands())
def test_every_command_has_a_section_that_names_every_option(name: str) -> None:
    text = section(read("docs/cli.md"), f"## `ao2viz {name}")
    for option in commands()[name]:
        assert f"`{option}`" in text, f"docs/cli.md does not mention {name} {option}."


def test_options_that_are_documented_exist() -> None:
    known = {option for options in commands().values() for option in options}
    for option in re.findall(r"`(--[a-z-]+)`", read("docs/cli.md")):
        assert option in known | {"--help", "--version"}, f"{option} is gone from the program."


@pytest.mark.parametrize("format", Format)
def test_every_export_format_is_explained(format: Format) -> None:
    row = re.search(rf"^\| `{format.value}` \|(.*)$", read("docs/exports.md"), re.MULTILINE)
    assert row is not None, f"docs/exports.md does not explain {format.value}."
    suffix = ABOUT[format].suffix
    assert row[1].startswith(f" `{suffix}` |" if suffix else " folder |")
    assert ("extra `exports`" in row[1]) == bool(ABOUT[format].libraries)


@pytest.mark.parametrize("config", [AnticipatingConfig, PaperConfig])
def test_every_setting_is_explained_with_its_default(config: type) -> None:
    text = section(read("docs/algorithm.md"), "## Every setting")
    for field in fields(config):
        row = re.search(rf"^\| `{field.name}` \|([^|]*)\|", text, re.MULTILINE)
        assert row is not None, f"docs/algorithm.md does not explain {field.name}."
        default = getattr(field.default, "value", field.default)
        shown = str(default).lower() if isinstance(default, bool) else str(default)
        assert re.search(rf"(?<![\d.]){re.escape(shown)}(?![\d.])", row[1]), (
            f"docs/algorithm.md gives{row[1]}as the default of {field.name}; it is {shown}."
        )


def test_every_explained_setting_exists() -> None:
    known = {field.name for config in (AnticipatingConfig, PaperConfig) for field in fields(config)}
    text = section(read("docs/algorithm.md"), "## Every setting")
    explained = set(re.findall(r"^\| `([a-z_]+)` \|", text, re.MULTILINE))
    assert explained == known | {"action_bins"}


def test_presets_and_credits_are_explained() -> None:
    text = read("docs/algorithm.md")
    for preset in Preset:
        assert f"## The `{preset.value}` preset" in text
    for credit in Credit:
        assert f"- `{credit.value}`" in text


@pytest.mark.parametrize("env_id", CATALOGUE)
def test_every_catalogued_environment_is_mentioned(env_id: str) -> None:
    assert env_id in read("docs/cli.md")
    assert env_id in read("docs/algorithm.md")


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text("utf-8")):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        assert path.exists(), f"{page.relative_to(ROOT)} links to {target}, which is not there."
        if anchor:
            headings = re.findall(r"^#+ (.+)$", path.read_text("utf-8"), re.MULTILINE)
            slugs = {re.sub(r"[^\w\- ]", "", h).strip().lower().replace(" ", "-") for h in headings}
            assert anchor in slugs, f"{page.relative_to(ROOT)} links to {target}: no such heading."


def test_every_make_target_that_the_docs_name_exists() -> None:
    targets = set(re.findall(r"^([a-z]+):", read("Makefile"), re.MULTILINE))
    for page in PAGES:
        for target in re.findall(
            r"(?:`|^    |^)make ([a-z]+)", page.read_text("utf-8"), re.MULTILINE
        ):
            assert target in targets, f"{page.name} names `make {target}`."


def test_the_code_in_the_readme_runs(tmp_path: Path) -> None:
    found = re.search(r"^```python\n(.*?)^```", read("README.md"), re.MULTILINE | re.DOTALL)
    assert found is not None
    assert len([line for line in found[1].splitlines() if line]) == 5
    done = subprocess.run(
        [sys.executable, "-c", found[1]],
        check=False,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "cartpole.ao2").is_file()


def test_the_readme_fits_on_one_screen() -> None:
    assert len(read("README.md").splitlines()) <= 50
