"""Adapters: implementations of ports, found by the entry-point group ``skiros.adapters`` and asked for by protocol.

A motion planner, kinematics, a part detector: modules name the protocol and the device, never the library behind it.
Where several could serve a device, its individual or its robot's names one (``sk:adapter``); otherwise, adapters of
other distributions take precedence over the built-in ones.
"""

from __future__ import annotations

import logging
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

from skiros_py.errors import DeviceError, UnknownName, UsageError
from skiros_py.interruptions import limited
from skiros_py.plugins.loading import load_plugins
from skiros_py.plugins.plugin import Plugin
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.device import DeviceSpec

GROUP = "skiros.adapters"
"""Entry points of this group name objects of class :class:`Adapter`."""

_LONGEST = 60.0
"""Wall time in which an adapter has to be made [s]."""

T = TypeVar("T")
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Request:
    """What an adapter is made for.

    Attributes:
        groups: The robots, and the devices without one, that it will serve: one, or all of the cell.
        device: The device that it will serve; None for an adapter of a robot or of the whole cell.
        ports: Where it finds the adapters that it needs itself.
    """

    groups: tuple[RobotSpec, ...]
    device: DeviceSpec[Any, Any] | None
    ports: Ports


@dataclass(frozen=True, slots=True)
class Adapter:
    """How to make an implementation of a port.

    Attributes:
        ports: The protocols that it implements.
        make: Makes the implementation; where that has a ``close``, it is called at the end.
        serves: Tells whether it can serve a device.
        one_for: What shares an implementation: the whole cell, one robot, or one device.
        eager: True for one that takes long to start: it is made when the session opens, and ``make`` returns at once.
        without_physics: True for one that cells without physics use, too.
        by_name: True for one that serves only devices that name it (``sk:adapter``).
    """

    ports: tuple[type, ...]
    make: Callable[[Request], object]
    serves: Callable[[DeviceSpec[Any, Any]], bool] = lambda _device: True
    one_for: Literal["cell", "robot", "device"] = "cell"
    eager: bool = True
    without_physics: bool = False
    by_name: bool = False


class Ports(ABC):
    """Finds adapters by protocol."""

    @abstractmethod
    def find(self, protocol: Callable[..., T], device: str | None = None) -> T | None:
        """Returns the adapter for a device, or for the cell; None where there is none, or it depends on the device.

        Args:
            protocol: The port's protocol (``ArmPlanner``).
            device: Id of the device; None for an adapter that needs none.
        """

    def port(self, protocol: Callable[..., T], device: str | None = None) -> T:
        """Returns the adapter for a device, or for the cell.

        Raises:
            DeviceError: There is none, or it cannot be made; the message names the port and the device.
        """
        adapter = self.find(protocol, device)
        if adapter is None:
            raise DeviceError(f"no adapter for {_name(protocol, device)}: none of those that are installed serves it")
        return adapter


class GivenPorts(Ports):
    """Adapters that are given as objects, for any device; for tests and for cells that need none.

    Args:
        adapters: By protocol.
    """

    def __init__(self, adapters: Mapping[Any, object] | None = None) -> None:
        self._adapters = dict(adapters or {})

    def find(self, protocol: Callable[..., T], device: str | None = None) -> T | None:  # noqa: ARG002 - one for all
        """Returns the adapter; None where there is none."""
        return self._adapters.get(protocol)


class InstalledPorts(Ports):
    """The adapters of a cell that are installed; each is made when it is first asked for.

    Args:
        groups: The robots and the devices without one.
        physics: False for a cell without physics.

    Raises:
        UnknownName: A device names an adapter that is not installed.
        UsageError: Several adapters of other distributions serve the same port and device, and it does not name one;
            or the adapter that a device or robot names does not serve it.
    """

    def __init__(self, groups: Sequence[RobotSpec], *, physics: bool = True) -> None:
        self._groups = {device.id: group for group in groups for device in group.devices}
        self._all = tuple(groups)
        plugins, faults = load_plugins(GROUP, adapter_problem)
        for fault in faults:
            _log.warning("%s", fault)
        self._named = {
            device: dict(group.adapters).get(device) or dict(group.adapters).get(group.id, ())
            for device, group in self._groups.items()
        }
        for group in groups:
            for by, names in group.adapters:
                self._require_serving(plugins, by, names)
        self._plugins = [plugin for plugin in plugins if physics or plugin.value.without_physics]
        self._made: dict[tuple[str, str], object] = {}
        self._chosen: dict[tuple[Any, str | None], Plugin | None] = {}
        for plugin in self._plugins:
            for protocol in plugin.value.ports:
                for device in (None, *self._groups):
                    self._choose(protocol, device)

    def start(self) -> None:
        """Makes the adapters that take long to start, so that they start side by side."""
        for (_, device), plugin in tuple(self._chosen.items()):
            if plugin is not None and plugin.value.eager:
                self._get(plugin, device)

    def find(self, protocol: Callable[..., T], device: str | None = None) -> T | None:
        """Returns the adapter for a device, or for the cell; None where there is none."""
        plugin = self._chosen.get((protocol, device))
        return None if plugin is None else self._get(plugin, device)  # type: ignore[return-value]

    def close(self) -> None:
        """Closes all adapters, the last one first; may be called twice."""
        while self._made:
            _, adapter = self._made.popitem()
            close = getattr(adapter, "close", None)
            if close is not None:
                close()

    def _require_serving(self, plugins: Sequence[Plugin], by: str, names: Sequence[str]) -> None:
        """Requires that each adapter that a device names serves it; for one that a robot names, one of its devices."""
        devices = [by] if by in self._groups else [device for device, group in self._groups.items() if group.id == by]
        for name in names:
            named = [plugin for plugin in plugins if plugin.name == name]
            if not named:
                raise UnknownName("adapter", name, [plugin.name for plugin in plugins], where=f"of {by} (sk:adapter)")
            if not any(self._serves(plugin, device) for plugin in named for device in devices):
                good = sorted({p.name for p in plugins if any(self._serves(p, device) for device in devices)})
                served = ", ".join(good) or "none"
                raise UsageError(f"{by} names adapter '{name}' (sk:adapter), which does not serve it; {served} would")

    def _choose(self, protocol: Any, device: str | None) -> None:
        if (protocol, device) in self._chosen:
            return
        fitting = [
            plugin for plugin in self._plugins if protocol in plugin.value.ports and self._serves(plugin, device)
        ]
        names = {name for by, all_ in self._named.items() if device in (None, by) for name in all_}
        named = [plugin for plugin in fitting if plugin.name in names]
        fitting = named or [plugin for plugin in fitting if not plugin.value.by_name]
        foreign = named or [plugin for plugin in fitting if not plugin.is_builtin]
        if len(foreign) > 1 and device is None and named:
            foreign, fitting = [], []  # it depends on the device
        if len(foreign) > 1:
            origins = " and ".join(f"{plugin.name} of {plugin.distribution}" for plugin in foreign)
            hint = "name one of them by sk:adapter, or uninstall all but one"
            raise UsageError(f"more than one adapter for {_name(protocol, device)}: {origins}; {hint}")
        self._chosen[protocol, device] = next(iter((*foreign, *fitting)), None)

    def _serves(self, plugin: Plugin, device: str | None) -> bool:
        adapter: Adapter = plugin.value
        if device is None:
            return adapter.one_for == "cell"
        try:
            return adapter.serves(self._groups[device].device(device))
        except Exception as error:  # noqa: BLE001 - a plug-in's code: the cell does without it
            text = "adapter '%s' of %s is not used for %s: its serves raised %s: %s"
            _log.warning(text, plugin.name, plugin.distribution, device, type(error).__name__, error)
            return False

    def _get(self, plugin: Plugin, device: str | None) -> object:
        adapter: Adapter = plugin.value
        group = None if device is None or adapter.one_for == "cell" else self._groups[device]
        shared_by = "" if group is None else group.id if adapter.one_for == "robot" else device or ""
        key = plugin.name, shared_by
        if key not in self._made:
            spec = group.device(device) if group is not None and device and adapter.one_for == "device" else None
            try:
                request = Request((group,) if group is not None else self._all, spec, self)
                self._made[key] = limited(lambda: "make", _LONGEST, lambda: adapter.make(request))
            except (DeviceError, UnknownName, UsageError):
                raise
            except Exception as error:
                source = f"adapter '{plugin.name}' of {plugin.distribution}"
                raise DeviceError(f"{source} breaks: {type(error).__name__}: {error}") from error
        return self._made[key]


def adapter_problem(plugin: Plugin) -> str | None:
    """Returns why a plug-in is no adapter, or None."""
    if not isinstance(plugin.value, Adapter):
        return f"it is a {type(plugin.value).__name__}, nothing for adapters: name an Adapter"
    return None if plugin.value.ports else "it names no port: ports=(ArmPlanner,)"


def _name(protocol: Any, device: str | None) -> str:
    return protocol.__name__ if device is None else f"{protocol.__name__} of {device}"


NO_PORTS = GivenPorts()
"""Where there are no adapters."""
