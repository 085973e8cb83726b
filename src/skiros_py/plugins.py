"""Plug-ins by entry points: the built-ins use the same door as anyone's.

A plug-in that fails to load is reported with its name, version and traceback, and hurts nobody else.
"""

from __future__ import annotations

import traceback
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any

__all__ = ["Plugin", "PluginFault", "load_plugins"]


@dataclass(frozen=True, slots=True)
class Plugin:
    """One loaded entry point.

    Attributes:
        group: Entry-point group ("skiros.skills").
        name: Entry-point name.
        distribution: Distribution that brings it, with its version ("skiros-skills 0.1.0").
        value: The object it names.
    """

    group: str
    name: str
    distribution: str
    value: Any


@dataclass(frozen=True, slots=True)
class PluginFault:
    """An entry point that could not be loaded, with the traceback for its author."""

    group: str
    name: str
    distribution: str
    reason: str
    traceback: str

    def __str__(self) -> str:
        return f"plug-in {self.name} of {self.distribution} did not load: {self.reason}"


def load_plugins(group: str) -> tuple[tuple[Plugin, ...], tuple[PluginFault, ...]]:
    """Loads every entry point of a group, in the order of their names.

    Returns:
        What could be loaded, and what could not.
    """
    plugins: list[Plugin] = []
    faults: list[PluginFault] = []
    for entry in sorted(entry_points(group=group), key=lambda e: (e.name, e.value)):
        try:
            plugins.append(Plugin(group, entry.name, _distribution(entry), entry.load()))
        except Exception as error:  # noqa: BLE001 - somebody else's code: whatever it raises is reported, not spread
            reason = f"{type(error).__name__}: {error}"
            faults.append(PluginFault(group, entry.name, _distribution(entry), reason, traceback.format_exc()))
    return tuple(plugins), tuple(faults)


def _distribution(entry: EntryPoint) -> str:
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else "an unknown distribution"
