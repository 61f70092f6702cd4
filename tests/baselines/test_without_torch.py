"""Without the extra, everything else works, and it says how to get the extra."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

BLOCKED = """
import sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {"torch", "safetensors", "stable_baselines3", "sb3_contrib"}:
            raise ImportError(f"{name} is blocked")

sys.meta_path.insert(0, Blocker())

import importlib
import pkgutil

import ao2viz
from ao2viz import baselines

NOT_ALONE = ("ao2viz.baselines.", "ao2viz.__main__", "ao2viz.experiments.ray_",
             "ao2viz.experiments.dask_")
modules = [one.name for one in pkgutil.walk_packages(ao2viz.__path__, "ao2viz.")]
assert len(modules) > 100
for name in modules:
    if not name.startswith(NOT_ALONE):
        importlib.import_module(name)
assert ao2viz.AO2("CartPole-v1", seed=0).num_timesteps == 0
for call in (lambda: baselines.make("ppo", "CartPole-v1"), lambda: baselines.load("x.safetensors")):
    try:
        call()
    except ValueError as error:
        print(error)
assert not {"torch", "safetensors", "stable_baselines3"} & set(sys.modules)
"""


def test_ao2viz_needs_no_torch_and_says_how_to_get_it():
    done = subprocess.run(
        [sys.executable, "-c", BLOCKED], check=False, cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 2
    assert all("needs torch" in line for line in lines)
    assert all("pip install 'ao2viz[baselines]'" in line for line in lines)


def test_importing_them_imports_no_torch():
    code = "import sys, ao2viz.baselines; print('torch' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=ROOT, capture_output=True, text=True
    )
    assert done.stdout == "False\n"
