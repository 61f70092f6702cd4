"""The house rules, checked on the source itself: who imports whom, what is never used, how long."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "ao2viz"

# A module imports from lower layers and from its own room only.
LAYERS = {
    "core": 0,
    "resources": 0,
    "extras": 0,
    "envs": 1,
    "layout": 1,
    "recording": 1,
    "training": 2,
    "store": 2,
    "explain": 2,
    "agent": 3,
    "explanations": 3,
    "baselines": 3,
    "whole": 3,
    "experiments": 4,
    "figures": 4,
    "exports": 5,
    "ui": 6,
    "paper": 6,
    "cli": 7,
    "__main__": 8,
    "__init__": 8,
}
# Rooms of one layer that may use each other, each with its reason.
ALLOWED = {
    ("recording", "envs"): "An episode names the features and actions of its task.",
    ("training", "store"): "The worker saves and resumes.",
    ("training", "agent"): "The worker owns an AO2; the runners are built on it.",
    ("agent", "explanations"): "`agent.explain` is what answers.",
    ("explanations", "agent"): "It explains an AO2.",
    ("explanations", "whole"): "`agent.explain.whole` is a part of it.",
    ("agent", "training"): "AO2.learn is the loop of `training.loop`.",
}
# Every heavy library has one home; `numpy` is at home everywhere.
HOMES = {
    "numba": {"core"},
    "gymnasium": {"envs", "training", "agent", "whole", "baselines"},
    "viser": {"ui", "exports"},
    "plotly": {"figures", "ui"},
    "networkx": {"explain", "exports"},
    "typer": {"cli"},
    "rich": {"cli", "training"},
    "PIL": {"training", "figures", "exports", "ui", "envs"},
    "torch": {"baselines"},
    "safetensors": {"baselines"},
    "stable_baselines3": {"baselines"},
    "sb3_contrib": {"baselines"},
    "av": {"exports"},
    "minari": {"exports"},
    "tensorboardX": {"exports"},
    "sklearn": {"exports"},
    "scipy": {"experiments", "explain"},
    "pyarrow": {"experiments", "exports"},
    "distributed": {"experiments"},
    "ray": {"experiments"},
    "pandas": set(),
    "faiss": set(),
}
CORE_MAY_IMPORT = {"numpy", "numba"}
NEVER_IMPORTED = {
    "pickle",
    "cPickle",
    "_pickle",
    "dill",
    "cloudpickle",
    "marshal",
    "shelve",
    "joblib",
}
# What multiprocessing does anyway, between processes of our own; files and clients never.
MAY_PICKLE = {
    "ao2viz/training/runner.py": {"pickle"},
    # joblib starts the workers of a sweep; that it can also pickle to files, nobody here uses.
    "ao2viz/experiments/clusters.py": {"joblib"},
    "ao2viz/experiments/dask_cluster.py": {"joblib"},
    "ao2viz/experiments/ray_cluster.py": {"joblib"},
}
NEVER_FROM_JOBLIB = {"load", "dump", "Memory", "hash"}
# It tells the compiler where to keep its cache; the mind itself touches no file.
MAY_TOUCH_FILES = {"ao2viz/core/compiled.py"}
NEVER_CALLED = {"eval", "exec", "compile", "__import__"}
NOT_SILENT = {"time", "threading", "logging", "os", "pathlib", "random", "io"}
NOT_CALLED_IN_CORE = {"print", "open", "input", "sleep"}

SOURCES = sorted(PACKAGE.rglob("*.py"))
EVERYTHING = [
    *SOURCES,
    *sorted((ROOT / "tests").rglob("*.py")),
    *sorted((ROOT / "benchmarks").rglob("*.py")),
    *sorted((ROOT / "tools").rglob("*.py")),
    ROOT / "app.py",
]


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"), filename=str(path))


def room_of(path: Path) -> str:
    """The folder directly below the package, or the module itself."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports_of(path: Path) -> Iterator[str]:
    """Every module a file imports, lazily or not, as dotted names."""
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name_of(path)} imports relatively; write the full name."
            module = node.module or ""
            # `from ao2viz import x` may import the room x.
            yield from (
                (f"{module}.{alias.name}" for alias in node.names)
                if module == "ao2viz"
                else (module,)
            )


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_a_module_imports_from_lower_layers_and_its_own_room_only(path: Path) -> None:
    room = room_of(path)
    for module in imports_of(path):
        parts = module.split(".")
        if parts[0] != "ao2viz" or len(parts) == 1:
            continue
        other = parts[1] if parts[1] in LAYERS else "__init__"
        fine = other == room or LAYERS[other] < LAYERS[room] or (room, other) in ALLOWED
        assert fine, (
            f"{name_of(path)} (layer {LAYERS[room]}) imports {module} (layer {LAYERS[other]})."
        )


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_heavy_libraries_are_imported_only_where_they_are_at_home(path: Path) -> None:
    room = room_of(path)
    for module in imports_of(path):
        library = module.split(".")[0]
        if library in HOMES:
            assert room in HOMES[library], f"{name_of(path)} imports {module}."


@pytest.mark.parametrize("path", sorted((PACKAGE / "core").rglob("*.py")), ids=name_of)
def test_the_core_knows_numbers_only_and_is_silent(path: Path) -> None:
    for module in imports_of(path):
        library = module.split(".")[0]
        known = library in CORE_MAY_IMPORT | {"ao2viz"} or library in sys.stdlib_module_names
        assert known, f"{name_of(path)} imports {module}."
        assert name_of(path) in MAY_TOUCH_FILES or library not in NOT_SILENT, (
            f"{name_of(path)} imports {module}."
        )
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in NOT_CALLED_IN_CORE, (
                f"{name_of(path)}:{node.lineno} is not silent."
            )
        if isinstance(node, ast.Attribute) and ast.unparse(node).startswith("np.random."):
            assert node.attr in {"Generator", "default_rng"}, (
                f"{name_of(path)}:{node.lineno} draws global random numbers."
            )


@pytest.mark.parametrize("path", EVERYTHING, ids=name_of)
def test_nothing_read_from_a_file_is_ever_run(path: Path) -> None:
    for module in imports_of(path):
        library = module.split(".")[0]
        may = library in MAY_PICKLE.get(name_of(path), set())
        assert may or library not in NEVER_IMPORTED, f"{name_of(path)} imports {module}."
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Import):
            assert all(alias.name != "joblib" for alias in node.names), (
                f"{name_of(path)}:{node.lineno}: import by name what is needed of joblib."
            )
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("joblib"):
            assert not NEVER_FROM_JOBLIB & {alias.name for alias in node.names}, (
                f"{name_of(path)}:{node.lineno} takes what reads or writes files from joblib."
            )
        if not isinstance(node, ast.Call):
            continue
        called = ast.unparse(node.func)
        assert called not in NEVER_CALLED, f"{name_of(path)}:{node.lineno} calls {called}."
        if called in {"np.load", "numpy.load", "read_array", "np.lib.format.read_array"}:
            settings = {word.arg: ast.unparse(word.value) for word in node.keywords}
            assert settings.get("allow_pickle") == "False", (
                f"{name_of(path)}:{node.lineno} must say allow_pickle=False."
            )


@pytest.mark.parametrize("path", EVERYTHING, ids=name_of)
def test_no_file_eats_the_project(path: Path) -> None:
    lines = len(path.read_text("utf-8").splitlines())
    assert lines <= 400, (
        f"{name_of(path)} has {lines} lines; split it where a second subject begins."
    )


@pytest.mark.parametrize("path", sorted((ROOT / "tests").rglob("*.py")), ids=name_of)
def test_an_expected_error_is_told_apart_from_others_by_its_words(path: Path) -> None:
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "pytest.raises":
            words = {word.arg for word in node.keywords}
            assert "match" in words or "check" in words, (
                f"{name_of(path)}:{node.lineno}: add match="
            )


def test_every_room_is_on_the_list() -> None:
    rooms = {room_of(path) for path in SOURCES}
    assert rooms <= set(LAYERS), f"Give {rooms - set(LAYERS)} a layer."
