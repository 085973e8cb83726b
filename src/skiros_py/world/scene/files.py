"""Scene files: a world is read from one and written to one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from skiros_py.world.change import Writer
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import Document, rdf_files, read_document
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners
from skiros_py.world.scene.reader import SceneReader
from skiros_py.world.scene.writer import scene_turtle, write_atomically
from skiros_py.world.world import World

__all__ = ["load_scene", "save_scene", "scene_goals"]


def load_scene(
    ontology: Ontology, path: Path, ontology_paths: Sequence[Path] = (), *, reasoners: Reasoners = NO_REASONERS
) -> World:
    """Reads a scene into a new world, as its first change, by author "scene".

    What the scene imports is looked up by IRI among the ontology's files and ``ontology_paths``, never fetched; the
    individuals found there (a robot's) become part of the scene.

    Args:
        ontology: What may be.
        path: The Turtle file.
        ontology_paths: More files or folders in which imports are looked up.
        reasoners: What works out computed relations in this world.

    Raises:
        FileError: A file is missing, not Turtle, or says what the ontology does not allow; with the line where known.
    """
    scene = read_document(path)
    reader = SceneReader(ontology)
    for file in _with_imports(scene, ontology, ontology_paths):
        reader.take(file)
    for triple in scene.triples:
        reader.check_subject(scene, triple)
    world = World(ontology, reasoners=reasoners)
    with world.transaction("scene", f"read from {path.name}", writer=Writer.SYSTEM) as tx:
        reader.write(tx)
        tx.set_goals(reader.goals())
        problems = tx.problems()
        if problems:
            raise reader.fault(scene, problems)
    return world


def scene_goals(world: World) -> tuple[str, ...]:
    """Returns the texts of the goals that go with the scene, sorted."""
    return world.goals


def save_scene(world: World, path: Path) -> None:
    """Writes the present state as a scene file, whole or not at all; equal states give equal files.

    Imported individuals are written with the rest, so the file imports ontologies only.

    Raises:
        FileError: It cannot be written.
    """
    write_atomically(path, scene_turtle(world))


def _with_imports(scene: Document, ontology: Ontology, paths: Sequence[Path]) -> list[Document]:
    known = {file.iri: file for file in ontology.sources}
    read = {file.path.resolve() for file in ontology.sources}
    for file in (read_document(path) for path in rdf_files(paths) if path.resolve() not in read):
        known.setdefault(file.iri, file)
    files = [scene]
    for file in files:
        for iri in file.imports():
            if iri not in known:
                found = ", ".join(f"<{name}>" for name in sorted(known)) or "none"
                raise file.fault(f"imports <{iri}>, which no file at hand declares; these are declared: {found}", iri)
            if known[iri] not in files:
                files.append(known[iri])
    return files
