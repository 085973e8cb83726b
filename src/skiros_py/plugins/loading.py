"""Loads entry points and the files they bring; errors in their code are reported and contained."""

from __future__ import annotations

import faulthandler
import logging
import os
import sys
import threading
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import replace
from functools import partial
from importlib.metadata import EntryPoint
from importlib.resources.abc import Traversable
from pathlib import Path
from threading import RLock
from typing import Any, NoReturn, TypeVar

from skiros_py.errors import SkirosError, UnknownName, UsageError
from skiros_py.interruptions import by_user, limited
from skiros_py.plugins.installation import installation, misfit
from skiros_py.plugins.plugin import Entry, Plugin, PluginFault, authors_line, locate, origin_of

T = TypeVar("T")

_LONGEST = 60.0
"""Wall time in which a plug-in has to be loaded [s]."""
_LOADING = RLock()
"""Two threads that redirect stdout at once would leave it redirected."""


def load_plugins(
    group: str, problem: Callable[[Plugin], str | None] = lambda _: None
) -> tuple[tuple[Plugin, ...], tuple[PluginFault, ...]]:
    """Loads every entry point of a group, in the order of their names.

    Args:
        group: The group ("skiros.engines").
        problem: Returns the problem of a loaded plug-in, or None.

    Returns:
        The usable plug-ins, and the faults of the others.
    """
    loaded = [load(entry, problem) for entry in installation().of(group)]
    plugins = tuple(one for one in loaded if isinstance(one, Plugin))
    return plugins, tuple(one for one in loaded if isinstance(one, PluginFault))


def find_plugin(group: str, name: str, *, kind: str = "") -> Any:
    """Loads the one entry point of a group that has a name, and returns what it names.

    Args:
        group: The group ("skiros.engines").
        name: Name of the entry point; of a qualified one ("lab.pick") also its own, if no other has that.
        kind: Its kind, for messages; by default, that of the group ("engine").

    Raises:
        UnknownName: There is none.
        UsageError: It cannot be loaded; the text gives the reason and the distribution.
    """
    kind = kind or group.partition(".")[2].removesuffix("s")
    entries = installation().of(group)
    offered = names_understood(entries)
    entry = next((entry for entry in entries if entry.name == offered.get(name)), None)
    if entry is None:
        raise UnknownName(kind, name, [entry.name for entry in entries])
    found = load(entry)
    if isinstance(found, PluginFault):
        raise UsageError(f"{kind} '{name}' cannot be used: {found} (skiros plugins {name} shows it in full)")
    return found.value


def names_understood(entries: Sequence[Entry]) -> Mapping[str, str]:
    """Returns the names under which entry points of a group are offered: by these, and by own names that one has."""
    own = [entry.own_name for entry in entries]
    only = {entry.own_name: entry.name for entry in entries if own.count(entry.own_name) == 1}
    return only | {entry.name: entry.name for entry in entries}


def load(entry: Entry, problem: Callable[[Plugin], str | None] = lambda _: None) -> Plugin | PluginFault:
    """Loads one entry point, unless its distribution requires another skiros-py.

    Args:
        entry: The entry point.
        problem: Returns the problem of the loaded plug-in, or None.

    Raises:
        KeyboardInterrupt: The user's.
    """
    fault = refused(entry)
    if fault is not None:
        return fault
    try:
        with _LOADING, redirect_stdout(sys.stderr), _staying_alive():  # stdout is the command's answer
            point = EntryPoint(entry.name, entry.value, entry.group)
            value = limited(lambda: f"loading plug-in {entry.name} of {entry.distribution}", _LONGEST, point.load)
        plugin = Plugin(entry.group, entry.name, str(entry.distribution), value, entry.module, entry.declared)
        reason = problem(plugin)
    except BaseException as error:
        if by_user(error):
            raise
        return _contained(entry, error)
    return plugin.fault(reason) if reason else plugin


@contextmanager
def _staying_alive() -> Iterator[None]:
    """Lets ``os._exit`` raise in this thread: code of a plug-in must not end the program; a crash shows its stack."""
    leave, loading, shows = os._exit, [(os.getpid(), threading.get_ident())], faulthandler.is_enabled()

    def refuse(status: int) -> NoReturn:
        if (os.getpid(), threading.get_ident()) not in loading:
            leave(status)
        raise SystemExit(f"it tried to end the program: os._exit({status})")

    os._exit = refuse
    if not shows and sys.__stderr__ is not None:
        faulthandler.enable(sys.__stderr__)
    try:
        yield
    finally:
        os._exit = leave
        loading.clear()  # it may have kept the function
        if not shows:
            faulthandler.disable()


def refused(entry: Entry) -> PluginFault | None:
    """Returns the fault of an entry point that is known before running its code, or None."""
    if not entry.is_well_formed:
        return fault_of(entry, f"'{entry.value}' names nothing: write module:object")
    reason = misfit(entry.distribution)
    return fault_of(entry, str(reason)) if reason else None


def _contained(entry: Entry, error: BaseException) -> PluginFault:
    """Makes the fault for what a plug-in's code raised."""
    trace = "".join(traceback.format_exception(error))
    if isinstance(error, ModuleNotFoundError) and locate(entry.module) is None:
        gone = f"ModuleNotFoundError: No module named '{entry.module}': the entry point is stale;"
        return fault_of(entry, f"{gone} install {entry.distribution.name} again, or uninstall it", trace)
    return _located(fault_of(entry, _told(error), trace), error)


def _located(fault: PluginFault, error: BaseException) -> PluginFault:
    """Adds the author's line to a fault; if the platform itself describes the mistake, that replaces the traceback."""
    unknown = error.kind if isinstance(error, UnknownName) else ""
    if not isinstance(error, SkirosError) or (frame := authors_line(fault.traceback)) is None:
        return replace(fault, unknown=unknown)
    return replace(fault, unknown=unknown, traceback="", origin=str(frame[0]), line=frame[1])


def attempt(plugin: Plugin, look: Callable[[], T]) -> T | PluginFault:
    """Calls a function that may run the author's code of a plug-in; any exception becomes its fault.

    Raises:
        KeyboardInterrupt: The user's.
    """
    try:
        return look()
    except BaseException as error:
        if by_user(error):
            raise
        return _located(plugin.fault(_told(error), "".join(traceback.format_exception(error))), error)


def fault_of(entry: Entry, reason: str, trace: str = "") -> PluginFault:
    """Makes the fault of an entry point."""
    return PluginFault(entry.group, entry.name, str(entry.distribution), reason, trace, origin_of(entry.module))


def _told(error: BaseException) -> str:
    try:
        return f"{type(error).__name__}: {error}"
    except BaseException:  # noqa: BLE001 - the error is somebody else's code, too
        return f"{type(error).__name__}, which does not say what"


# ---------------------------------------------------------------- loaded when first asked for


_log = logging.getLogger(__name__)


class LazyPlugins(Mapping[str, T]):
    """A mapping of the usable plug-ins of a group; faulty ones are logged and left out.

    Access by name loads one plug-in; iterating loads all.

    Args:
        entries: Entry points, no two of one name.
        problem: Returns the problem of a loaded one, or None.
        offered: Returns what is offered of a loaded one.
    """

    def __init__(
        self,
        entries: Iterable[Entry],
        problem: Callable[[Plugin], str | None],
        offered: Callable[[Plugin], T] = lambda plugin: plugin.value,
    ) -> None:
        self._entries = {entry.name: entry for entry in entries}
        self._understood = names_understood(list(self._entries.values()))
        self._problem = problem
        self._offered = offered
        self._loaded: dict[str, Any] = {}
        self._faults: dict[str, PluginFault] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all; loads nothing."""
        return tuple(self._entries)

    @property
    def faults(self) -> tuple[PluginFault, ...]:
        """The faults found so far."""
        return tuple(self._faults.values())

    def why_not(self, name: str) -> str | None:
        """Returns why the plug-in of that name cannot be used; None if it can, or there is none."""
        return None if name in self or name not in self._faults else str(self._faults[name])

    def load_all(self) -> None:
        """Loads all without logging, for callers that show the faults themselves."""
        for name in self._entries:
            self._load(name)

    def __getitem__(self, name: str) -> T:
        name = self._understood.get(name, name)
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
        plugin = load(self._entries[name], self._problem)
        offered = plugin if isinstance(plugin, PluginFault) else attempt(plugin, partial(self._offered, plugin))
        if isinstance(offered, PluginFault):
            self._faults[name] = offered
        else:
            self._loaded[name] = offered


def files_of(entry: Entry) -> tuple[Path, ...] | PluginFault:
    """Returns the files or folders that an entry point names.

    It names an object in a module: a ``pathlib.Path``, or the result of ``importlib.resources.files``. Or it names a
    package, or a module in one: then the files are in the folder of the package, or in its folder named like the group
    (``ontologies``, ``robots``, ``scenes``), if there is one. Code is run for an object only.
    """
    fault = refused(entry)
    if fault is not None:
        return fault
    if not entry.attribute:
        return _of_package(entry)
    plugin = load(entry)
    return plugin if isinstance(plugin, PluginFault) else attempt(plugin, lambda: _named_by(plugin))


def folder_of(entry: Entry) -> str:
    """Returns the name of the folder with the files of an entry point in a package ("ontologies")."""
    return entry.group.partition(".")[2]


def _named_by(plugin: Plugin) -> tuple[Path, ...] | PluginFault:
    if isinstance(plugin.value, Path):
        return (plugin.value,)
    if isinstance(plugin.value, Traversable):
        return _unpacked(plugin.value) or plugin.fault(f"{plugin.value} lies in an archive: it must be files")
    kind = type(plugin.value).__name__
    return plugin.fault(f"it is a {kind}, nothing for {plugin.group.partition('.')[2]}: name a package, or a Path")


def _unpacked(value: Traversable) -> tuple[Path, ...]:
    """The folders of a resource that has several: those of a package without code."""
    return tuple(sorted({child.parent for child in value.iterdir() if isinstance(child, Path)}))


def _of_package(entry: Entry) -> tuple[Path, ...] | PluginFault:
    spec = locate(entry.module)
    if spec is None:
        gone = f"there is no package '{entry.module}': the entry point is stale;"
        return fault_of(entry, f"{gone} install {entry.distribution.name} again, or uninstall it")
    folders = [Path(folder) for folder in spec.submodule_search_locations or ()]
    if not folders and spec.origin and "." in entry.module:
        # A module outside of a package is in a folder with those of other distributions.
        folders = [Path(spec.origin).parent]
    if not folders:
        return fault_of(entry, f"{entry.module} is a module by itself and has no folder: name a package, or a Path")
    return tuple(inner if (inner := folder / folder_of(entry)).is_dir() else folder for folder in folders)
