"""Robots that plug-ins bring: files with their individuals, found by the IRI that a scene imports."""

from __future__ import annotations

from collections.abc import Iterator

from skiros_py.errors import FileError
from skiros_py.plugins import Entry, PluginFault, fault_of, files_of, installation, unambiguous
from skiros_py.world.ontology.documents import Document, rdf_files, read_document

__all__ = ["GROUP", "documents_of", "robot_document"]

GROUP = "skiros.robots"
"""Entry points of this group name files with the individuals of robots, in the manner of ontologies."""


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
    paths = files_of(entry)
    if isinstance(paths, PluginFault):
        yield paths
        return
    files = rdf_files(paths)
    if not files:
        yield fault_of(entry, f"there is no Turtle file below {paths[0]}")
    for file in files:
        try:
            yield read_document(file)
        except FileError as error:
            yield fault_of(entry, str(error))
