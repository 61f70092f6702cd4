"""What `import ao2viz` offers, and how little it takes."""

import subprocess
import sys

import pytest

import ao2viz
from ao2viz.agent import AO2
from ao2viz.exports.export import export


def test_every_public_name_is_there_and_listed() -> None:
    assert all(hasattr(ao2viz, name) for name in ao2viz.__all__)
    assert set(ao2viz.__all__) <= set(dir(ao2viz))
    assert ao2viz.AO2 is AO2
    assert ao2viz.export is export
    assert ao2viz.__version__.startswith("0.")


def test_other_names_are_refused() -> None:
    with pytest.raises(AttributeError, match="module 'ao2viz' has no attribute 'AO3'"):
        _ = ao2viz.AO3  # pyright: ignore[reportAttributeAccessIssue]


def test_nothing_heavy_is_imported_before_it_is_asked_for() -> None:
    code = "import sys, ao2viz.cli; print({'numpy', 'numba', 'gymnasium'} & {*sys.modules})"
    told = subprocess.check_output([sys.executable, "-c", code], text=True)
    assert told == "set()\n"
