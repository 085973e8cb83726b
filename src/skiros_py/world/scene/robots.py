"""Robots that plug-ins bring: files with their individuals, found by the IRI that a scene imports."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from skiros_py.errors import FileError
from skiros_py.plugins import Entry, Plugin, PluginFault, fault_of, files_of, installation, load, unambiguous
from skiros_py.ports.models import GROUP, RobotModel
from skiros_py.world.ontology.documents import Document, rdf_files, read_document


def robot_document(iri: str) -> tuple[Document | None, tuple[PluginFault, ...]]:
    """Looks among the plug-ins for the file that declares an IRI, and loads no more of them than needed.

    Args:
        iri: What a scene imports ("http://example.org/robots/crane"); the plug-in called like the last part of it is
            asked first.

    Returns:
        The file, or None; and the faults of plug-ins that were asked.
    """
    entries, faults = unambiguous(installation().of(GROUP))
    name = iri.rstrip("#/").rpartition("/")[2]
    broken = list(faults)
    for entry in sorted(entries, key=lambda entry: entry.name != name):
        for found in documents_of(entry):
            if isinstance(found, PluginFault):
                broken.append(found)
            elif found.iri == iri:
                return found, tuple(broken)
    return None, tuple(broken)


def documents_of(entry: Entry) -> Iterator[Document | PluginFault]:
    """Yields the files that an entry point brings, read; and what is wrong with it."""
    paths = _files(entry)
    if isinstance(paths, PluginFault):
        yield paths
        return
    files = rdf_files(paths)
    if paths and not files:
        yield fault_of(entry, f"there is no Turtle file below {paths[0]}")
    for file in files:
        try:
            yield read_document(file)
        except FileError as error:
            yield fault_of(entry, str(error))


def _files(entry: Entry) -> tuple[Path, ...] | PluginFault:
    plugin = load(entry) if entry.attribute else None
    if isinstance(plugin, Plugin) and isinstance(plugin.value, RobotModel):
        individuals = plugin.value.individuals
        return () if individuals is None else (individuals,)
    return files_of(entry)
