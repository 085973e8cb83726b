"""A world opened in this process, for commands."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from skiros_py.errors import UnknownName
from skiros_py.messages import Message
from skiros_py.planning.experience import forget
from skiros_py.station.scenes.scenes import scene_only
from skiros_py.station.world.editing import add, change
from skiros_py.world.change import Change, Writer
from skiros_py.world.element import Element, Stamp
from skiros_py.world.journal.journal import Journal
from skiros_py.world.journal.records import Entry
from skiros_py.world.queries.answering import Binding, Result
from skiros_py.world.queries.outside import OutsideQueries
from skiros_py.world.queries.replica import Limits
from skiros_py.world.scene.learned import import_learned, learned_names, learned_turtle
from skiros_py.world.scene.writer import scene_turtle
from skiros_py.world.transaction import Transaction
from skiros_py.world.undo import undo
from skiros_py.world.world import World

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from skiros_py.api.world import ElementPatch, NewElement

MOST_ROWS = 100_000
"""Maximum number of rows of a query in this process."""


@dataclass(frozen=True, slots=True)
class Shown:
    """An element with its relations.

    Attributes:
        element: With its own values.
        statements: Every stated (subject, relation, object) with the element at either end, sorted.
        stamp: The last change that touched it.
    """

    element: Element
    statements: Sequence[tuple[str, str, str]]
    stamp: Stamp


@dataclass(frozen=True, slots=True)
class History:
    """Changes, in order.

    Attributes:
        first: Number of the oldest stored change.
        entries: The changes.
    """

    first: int
    entries: Sequence[Entry]


class OpenWorld:
    """A world that this process has open.

    Args:
        world: The world.
        journal: Its changes; None where it is kept nowhere, and has no history.
    """

    def __init__(self, world: World, journal: Journal | None = None) -> None:
        self._world = world
        self._journal = journal

    def show(self, element: str) -> Shown:
        """Returns an element with its relations."""
        state = self._world.snapshot()
        return Shown(state.element(element), state.statements_about(element), state.stamp(element))

    def history(self, element: str | None, last: int | None) -> History:
        """Returns the changes of an element, or all."""
        assert self._journal is not None
        entries = self._journal.history(element, last=last)
        if element is not None and not entries and not self._journal.was_given(element):
            raise UnknownName("element", element, self._world.snapshot().ids())
        return History(self._journal.first, entries)

    def undo(self, author: str) -> Change:
        """Undoes the last edit of a person."""
        return undo(self._world, author)

    def learned(self) -> Sequence[Element]:
        """Returns the learned concepts."""
        return [self._world.element(name) for name in learned_names(self._world)]

    def forget(self, concept: str, author: str) -> Change:
        """Deletes a learned concept with its parts."""
        self._check_learned(concept)
        with self._write(author, f"forgets {concept}") as tx:
            tx.remove(concept)
        assert tx.change is not None
        return tx.change

    def forget_runs(self, of: Mapping[str, str], author: str) -> Change | None:
        """Deletes what was learned from runs; None if there is nothing."""
        with self._write(author, Message("forgets what was learned from runs")) as tx:
            forget(tx, self._world.snapshot(), **of)
        return tx.change

    def teach(self, new: NewElement, author: str) -> Change | None:
        """Adds a learned concept."""
        with self._write(author, new.reason) as tx:
            add(tx, new, learned=True)
        return tx.change

    def edit_learned(self, concept: str, patch: ElementPatch, author: str) -> Change | None:
        """Changes a learned concept; None if it is so already."""
        self._check_learned(concept)
        with self._write(author, patch.reason) as tx:
            change(tx, concept, patch)
        return tx.change

    def import_learned(self, file: Path, author: str, *, replace: bool) -> Change | None:
        """Adds the learned concepts of a file; None if there is nothing new in it."""
        with self._write(author, f"imports {file.name}") as tx:
            import_learned(self._world, tx, file, replace=replace)
        return tx.change

    def learned_turtle(self) -> str:
        """Returns the learned concepts as the text of a Turtle file."""
        return learned_turtle(self._world.snapshot())

    def scene_turtle(self) -> str:
        """Returns the scene as the text of a Turtle file."""
        return scene_turtle(scene_only(self._world.snapshot()))

    def query(self, sparql: str, bindings: Mapping[str, Binding], *, entailed: bool, time_limit: float) -> Result:
        """Runs a SPARQL query."""
        with OutsideQueries(self._world, Limits(rows=MOST_ROWS)) as queries:
            return queries.query(sparql, bindings, entailed=entailed, time_limit=time_limit)

    def _write(self, author: str, reason: str) -> AbstractContextManager[Transaction]:
        return self._world.transaction(author, reason, writer=Writer.PERSON)

    def _check_learned(self, concept: str) -> None:
        known = learned_names(self._world)
        if concept not in known:
            raise UnknownName("learned concept", concept, known)
