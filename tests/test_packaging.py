"""The wheel, installed elsewhere, has everything: commands, trained agents, static files."""

import json
import os
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def run(*command: str | Path, cwd: Path) -> str:
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [str(part) for part in command],
        check=False,
        cwd=cwd,
        env=clean,
        capture_output=True,
        text=True,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def shipped(folder: str) -> set[str]:
    """What git would ship of a folder: no caches, no hidden files."""
    return {
        path.relative_to(ROOT / folder).as_posix()
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and not path.name.startswith(".")
    }


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    run(
        sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation",
        "--wheel-dir", folder, ROOT, cwd=folder,
    )  # fmt: skip
    (built,) = folder.glob("ao2viz-*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The programs of a fresh environment that holds the wheel; it borrows our dependencies."""
    home = tmp_path_factory.mktemp("installed")
    venv.create(home, with_pip=False)
    programs = home / ("Scripts" if os.name == "nt" else "bin")
    python = programs / "python"
    run(
        sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-deps", wheel,
        cwd=home,
    )  # fmt: skip
    site = run(python, "-c", "import sysconfig; print(sysconfig.get_paths()['purelib'])", cwd=home)
    # A folder that a .pth file names is searched last, and its own .pth files are not read: the
    # checkout that this environment may hold in editable form stays out of sight.
    (Path(site.strip()) / "borrowed.pth").write_text(sysconfig.get_paths()["purelib"])
    return programs


def test_the_wheel_carries_the_package_and_what_ships_with_it(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    for folder in ("saved_schemas", "static"):
        expected = {f"ao2viz/_data/{folder}/{name}" for name in shipped(folder)}
        assert expected
        assert expected <= names
    modules = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "ao2viz").rglob("*.py")
        if "__pycache__" not in path.parts
    }
    assert modules <= names
    assert "ao2viz/_data/docs/paper/curves.json" in names
    assert not any(name.startswith(("tests/", "benchmarks/")) for name in names)


def test_installed_elsewhere_it_finds_its_files(installed: Path, tmp_path: Path) -> None:
    program = (
        "import json, ao2viz, ao2viz.resources as r\n"
        "list_files = lambda d: sorted(p.relative_to(d).as_posix() for p in d.rglob('*') "
        "if p.is_file())\n"
        "print(json.dumps([ao2viz.__file__, ao2viz.__version__, list_files(r.saved_schemas()), "
        "list_files(r.static()), r.learner_curves().read_text('utf-8')]))"
    )
    where, version, agents, static, curves = json.loads(
        run(installed / "python", "-c", program, cwd=tmp_path)
    )
    assert Path(where).is_relative_to(installed.parent)
    assert version == tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert shipped("saved_schemas") <= set(agents)
    assert shipped("static") <= set(static)
    assert curves == (ROOT / "docs" / "paper" / "curves.json").read_text("utf-8")


def test_installed_elsewhere_the_command_lists_the_bundled_agents(
    installed: Path, tmp_path: Path
) -> None:
    rows = json.loads(run(installed / "ao2viz", "list", "--json", cwd=tmp_path))
    bundled = {path.name for path in (ROOT / "saved_schemas").glob("*.ao2")}
    assert {Path(row["file"]).name for row in rows} == bundled
    assert not any("error" in row for row in rows)
    for row in rows:
        assert row["bytes"] < 4_000_000
        assert row["recorded_episodes"] >= 2


def test_installed_elsewhere_it_exports_with_the_files_it_carries(
    installed: Path, tmp_path: Path
) -> None:
    program = "import ao2viz.resources as r; print(r.saved_schemas() / 'MountainCar-v0.ao2')"
    agent = run(installed / "python", "-c", program, cwd=tmp_path).strip()
    for format in ("html", "png", "policy"):
        run(
            installed / "ao2viz", "export", agent, "--format", format, "--out", f"out.{format}",
            cwd=tmp_path,
        )  # fmt: skip
        assert (tmp_path / f"out.{format}").stat().st_size > 50_000
