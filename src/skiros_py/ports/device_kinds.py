"""The kinds of device: found by the entry-point group ``skiros.devices``, the built-in ones like those of plug-ins."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any

from skiros_py.plugins.installation import Installation, installation
from skiros_py.plugins.loading import load_plugins
from skiros_py.plugins.plugin import Plugin, PluginFault
from skiros_py.ports.device import DeviceSpec

GROUP = "skiros.devices"
"""Entry points of this group name subclasses of :class:`~skiros_py.ports.device.DeviceSpec`."""

Kind = type[DeviceSpec[Any, Any]]


class DeviceKinds:
    """Kinds of device, by name.

    Args:
        kinds: The kinds.
        sources: The distribution of each, by name; none where they are not from plug-ins.
    """

    def __init__(self, kinds: Iterable[Kind], sources: Mapping[str, str] | None = None) -> None:
        self.by_name: Mapping[str, Kind] = {kind.kind: kind for kind in kinds}
        self._sources = sources or {}

    def describe(self, device: str, kind: Kind) -> str:
        """Names a device, its kind and the kind's distribution, for messages about a mistake in its code."""
        source = self._sources.get(kind.kind) if self.by_name.get(kind.kind) is kind else None
        return f"{device} (kind '{kind.kind}'{f' of {source}' if source else ''})"

    def of_class(self, class_: str, is_a: Callable[[str, str], bool]) -> Kind | None:
        """Returns the kind of devices of a class: the one with the most specific class; None for none.

        Args:
            class_: Class of a device.
            is_a: Tells whether the first class is the second, or below it.
        """
        fitting = [kind for kind in self.by_name.values() if is_a(class_, kind.device_class)]
        for kind in fitting:
            if all(is_a(kind.device_class, other.device_class) for other in fitting):
                return kind
        return None

    def signal_names(self, may_be: Callable[[str], bool] = lambda _class: True) -> frozenset[str]:
        """Returns the names of the signals that some devices offer: those whose class may be that of a kind."""
        kinds = (kind for kind in self.by_name.values() if may_be(kind.device_class))
        return frozenset(signal.name for kind in kinds for signal in kind.signals)


def load_device_kinds() -> tuple[DeviceKinds, tuple[PluginFault, ...]]:
    """Loads all kinds, in the order of their entry points' names, the built-in ones first.

    Returns:
        Those that can be used together; and the faults of the others, which affect no other. Of two plug-ins with
        one kind or class neither counts; a built-in kind stays.
    """
    return _loaded(installation())


@lru_cache(maxsize=1)
def _loaded(_installation: Installation) -> tuple[DeviceKinds, tuple[PluginFault, ...]]:
    plugins, broken = load_plugins(GROUP, device_problem)
    usable, faults = sorted(plugins, key=lambda plugin: not plugin.is_builtin), list(broken)
    good: list[Plugin] = []
    for plugin in usable:
        twins = [other for other in usable if _clash(plugin.value, other.value)]
        if len(twins) == 1 or plugin.is_builtin:
            good.append(plugin)
        else:
            faults.append(plugin.fault(_not_alone(twins)))
    sources = {plugin.value.kind: plugin.distribution for plugin in good}
    return DeviceKinds([plugin.value for plugin in good], sources), tuple(faults)


def device_problem(plugin: Plugin) -> str | None:
    """Returns why a plug-in is no kind of device, or None."""
    kind = plugin.value
    if not (isinstance(kind, type) and issubclass(kind, DeviceSpec)):
        return f"it is a {type(kind).__name__}, nothing for devices: name a subclass of DeviceSpec"
    for attribute in ("kind", "device_class"):
        if not isinstance(getattr(kind, attribute, None), str):
            return f"its {attribute} is no text"
    for attribute in ("jog", "teach"):
        if not isinstance(getattr(kind, attribute), tuple):
            return f"its {attribute} is no tuple of names of modules"
    missing = sorted(kind.__abstractmethods__) if inspect.isabstract(kind) else []
    return f"it does not define {', '.join(missing)}" if missing else None


def _clash(kind: Kind, other: Kind) -> bool:
    return kind.kind == other.kind or kind.device_class == other.device_class


def _not_alone(twins: Sequence[Plugin]) -> str:
    origins = " and ".join(
        f"'{twin.value.kind}' for {twin.value.device_class} ({twin.name} of {twin.distribution})" for twin in twins
    )
    count = "the built-in one counts" if any(twin.is_builtin for twin in twins) else "none of them counts"
    return f"kinds of device with one name or class: {origins}; {count}: rename one, or leave it out by --without"
