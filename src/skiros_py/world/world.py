"""The live world: one writer at a time, transactions, and everyone told in order."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from skiros_py.errors import WorldError
from skiros_py.world.change import Change
from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.ids import Ids
from skiros_py.world.index import Index
from skiros_py.world.ontology import Ontology
from skiros_py.world.transaction import Transaction

if TYPE_CHECKING:
    from skiros_py.world.store import TripleStore

__all__ = ["World"]

_log = logging.getLogger(__name__)


class World:
    """What is, as believed now; a :class:`~skiros_py.world.view.WorldView` that changes by transactions only.

    Attributes:
        clock: Gives the time [s, simulated] that changes are stamped with; may be replaced.
        goals: Texts of the goals that go with the scene.
    """

    def __init__(
        self, ontology: Ontology, *, clock: Callable[[], float] = lambda: 0.0, goals: Sequence[str] = ()
    ) -> None:
        self.clock = clock
        self.goals = tuple(goals)
        self._index = Index(ontology)
        self._ids = Ids()
        self._changes: list[Change] = []
        self._writing = threading.Lock()
        self._writer: tuple[int, str] | None = None
        self._subscribers: dict[int, Callable[[Change], None]] = {}
        self._subscriptions = 0
        self._untold: deque[Change] = deque()
        self._telling = threading.RLock()
        self._told_by_me = False
        self._store: TripleStore | None = None

    # ------------------------------------------------------------ writing

    @contextmanager
    def transaction(self, author: str, reason: str) -> Iterator[Transaction]:
        """Opens a write: ``with world.transaction("pick", "the fingers hold it") as tx: tx.place(...)``.

        Nothing is visible before the block ends; if it raises, nothing happens. Another thread's transaction is waited
        for. A transaction without net effect makes no change.

        Args:
            author: Who writes.
            reason: Why, in words for people.

        Raises:
            WorldError: The ontology does not allow what was written (the text names everything wrong and what would
                be right), or this thread has a transaction open already.
        """
        self._begin(author)
        try:
            tx = Transaction(self._index, self._ids)
            try:
                yield tx
            finally:
                tx.close()
            self._publish(tx, author, reason)
        finally:
            self._writer = None
            self._writing.release()
        self._tell()

    @property
    def version(self) -> int:
        """Number of the last change; 0 for a world that is still empty."""
        return len(self._changes)

    @property
    def changes(self) -> Sequence[Change]:
        """Every change so far, in order: ``changes[n - 1]`` has number n."""
        return tuple(self._changes)

    def changes_since(self, version: int) -> Sequence[Change]:
        """Returns the changes after a version, in order."""
        return tuple(self._changes[version:])

    def subscribe(self, callback: Callable[[Change], None]) -> Callable[[], None]:
        """Has each later change told to ``callback``, in order, after it is visible; returns what ends that.

        A callback that raises is logged and hurts nobody else. It may write: others are told of that afterwards.
        """
        key = self._subscriptions = self._subscriptions + 1
        self._subscribers[key] = callback

        def unsubscribe() -> None:
            self._subscribers.pop(key, None)

        return unsubscribe

    def snapshot(self) -> Index:
        """Returns the present state, which will never change; this costs nothing."""
        return self._index

    @property
    def store(self) -> TripleStore:
        """The same content as RDF triples; made when first asked for, brought up to date whenever it is queried."""
        if self._store is None:
            from skiros_py.world.store import TripleStore  # most runs never query

            self._store = TripleStore(self)
        return self._store

    # ------------------------------------------------------------ the world view

    @property
    def ontology(self) -> Ontology:
        """The classes and relations."""
        return self._index.ontology

    def element(self, element_id: str) -> Element:
        """Returns one element.

        Raises:
            UnknownName: There is none of that id.
        """
        return self._index.element(element_id)

    def has(self, element_id: str) -> bool:
        """Returns True when there is an element of that id."""
        return self._index.has(element_id)

    def instances(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of all elements of a class or of its subclasses, sorted.

        Raises:
            UnknownName: It is not a class.
        """
        return self._index.instances(class_)

    def value(self, element_id: str, property_: str) -> Value | None:
        """Returns the element's own value, else the one its class (or nearest superclass) gives, else None.

        Raises:
            UnknownName: There is no such element or property.
        """
        return self._index.value(element_id, property_)

    def objects(self, subject: str, relation: str) -> tuple[str, ...]:
        """Returns ids of what the subject is related to, sorted; sub-relations count.

        Raises:
            UnknownName: It is not a relation.
        """
        return self._index.objects(subject, relation)

    def subjects(self, relation: str, object_: str) -> tuple[str, ...]:
        """Returns ids of what is related to the object, sorted; sub-relations count.

        Raises:
            UnknownName: It is not a relation.
        """
        return self._index.subjects(relation, object_)

    def related(self, subject: str, relation: str, object_: str) -> bool:
        """Returns True when the relation (or a sub-relation) holds between the two.

        Raises:
            UnknownName: It is not a relation.
        """
        return self._index.related(subject, relation, object_)

    def placement(self, element_id: str) -> Placement | None:
        """Returns where an element is, or None for one that never is anywhere (the root, a piece of structure).

        Raises:
            UnknownName: There is none of that id.
        """
        return self._index.placement(element_id)

    # ------------------------------------------------------------ the life of a transaction

    def _begin(self, author: str) -> None:
        if self._writer is not None and self._writer[0] == threading.get_ident():
            raise WorldError(f"{author} cannot write: {self._writer[1]} has a transaction open in the same thread")
        self._writing.acquire()
        self._writer = (threading.get_ident(), author)

    def _publish(self, tx: Transaction, author: str, reason: str) -> None:
        try:
            index, ids, edits = tx.finish()
        except WorldError as error:
            raise WorldError(f"transaction of {author} ({reason}) {error}") from None
        self._ids.absorb(ids)
        if edits:
            self._index = index
            change = Change(self.version + 1, author, reason, self.clock(), edits)
            self._changes.append(change)
            self._untold.append(change)

    def _tell(self) -> None:
        with self._telling:
            if self._told_by_me:  # a callback wrote: the loop that called it tells of that, in order
                return
            self._told_by_me = True
            try:
                while self._untold:
                    change = self._untold.popleft()
                    for callback in tuple(self._subscribers.values()):
                        _call(callback, change)
            finally:
                self._told_by_me = False


def _call(callback: Callable[[Change], None], change: Change) -> None:
    try:
        callback(change)
    except Exception:  # noqa: BLE001  whatever it is, it is the subscriber's fault and no one else's
        _log.exception("a subscriber failed on change %d of the world", change.number)
