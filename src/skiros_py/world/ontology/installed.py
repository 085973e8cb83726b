"""The ontology as installed: the files shipped and configured, and those that plug-ins bring."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from skiros_py.errors import FileError
from skiros_py.plugins import Plugin, PluginFault, load_plugins
from skiros_py.world.ontology.documents import rdf_files
from skiros_py.world.ontology.ontology import Ontology

__all__ = ["load_installed", "plugin_files"]

_GROUP = "skiros.ontologies"


def load_installed(paths: Sequence[Path]) -> tuple[Ontology, tuple[PluginFault, ...]]:
    """Loads the files of some paths and those that plug-ins of the group ``skiros.ontologies`` bring.

    An entry point names a package, a module in a package, or a ``pathlib.Path``: all ontology files below its folder
    (below the folder ``ontologies`` in it, where there is one) are taken. A plug-in whose files cannot be read, or do
    not go with the others, is left out and reported; the rest is as if it were not installed.

    Args:
        paths: Files or folders that must be right.

    Returns:
        The ontology, and the faults of plug-ins.

    Raises:
        FileError: A file of the paths is wrong.
    """
    files, broken = plugin_files()
    faults = list(broken)
    while True:
        try:
            return Ontology.load([*paths, *(file for own in files.values() for file in own)]), tuple(faults)
        except FileError as error:
            culprit = next((plugin for plugin, own in files.items() if error.path in own), None)
            if culprit is None:
                raise
            del files[culprit]
            faults.append(_fault(culprit, str(error)))


def plugin_files() -> tuple[dict[Plugin, list[Path]], list[PluginFault]]:
    """Returns the ontology files of every plug-in, in the order of their names; and what is wrong with the others."""
    plugins, faults = load_plugins(_GROUP)
    files: dict[Plugin, list[Path]] = {}
    broken = list(faults)
    for plugin in plugins:
        folders = _folders(plugin.value)
        own = rdf_files(folders)
        if own:
            files[plugin] = own
        elif folders:
            broken.append(_fault(plugin, f"there is no ontology file below {folders[0]}"))
        else:
            reason = f"it is a {type(plugin.value).__name__}, nothing for ontologies: name a package, or a Path"
            broken.append(_fault(plugin, reason))
    return files, broken


def _folders(value: Any) -> list[Path]:
    """Where the files of an entry point are; nowhere for what names no folder of its own."""
    if isinstance(value, Path):
        return [value]
    if not isinstance(value, ModuleType):
        return []
    folders = [Path(folder) for folder in getattr(value, "__path__", ())]
    if not folders and value.__file__ and "." in value.__name__:
        # A module that is in no package lies among those of all other distributions.
        folders = [Path(value.__file__).parent]
    return [inner if (inner := folder / "ontologies").is_dir() else folder for folder in folders]


def _fault(plugin: Plugin, reason: str) -> PluginFault:
    return PluginFault(plugin.group, plugin.name, plugin.distribution, reason, "")
