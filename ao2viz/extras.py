"""Libraries that only some commands need: asked for in words, not with a traceback."""

import importlib
from collections.abc import Iterable, Mapping

# What pip installs with each extra, by the names they are imported with.
_EXTRAS: Mapping[str, tuple[str, ...]] = {
    "experiments": ("joblib", "pyarrow", "scipy"),
    "dask": ("distributed",),
    "ray": ("ray",),
    "exports": ("av", "minari", "pyarrow", "sklearn", "tensorboardX"),
    "explain": ("scipy",),
    "baselines": ("torch", "safetensors", "stable_baselines3", "sb3_contrib"),
}


def need(extra: str, names: Iterable[str] | None = None) -> None:
    """Makes sure that everything of an extra can be imported, or these libraries of it.

    Raises:
        ValueError: If something is missing; says how to get it.
    """
    for name in _EXTRAS[extra] if names is None else names:
        try:
            importlib.import_module(name)
        except ImportError as error:
            raise ValueError(
                f"This needs {name}, which cannot be imported here ({error}). To get it: "
                f"pip install 'ao2viz[{extra}]'."
            ) from error
