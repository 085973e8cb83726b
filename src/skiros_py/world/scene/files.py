"""Scene files: reading, comparing, writing atomically, and replacing the scene of a world."""

from __future__ import annotations

import os
import secrets
import stat
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from skiros_py.config import ONTOLOGIES
from skiros_py.errors import FileError, WorldError
from skiros_py.files import open_private
from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.plugins.installation import installation
from skiros_py.plugins.loading import fault_of, files_of, load
from skiros_py.plugins.plugin import Entry, Plugin, PluginFault
from skiros_py.ports.kinematics import GROUP, RobotModel
from skiros_py.world.change import (
    Edit,
    ElementEdit,
    GoalsEdit,
    PlacementEdit,
    PropertyEdit,
    SceneSource,
    SourceEdit,
    Writer,
)
from skiros_py.world.element import Element, Placement, Value, is_abstract
from skiros_py.world.index import Index, collection_paused
from skiros_py.world.literals import format_value, shown
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import Document, rdf_files, read_document
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners
from skiros_py.world.scene.reader import Reader, fault_of_all
from skiros_py.world.scene.writer import scene_turtle
from skiros_py.world.workspace import Workspace
from skiros_py.world.world import World


def write_atomically(path: Path, text: str, *, private: bool = False) -> None:
    """Writes a text file such that after a crash or power loss either the new or the old one is complete.

    The permissions of the old file are kept; a symbolic link still points to the written file.

    Args:
        path: The file.
        text: Its content.
        private: True for a file that only its owner may read, from the first byte.

    Raises:
        FileError: It cannot be written; the old file is unchanged.
    """
    try:
        _replace(Path(os.path.realpath(path)), text.encode(), private=private)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(path, f"cannot be written ({reason}); nothing was changed") from error
    try:
        _flush_folder(Path(os.path.realpath(path)).parent)
    except OSError as error:
        raise FileError(path, f"is written, but may not survive a power cut ({error.strerror})") from error


def _replace(path: Path, content: bytes, *, private: bool) -> None:
    new = path.with_name(f".{path.name[:40]}.{secrets.token_hex(4)}.tmp")
    try:
        with open(new, "xb", opener=open_private if private else None) as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        if path.exists() and not private:
            new.chmod(stat.S_IMODE(path.stat().st_mode))
        new.replace(path)
    except BaseException:
        new.unlink(missing_ok=True)
        raise


def _flush_folder(folder: Path) -> None:
    """Makes the new directory entry durable, not only the contents."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


_Statement = tuple[str, str, str]


def diff(old: Index, new: Index) -> tuple[Edit, ...]:
    """Returns the edits that turn the scene of one state into that of another, in an applicable order.

    Abstract elements (the ontology's individuals and learned data) are not part of a scene. An element with another
    class in the new state counts as a different one: it is removed and added. Poses that are written identically count
    as equal.
    """
    work = Workspace(old)
    work.view = new.copy()
    work.view.source = old.source  # the file of a scene is not part of it
    work.touched = {name for name in _scene(old) | _scene(new) if _known(old, name) != _known(new, name)}
    work.pairs = _relations(old) ^ _relations(new)
    return tuple(edit for edit in work.edits() if not _is_within_rounding(edit))


def describe(edits: Iterable[Edit]) -> Iterator[str]:
    """Yields a line for each edit: what was added (``+``), removed (``-``) or changed (``~``)."""
    for edit in edits:
        if isinstance(edit, ElementEdit):
            yield _element(edit)
        elif isinstance(edit, PlacementEdit):
            yield _change(edit.element, _placed(edit.old), _placed(edit.new))
        elif isinstance(edit, PropertyEdit):
            texts = (_value(value) for value in (edit.old, edit.new))
            yield _change(f"{edit.element} {edit.property}", *texts)
        elif isinstance(edit, GoalsEdit):
            yield from (f"- goal {goal}" for goal in edit.old if goal not in edit.new)
            yield from (f"+ goal {goal}" for goal in edit.new if goal not in edit.old)
        elif isinstance(edit, SourceEdit):
            yield _change("scene", edit.old.name, edit.new.name)
        else:
            yield f"{'+' if edit.new else '-'} {edit.subject} {edit.relation} {edit.object}"


def _scene(index: Index) -> set[str]:
    return {name for name in index.ids() if not is_abstract(name)}


def _known(index: Index, name: str) -> tuple[Element, Placement | None] | None:
    return (index.element(name), index.placement(name)) if index.has(name) else None


def _relations(index: Index) -> set[_Statement]:
    ontology = index.ontology
    return {said for said in index.statements() if not is_abstract(said[0]) and not ontology.is_placement(said[1])}


def _is_within_rounding(edit: Edit) -> bool:
    if not isinstance(edit, PropertyEdit) or not isinstance(edit.old, Pose) or not isinstance(edit.new, Pose):
        return False
    return format_value(edit.old) == format_value(edit.new)


def _element(edit: ElementEdit) -> str:
    element = edit.new or edit.old
    assert element is not None
    return f"{'-' if edit.new is None else '+'} {element.id} ({element.type}) {shown(element.label)}"


def _placed(placement: Placement | None) -> str:
    return "" if placement is None else f"{placement.relation} {placement.place}"


def _value(value: Value | None) -> str:
    return "" if value is None else shown(value) if isinstance(value, str) else format_value(value)


def _change(what: str, old: str, new: str) -> str:
    if not old or not new:
        return f"{'+' if new else '-'} {what} {new or old}"
    return f"~ {what} {old} -> {new}"


def robot_document(iri: str) -> tuple[Document | None, tuple[PluginFault, ...]]:
    """Finds the plug-in's file that declares an IRI, and loads as few plug-ins as possible.

    Args:
        iri: The imported IRI ("http://example.org/robots/crane"); the plug-in named like its last part is tried first.

    Returns:
        The file, or None; and the faults of the plug-ins that were loaded.
    """
    name = iri.rstrip("#/").rpartition("/")[2]
    broken: list[PluginFault] = []
    for entry in sorted(installation().of(GROUP), key=lambda entry: entry.own_name != name):
        for found in documents_of(entry):
            if isinstance(found, PluginFault):
                broken.append(found)
            elif found.iri == iri:
                return found, tuple(broken)
    return None, tuple(broken)


def _robot_iris() -> Iterator[str]:
    """Yields the IRIs of the files that plug-ins bring."""
    for entry in installation().of(GROUP):
        yield from (found.iri for found in documents_of(entry) if isinstance(found, Document))


def documents_of(entry: Entry) -> Iterator[Document | PluginFault]:
    """Yields the parsed files of an entry point, and its faults."""
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


def load_scene(
    ontology: Ontology, path: Path, ontology_paths: Sequence[Path] = (), *, reasoners: Reasoners = NO_REASONERS
) -> World:
    """Reads a scene into a new world, as its first change, by author "scene".

    Imports of the scene are looked up by IRI among the ontology's files and ``ontology_paths``, never fetched; the
    individuals found there (a robot's) become part of the scene.

    Args:
        ontology: The ontology.
        path: The file, in a format that :func:`~skiros_py.world.ontology.documents.read_document` reads.
        ontology_paths: More files or folders in which imports are looked up.
        reasoners: The reasoners for computed relations in this world.

    Raises:
        FileError: A file is missing, in none of these languages, or violates the ontology; with the line if known.
    """
    world = World(ontology, reasoners=reasoners)
    with collection_paused():
        fill(
            world,
            _read(ontology, path, ontology_paths),
            "scene",
            Message("read from {file}", file=path.name),
            scene_source(path),
        )
    return world


def scene_source(path: Path) -> SceneSource:
    """Returns the name and the checksum of a scene file.

    Raises:
        FileError: It cannot be read.
    """
    try:
        return SceneSource(path.stem, zlib.crc32(path.read_bytes()))
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from error


def fill(world: World, reader: Reader, author: str, reason: str, source: SceneSource | None = None) -> None:
    """Writes individuals that were read into a world, as one change.

    Args:
        world: The world.
        reader: Has read them.
        author: The author of the change.
        reason: Why, for people.
        source: The file of the scene; None for other individuals.

    Raises:
        FileError: The ontology or a reasoner does not allow it; nothing was changed.
    """
    try:
        with world.transaction(author, reason, writer=Writer.SYSTEM) as tx:
            tx.apply(reader.edits())
            if source is not None:
                tx.set_source(source)
    except WorldError as error:
        problems = tx.problems()
        if problems:
            raise fault_of_all(reader.files, world.ontology.names, problems) from None
        raise FileError(reader.files[0].path, str(error)) from None


def save_scene(world: World, path: Path) -> None:
    """Writes the current state as a Turtle file, atomically; equal states give equal files.

    Imported individuals are written with the rest, so the file imports ontologies only.

    Raises:
        FileError: It cannot be written.
    """
    with collection_paused():
        write_atomically(path, scene_turtle(world.snapshot()))


def _read(ontology: Ontology, path: Path, ontology_paths: Sequence[Path]) -> Reader:
    reader, document = Reader(ontology), read_document(path)
    known = _known_files(ontology, ontology_paths)
    for file in _with_imports(document, document.imports(), known):
        reader.take(file, whole=file is document)
    for iri in reader.copied_files():
        described = Reader(ontology)
        for file in _with_imports(document, (iri,), known)[1:]:
            described.take(file)
        reader.describe(iri, described.individuals)
    return reader


def _known_files(ontology: Ontology, paths: Sequence[Path]) -> dict[str, Document]:
    """Returns the files that are looked up by IRI before those of plug-ins are."""
    known = {iri: file for file in ontology.sources for iri in file.iris()}
    read = {file.path.resolve() for file in ontology.sources}
    for file in (read_document(path) for path in rdf_files(paths) if path.resolve() not in read):
        known = dict.fromkeys(file.iris(), file) | known
    return known


def _with_imports(scene: Document, iris: Sequence[str], known: Mapping[str, Document]) -> list[Document]:
    """Returns a scene file, and the files that some IRIs in it name, with all that those import."""
    files = {scene.iri: scene}
    missing: dict[str, Document] = {}
    broken: list[PluginFault] = []
    waiting = [(scene, iris)]
    for file, wanted in waiting:
        for iri in wanted:
            found = files.get(iri) or known.get(iri)
            if found is None:
                found, faults = robot_document(iri)
                broken += faults
            if found is None:
                missing.setdefault(iri, file)
            elif found.iri not in files:
                files[found.iri] = found
                waiting.append((found, found.imports()))
    if missing:
        raise _missing(missing, known, broken)
    return list(files.values())


def _missing(missing: Mapping[str, Document], known: Iterable[str], broken: Iterable[PluginFault]) -> FileError:
    iri, importer = next(iter(missing.items()))
    names, declared, robots = (
        ", ".join(f"<{name}>" for name in sorted(some)) or "none" for some in (missing, known, _robot_iris())
    )
    faults = "".join(f"; {fault}" for fault in dict.fromkeys(broken))
    advice = f"put an ontology into a folder of {ONTOLOGIES}; these are declared: {declared}; robots: {robots}"
    return importer.fault(f"imports {names}, which no file at hand declares: {advice}{faults}", iri)
