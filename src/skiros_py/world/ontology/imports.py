"""Finds imported ontologies in local folders; nothing is ever fetched.

The file of an IRI is the one that the XML catalogue of a folder names (``catalog-v001.xml`` of OASIS, as Protégé writes
it): of the importing file's folder, or of one of :func:`~skiros_py.config.import_paths`. Else it is the file in one of
the latter that declares the IRI.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import replace
from functools import cache, cached_property
from pathlib import Path
from urllib.parse import unquote, urlsplit

from skiros_py.config import IMPORTS, import_paths
from skiros_py.errors import FileError
from skiros_py.files import read_text
from skiros_py.world.ontology.documents import Document, rdf_files, read_document
from skiros_py.world.ontology.formats import outline_xml

_log = logging.getLogger(__name__)

CATALOGUE = "catalog-v001.xml"
"""Name of the file in a folder that says which file an IRI stands for."""


class ImportFolders:
    """The folders in which imported ontologies are looked up.

    Args:
        folders: The folders.
    """

    def __init__(self, folders: Iterable[Path]) -> None:
        self._folders = tuple(folders)

    def find(self, iri: str, importer: Path) -> Document | None:
        """Returns the ontology with an IRI, or None.

        Args:
            iri: The IRI.
            importer: The file that imports it.

        Raises:
            FileError: Its file, or a catalogue, is missing or wrong.
        """
        for folder in dict.fromkeys((importer.parent, *self._folders)):
            if (path := _catalogued(folder).get(iri)) is not None:
                return replace(read_document(path), aliases=(iri,))
        return self._declared.get(iri)

    @cached_property
    def _declared(self) -> dict[str, Document]:
        found: dict[str, Document] = {}
        for path in rdf_files(self._folders):
            try:
                document = read_document(path)
            except FileError as error:
                _log.warning("an ontology for imports cannot be read: %s", error)
            else:
                found = dict.fromkeys(document.iris(), document) | found
        return found


@cache
def _catalogued(folder: Path) -> dict[str, Path]:
    """The files that the catalogue of a folder names, by IRI; addresses in the network are passed over.

    Raises:
        FileError: The catalogue cannot be read.
    """
    path = folder / CATALOGUE
    if not path.is_file():
        return {}
    uris = {iri: urlsplit(uri) for iri, uri in outline_xml(path, read_text(path)).uris.items()}
    return {iri: folder / unquote(uri.path) for iri, uri in uris.items() if uri.scheme in ("", "file")}


def with_imports(files: Iterable[Document], others: Iterable[Document] = ()) -> list[Document]:
    """Returns some files with the ontologies that they import, directly or indirectly, and that local folders hold.

    Args:
        files: The files.
        others: Files that are at hand, too.

    Raises:
        FileError: A file that is imported is missing or wrong.
    """
    found = list(files)
    at_hand = {iri for file in (*found, *others) for iri in file.iris()}
    folders = ImportFolders(import_paths())
    for file in found:
        for iri in file.imports():
            document = None if iri in at_hand else folders.find(iri, file.path)
            if document is not None and document.iri not in at_hand:
                found.append(document)
                at_hand |= document.iris()
    return found


def where_to_put(iris: Iterable[str]) -> str:
    """Returns which imported ontologies are missing, and what to do, for people."""
    names = ", ".join(f"<{iri}>" for iri in sorted(iris))
    return (
        f"{names}: put the files into a folder that --imports or {IMPORTS} names, where they are found by their IRIs or"
        f" by a {CATALOGUE}; nothing is fetched from the network"
    )
