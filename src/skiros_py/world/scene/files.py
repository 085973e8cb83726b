"""Scene files: reading, writing and replacing the scene of a world."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

from skiros_py.errors import FileError, WorldError
from skiros_py.world.change import Change, Writer
from skiros_py.world.index import collection_paused
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import Document, rdf_files, read_document
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners
from skiros_py.world.scene.atomic import write_atomically
from skiros_py.world.scene.diff import diff
from skiros_py.world.scene.reader import Reader, fault_of_all
from skiros_py.world.scene.robots import robot_document
from skiros_py.world.scene.writer import scene_turtle
from skiros_py.world.world import World


def load_scene(
    ontology: Ontology, path: Path, ontology_paths: Sequence[Path] = (), *, reasoners: Reasoners = NO_REASONERS
) -> World:
    """Reads a scene into a new world, as its first change, by author "scene".

    Imports of the scene are looked up by IRI among the ontology's files and ``ontology_paths``, never fetched; the
    individuals found there (a robot's) become part of the scene.

    Args:
        ontology: The ontology.
        path: The file: Turtle, RDF/XML or OWL/XML.
        ontology_paths: More files or folders in which imports are looked up.
        reasoners: The reasoners for computed relations in this world.

    Raises:
        FileError: A file is missing, in none of these languages, or violates the ontology; with the line if known.
    """
    world = World(ontology, reasoners=reasoners)
    with collection_paused():
        fill(world, _read(ontology, path, ontology_paths), "scene", f"read from {path.name}")
    return world


def fill(world: World, reader: Reader, author: str, reason: str) -> None:
    """Writes the scene that was read into a world, as one change.

    Raises:
        FileError: The ontology or a reasoner does not allow it; nothing was changed.
    """
    try:
        with world.transaction(author, reason, writer=Writer.SYSTEM) as tx:
            tx.apply(reader.edits())
    except WorldError as error:
        problems = tx.problems()
        if problems:
            raise fault_of_all(reader.files, world.ontology.names, problems) from None
        raise FileError(reader.files[0].path, str(error)) from None


def load_into(
    world: World,
    path: Path,
    author: str,
    ontology_paths: Sequence[Path] = (),
    *,
    writer: Writer = Writer.PERSON,
) -> Change | None:
    """Replaces the scene of a live world by that of a file, as one change; learned data is kept.

    Args:
        world: The world.
        path: The file.
        author: The author of the change.
        ontology_paths: More files or folders in which imports are looked up.
        writer: The kind of author.

    Returns:
        The change, or None if the world already matches the file.

    Raises:
        FileError: The file is refused, as by :func:`load_scene`; nothing was changed.
        WorldError: A lock or a reasoner does not allow the change; nothing was changed.
    """
    wanted = load_scene(world.ontology, path, ontology_paths, reasoners=world.reasoners).snapshot()
    with world.transaction(author, f"loaded {path.name}", writer=writer) as tx:
        tx.apply(diff(world.snapshot(), wanted))
    return tx.change


def save_scene(world: World, path: Path) -> None:
    """Writes the current state as a Turtle file, atomically; equal states give equal files.

    Imported individuals are written with the rest, so the file imports ontologies only.

    Raises:
        FileError: It cannot be written.
    """
    with collection_paused():
        write_atomically(path, scene_turtle(world.snapshot()))


def _read(ontology: Ontology, path: Path, ontology_paths: Sequence[Path]) -> Reader:
    reader = Reader(ontology)
    scene, *imported = _with_imports(read_document(path), ontology, ontology_paths)
    reader.take(scene, whole=True)
    for file in imported:
        reader.take(file)
    return reader


def _with_imports(scene: Document, ontology: Ontology, paths: Sequence[Path]) -> list[Document]:
    known = {file.iri: file for file in ontology.sources}
    read = {file.path.resolve() for file in ontology.sources}
    for file in (read_document(path) for path in rdf_files(paths) if path.resolve() not in read):
        known.setdefault(file.iri, file)
    files = {scene.iri: scene}
    waiting = [scene]
    for file in waiting:
        for iri in file.imports():
            if iri not in known and iri not in files:
                known[iri] = _of_a_plugin(iri, file, known)
            if iri not in files:
                files[iri] = known[iri]
                waiting.append(known[iri])
    return list(files.values())


def _of_a_plugin(iri: str, importer: Document, known: Collection[str]) -> Document:
    document, faults = robot_document(iri)
    if document is not None:
        return document
    found = ", ".join(f"<{name}>" for name in sorted(known)) or "none"
    broken = "".join(f"; {fault}" for fault in faults)
    raise importer.fault(f"imports <{iri}>, which no file at hand declares; these are declared: {found}{broken}", iri)
