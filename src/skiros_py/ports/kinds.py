"""The kinds of device: found by the entry-point group ``skiros.devices``, the built-in ones like anyone's."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from typing import Any

from skiros_py.plugins import Installation, Plugin, PluginFault, installation, load_plugins
from skiros_py.ports.device import DeviceSpec

GROUP = "skiros.devices"
"""Entry points of this group name subclasses of :class:`~skiros_py.ports.device.DeviceSpec`."""

_OWN = "skiros-py "

Kind = type[DeviceSpec[Any, Any]]


class DeviceKinds:
    """Kinds of device, by name.

    Args:
        kinds: The kinds.
    """

    def __init__(self, kinds: Iterable[Kind]) -> None:
        self.by_name: Mapping[str, Kind] = {kind.kind: kind for kind in kinds}

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

    def signal_names(self) -> frozenset[str]:
        """Returns the names of all signals that devices of these kinds offer."""
        return frozenset(signal.name for kind in self.by_name.values() for signal in kind.signals)


def load_device_kinds() -> tuple[DeviceKinds, tuple[PluginFault, ...]]:
    """Loads all kinds, in the order of their entry points' names, the built-in ones first.

    Returns:
        Those that can be used together; and the faults of the others, which hurt nobody else.
    """
    return _loaded(installation())


@lru_cache(maxsize=1)
def _loaded(_installation: Installation) -> tuple[DeviceKinds, tuple[PluginFault, ...]]:
    plugins, broken = load_plugins(GROUP)
    good: dict[str, Kind] = {}
    faults = list(broken)
    for plugin in sorted(plugins, key=lambda plugin: not plugin.distribution.startswith(_OWN)):
        problem = device_problem(plugin) or _clash(plugin.value, good.values())
        if problem is None:
            good[plugin.value.kind] = plugin.value
        else:
            faults.append(plugin.fault(problem))
    return DeviceKinds(good.values()), tuple(faults)


def device_problem(plugin: Plugin) -> str | None:
    """Returns why a plug-in is no kind of device, or None."""
    kind = plugin.value
    if not (isinstance(kind, type) and issubclass(kind, DeviceSpec)):
        return f"it is a {type(kind).__name__}, nothing for devices: name a subclass of DeviceSpec"
    for attribute in ("kind", "device_class"):
        if not isinstance(getattr(kind, attribute, None), str):
            return f"its {attribute} is no text"
    missing = sorted(kind.__abstractmethods__) if inspect.isabstract(kind) else []
    return f"it does not define {', '.join(missing)}" if missing else None


def _clash(kind: Kind, others: Iterable[Kind]) -> str | None:
    for other in others:
        if kind.kind == other.kind or kind.device_class == other.device_class:
            return f"there is a kind '{other.kind}' for {other.device_class} already"
    return None
