"""The files that an entry point brings: ontologies, robots, scenes."""

from __future__ import annotations

from importlib.resources.abc import Traversable
from pathlib import Path

from skiros_py.plugins.loading import attempt, fault_of, load, refused
from skiros_py.plugins.origin import locate
from skiros_py.plugins.plugin import Entry, Plugin, PluginFault


def files_of(entry: Entry) -> tuple[Path, ...] | PluginFault:
    """Returns the files or folders that an entry point names.

    It names an object in a module: a ``pathlib.Path``, or what ``importlib.resources.files`` returns. Or it names a
    package, or a module in one: then it means the folder of the package, and in it the folder that is called like the
    group (``ontologies``, ``robots``, ``scenes``), where there is one. Only for an object code is run.
    """
    fault = refused(entry)
    if fault is not None:
        return fault
    return _named_object(entry) if entry.attribute else _of_package(entry)


def folder_of(entry: Entry) -> str:
    """Returns the name of the folder in which a package keeps what an entry point brings ("ontologies")."""
    return entry.group.partition(".")[2]


def _named_object(entry: Entry) -> tuple[Path, ...] | PluginFault:
    plugin = load(entry)
    if isinstance(plugin, PluginFault):
        return plugin
    return attempt(plugin, lambda: _named_by(plugin))


def _named_by(plugin: Plugin) -> tuple[Path, ...] | PluginFault:
    if isinstance(plugin.value, Path):
        return (plugin.value,)
    if isinstance(plugin.value, Traversable):
        return _unpacked(plugin.value) or plugin.fault(f"{plugin.value} lies in an archive: it must be files")
    kind = type(plugin.value).__name__
    return plugin.fault(f"it is a {kind}, nothing for {plugin.group.partition('.')[2]}: name a package, or a Path")


def _unpacked(value: Traversable) -> tuple[Path, ...]:
    """The folders behind a resource that is spread over several: those of a package without code."""
    return tuple(sorted({child.parent for child in value.iterdir() if isinstance(child, Path)}))


def _of_package(entry: Entry) -> tuple[Path, ...] | PluginFault:
    spec = locate(entry.module)
    if spec is None:
        gone = f"there is no package '{entry.module}': the entry point is stale;"
        return fault_of(entry, f"{gone} install {entry.distribution.name} again, or uninstall it")
    folders = [Path(folder) for folder in spec.submodule_search_locations or ()]
    if not folders and spec.origin and "." in entry.module:
        # A module that is in no package lies among those of all other distributions.
        folders = [Path(spec.origin).parent]
    if not folders:
        return fault_of(entry, f"{entry.module} is a module by itself and has no folder: name a package, or a Path")
    return tuple(inner if (inner := folder / folder_of(entry)).is_dir() else folder for folder in folders)
