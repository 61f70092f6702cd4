"""Compiled functions, cached on disk under a name that changes with any source of this folder.

numba's cache watches the file that a function stands in, but not the files of the functions that
it calls and that are compiled into it. After an upgrade that changes one file, the others would
go on with the old code.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import config

# numba fills it at run time; type checkers do not see what is in it.
_config: Any = config

FunctionT = TypeVar("FunctionT", bound=Callable)


def compiled(function: FunctionT) -> FunctionT:
    """Compiles a function when it is first called; later processes load it from disk.

    It becomes part of every compiled function that calls it: handing a struct of arrays from one
    to another takes longer than many of them do.
    """
    return _compile(function, is_part=True)


def compiled_apart(function: FunctionT) -> FunctionT:
    """As `compiled`, but compiled code calls it: for what is long, and called from many places.

    As a part of each of them, it would take minutes to compile.
    """
    return _compile(function, is_part=False)


def compiled_long(function: FunctionT) -> FunctionT:
    """As `compiled_apart`, and called from Python it lets other threads run meanwhile.

    For what takes seconds with a big forest, in which a page would stand still. What is called
    often is better off without: it would have to wait for its turn after every call.
    """
    return _compile(function, is_part=False, lets_others_run=True)


def _compile(function: FunctionT, is_part: bool, lets_others_run: bool = False) -> FunctionT:
    before = _config.CACHE_DIR
    _config.CACHE_DIR = str(_FOLDER)
    try:
        # A division by zero gives infinity: a loop that might raise an error instead cannot be
        # taken several steps at a time. Neither option changes a bit of what is computed.
        made = numba.njit(
            cache=True, error_model="numpy", forceinline=is_part, nogil=lets_others_run
        )(function)
        return cast(FunctionT, made)
    finally:
        _config.CACHE_DIR = before


def _find_folder() -> Path:
    """Where the compiled code of exactly these sources is kept."""
    here = Path(__file__).resolve().parent
    digest = hashlib.sha256()
    for source in sorted(here.glob("*.py")):
        digest.update(source.read_bytes())
    if _config.CACHE_DIR:
        base = Path(_config.CACHE_DIR)
    elif os.access(here, os.W_OK):
        base = here / "__pycache__"
    else:
        base = Path.home() / ".cache" / "ao2viz"
    return base / f"compiled-{digest.hexdigest()[:16]}"


_FOLDER = _find_folder()
