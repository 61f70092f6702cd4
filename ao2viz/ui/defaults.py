"""The settings that agents of an environment begin with, found out in the background."""

from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor

from ao2viz.core.config import Config, Preset, change_config, make_config
from ao2viz.envs.task import describe, make_env, settings_for

Defaults = Mapping[str, Mapping[Preset, Config]]
"""By environment id; those not known yet, or that cannot be made, are missing."""

_KEPT = 32


class DefaultsStore:
    """Makes each environment once, to see what its settings would be."""

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1, "defaults")
        self._coming: dict[str, Future[Mapping[Preset, Config]]] = {}
        self.known: Defaults = {}

    def ask(self, env_id: str) -> None:
        """Begins to find out, unless it is known or cannot be."""
        if env_id and env_id not in self._coming:
            while len(self._coming) >= _KEPT:
                self._coming.pop(next(iter(self._coming))).cancel()
            self._coming[env_id] = self._thread.submit(find_defaults, env_id)

    def poll(self) -> bool:
        """Takes over what was found; whether there was anything."""
        done = {
            env_id: future.result()
            for env_id, future in self._coming.items()
            if future.done() and not future.cancelled() and future.exception() is None
        }
        if done.keys() == self.known.keys():
            return False
        self.known = done
        return True

    def close(self) -> None:
        """Stops looking."""
        self._thread.shutdown(wait=True, cancel_futures=True)


def find_defaults(env_id: str) -> Mapping[Preset, Config]:
    """The config of a new agent, by preset.

    Whatever the environment raises passes through.
    """
    env = make_env(env_id)
    try:
        spec = describe(env, None)
    finally:
        env.close()
    return {p: change_config(make_config(p, {}), settings_for(spec, p)) for p in Preset}
