"""The ontology as installed: the files shipped and configured, and those that plug-ins bring."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from skiros_py.errors import FileError
from skiros_py.plugins import Entry, PluginFault, fault_of, files_of, installation, unambiguous
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
            culprit = next((entry for entry, own in files.items() if error.path in own), None)
            if culprit is None:
                raise
            del files[culprit]
            faults.append(fault_of(culprit, str(error)))


def plugin_files() -> tuple[dict[Entry, list[Path]], list[PluginFault]]:
    """Returns the ontology files of every plug-in, in the order of their names; and what is wrong with the others."""
    entries, twins = unambiguous(installation().of(_GROUP))
    files: dict[Entry, list[Path]] = {}
    broken = list(twins)
    for entry in entries:
        paths = files_of(entry)
        if isinstance(paths, PluginFault):
            broken.append(paths)
        elif own := rdf_files(paths):
            files[entry] = own
        else:
            broken.append(fault_of(entry, f"there is no ontology file below {paths[0]}"))
    return files, broken
