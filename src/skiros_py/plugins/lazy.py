"""Plug-ins of a group by name, each loaded when it is first asked for."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, TypeVar

from skiros_py.plugins.loading import examined, load
from skiros_py.plugins.plugin import Entry, Plugin, PluginFault

__all__ = ["LazyPlugins"]

T = TypeVar("T")
_log = logging.getLogger(__name__)


class LazyPlugins(Mapping[str, T]):
    """Looks like a mapping of those that can be used; one that turns out broken is logged, and is then not there.

    To ask for a name loads that one; to go through all loads all.

    Args:
        entries: Entry points, no two of one name.
        problem: Says what is wrong with a loaded one, or None.
    """

    def __init__(self, entries: Iterable[Entry], problem: Callable[[Plugin], str | None]) -> None:
        self._entries = {entry.name: entry for entry in entries}
        self._problem = problem
        self._loaded: dict[str, Any] = {}
        self._faults: dict[str, PluginFault] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all; nothing is loaded for it."""
        return tuple(self._entries)

    @property
    def faults(self) -> tuple[PluginFault, ...]:
        """Those that turned out broken so far."""
        return tuple(self._faults.values())

    def why_not(self, name: str) -> str | None:
        """Returns why the plug-in of that name cannot be used; None where it can, or there is none."""
        return None if name in self or name not in self._faults else str(self._faults[name])

    def load_all(self) -> None:
        """Loads all; nothing is logged: for who shows the faults anyway."""
        for name in self._entries:
            self._load(name)

    def __getitem__(self, name: str) -> T:
        fresh = name not in self._faults
        self._load(name)
        if name in self._faults:
            if fresh:
                _log.warning("%s", self._faults[name])
            raise KeyError(str(self._faults[name]))
        value: T = self._loaded[name]
        return value

    def __iter__(self) -> Iterator[str]:
        return iter([name for name in self._entries if name in self])

    def __len__(self) -> int:
        return sum(name in self for name in self._entries)

    def _load(self, name: str) -> None:
        if name in self._loaded or name in self._faults:
            return
        plugin = load(self._entries[name])
        if isinstance(plugin, Plugin):
            plugin = examined(plugin, self._problem)
        if isinstance(plugin, PluginFault):
            self._faults[name] = plugin
        else:
            self._loaded[name] = plugin.value
