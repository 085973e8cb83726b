"""Data taught to robots, as a file: written, read, imported, and kept in sync with a journal."""

from __future__ import annotations

import contextlib
import logging
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Lock

from skiros_py.errors import FileError, WorldError
from skiros_py.files import open_private
from skiros_py.messages import Message
from skiros_py.world.change import Change, Edit, ElementEdit, Writer
from skiros_py.world.element import is_learned
from skiros_py.world.index import Index
from skiros_py.world.names import LEARNED, LEARNED_GRAPH
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import read_document
from skiros_py.world.scene.files import fill, write_atomically
from skiros_py.world.scene.reader import Reader
from skiros_py.world.scene.writer import TurtleWriter
from skiros_py.world.transaction import Transaction
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ELEMENT, LEARNED_DURATION
from skiros_py.world.world import World


def learned_names(view: WorldView) -> list[str]:
    """Returns the ids of all learned concepts, sorted."""
    return [name for name in view.abstracts(ELEMENT) if is_learned(name)]


def learned_turtle(view: Index) -> str:
    """Returns the learned data of a state as Turtle text; equal states give equal texts."""
    writer = TurtleWriter(view)
    return writer.file(LEARNED_GRAPH, writer.elements(learned_names(view)))


def read_learned(ontology: Ontology, path: Path) -> World:
    """Returns a world with the learned concepts of a file, and nothing else.

    Raises:
        FileError: The file is missing, has an unknown format, speaks of anything else, or does not fit the ontology;
            with the line if known.
    """
    reader = Reader(ontology, LEARNED)
    reader.take(read_document(path), whole=True)
    world = World(ontology)
    fill(world, reader, "learned", Message("read from {file}", file=path.name))
    return world


def import_learned(world: World, tx: Transaction, path: Path, *, replace: bool = False) -> None:
    """Adds the learned concepts of a file to a world; those that it has already are left as they are.

    Args:
        world: The world.
        tx: An open transaction of it.
        path: The file.
        replace: Whether concepts that are different in the world are removed, with their parts and all relations to
            them, and replaced by those of the file.

    Raises:
        FileError: As for :func:`read_learned`.
        WorldError: Concepts are different in the world, and are not to be replaced.
    """
    read = read_learned(world.ontology, path)
    known, new = world.snapshot(), read.snapshot()
    both = {name for name in learned_names(new) if known.has(name)}
    different = sorted(name for name in both if _described(known, name) != _described(new, name))
    if different and not replace:
        names = ", ".join(different)
        raise WorldError(
            "{names}: known already, and different; replace them, or give those of the file other ids", names=names
        )
    for name in different:
        if tx.view.has(name):  # else it went with what it is part of
            tx.remove(name)
    kept = {name for name in both if tx.view.has(name)}
    tx.apply(edit for edit in _edits(read) if not (isinstance(edit, ElementEdit) and edit.element in kept))


def _edits(world: World) -> list[Edit]:
    return [edit for change in world.changes for edit in change.edits]


def _described(view: Index, name: str) -> tuple[object, ...]:
    """An element with its placement and the relations that are stated of it."""
    return view.element(name), [said for said in view.statements_about(name) if said[0] == name]


# ---------------------------------------------------------------- the file


_log = logging.getLogger(__name__)


class LearnedFile:
    """Mirrors the learned part of a world, which is stored in the journal, in a Turtle file.

    If the file cannot be written, it stays unchanged until the next change; the world is not affected.

    Attributes:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._stale = False
        self._taken = False
        self._guard = Lock()
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="skiros-learned")
        self._is_due = False

    def read_into(self, world: World) -> None:
        """Adds the content of the file to a new world, if the file exists.

        Raises:
            FileError: It does not fit the ontology.
        """
        self._taken = True
        if not self.path.exists():
            return
        read = read_learned(world.ontology, self.path)
        try:
            with world.transaction(
                "learned", Message("carried over in {file}", file=self.path.name), writer=Writer.SYSTEM
            ) as tx:
                tx.apply(_edits(read))
        except WorldError as error:
            raise FileError(self.path, str(error)) from None

    def follow(self, world: World) -> None:
        """Writes the file, and updates it whenever the world changes."""
        self._tidy()
        if not self._taken:
            self._keep_another(learned_turtle(world.snapshot()))
        self._mirror(world)
        world.subscribe(lambda change: self._on_change(world, change))

    def close(self) -> None:
        """Waits until the file is up to date; later changes are not written."""
        self._writer.shutdown()

    def _keep_another(self, text: str) -> None:
        """Keeps a copy of a file that was edited: it is not used, but must not be lost."""
        try:
            found = self.path.read_bytes() if self.path.exists() else b""
            if not found.strip() or found == text.encode():
                return
            kept = _kept(self.path, found)
        except OSError:  # nor can it be overwritten
            return
        _log.warning(
            "%s is not as the journal says, which alone counts: it is kept as %s, and written again; to take over what"
            " it says, let it be the learned.ttl of a new data directory",
            self.path,
            kept.name,
        )

    def _on_change(self, world: World, change: Change) -> None:
        names = [name for name in change.marks() if is_learned(name)]
        view = world.snapshot()
        if names and all(view.has(name) and view.element(name).type == LEARNED_DURATION for name in names):
            self._mirror_later(world)  # written by the control thread, which does not wait for a disk
        elif names or self._stale:
            self._mirror(world)

    def _mirror_later(self, world: World) -> None:
        if not self._is_due:
            self._is_due = True
            with contextlib.suppress(RuntimeError):  # closed
                self._writer.submit(self._mirror_due, world)

    def _mirror_due(self, world: World) -> None:
        self._is_due = False  # before the world is read: what changes from now on is written once more
        self._mirror(world)

    def _mirror(self, world: World) -> None:
        with self._guard:
            self._write(world)

    def _write(self, world: World) -> None:
        view = world.snapshot()
        there = self.path.exists()
        if not there and not learned_names(view):
            return
        text = learned_turtle(view)
        try:
            if not there or self.path.read_text(encoding="utf-8") != text:
                write_atomically(self.path, text, private=True)
            self._stale = False
        except (FileError, OSError, UnicodeError) as error:
            self._stale = True
            _log.warning("%s is not up to date: %s", self.path, error)

    def _tidy(self) -> None:
        """Removes temporary files of a process that was killed while writing."""
        for left in self.path.parent.glob(f".{self.path.name}.*.tmp"):
            left.unlink(missing_ok=True)


_MOST_KEPT = 10
"""Number of copies kept of files that were edited; the oldest are removed."""


def _kept(path: Path, content: bytes) -> Path:
    """Copies a file under the next free name, unless such a copy exists."""
    copies = {
        int(end): copy for copy in path.parent.glob(f"{path.name}.kept-*") if (end := copy.suffix[6:]).isdecimal()
    }
    for copy in copies.values():
        if copy.read_bytes() == content:
            return copy
    number = max(copies, default=0) + 1
    kept = path.with_name(f"{path.name}.kept-{number}")
    with open(kept, "xb", opener=open_private) as file:
        file.write(content)
    for old in sorted(copies)[: 1 - _MOST_KEPT]:
        copies[old].unlink(missing_ok=True)
    return kept
