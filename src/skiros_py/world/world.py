"""The live world: one writer at a time, transactions, and subscribers that are notified in order."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING

from skiros_py.errors import Locked, StaleVersion, UsageError, WorldError
from skiros_py.messages import Message, joined
from skiros_py.world.abstract import abstract_individuals
from skiros_py.world.change import Change, Edit, ElementEdit, Writer
from skiros_py.world.element import Stamp
from skiros_py.world.index import Index
from skiros_py.world.locks import Locks
from skiros_py.world.ontology import Ontology
from skiros_py.world.past import Past
from skiros_py.world.reasoners.registry import NO_REASONERS, Proposal, Reasoners
from skiros_py.world.terms import reached
from skiros_py.world.transaction import Transaction
from skiros_py.world.view import NO_SENSORS, Sensors, WorldView
from skiros_py.world.vocabulary import STRUCTURE

if TYPE_CHECKING:
    from skiros_py.world.store.projection import TripleStore

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class _Write:
    """Who writes and why; see :meth:`World.transaction`."""

    author: str
    reason: str
    writer: Writer
    undoes: int | None
    holder: str


class World(WorldView):
    """The current world model; a :class:`~skiros_py.world.view.WorldView` that changes only by transactions.

    Attributes:
        clock: Gives the time [s, simulated] that changes are stamped with; may be replaced.
        log: The change log; only the world itself appends to it.
        locks: The edit locks of users and jobs on elements.
        sensors: Device readings of this cycle; replaced when devices are brought up.
    """

    sensors: Sensors = NO_SENSORS
    _base: Index

    def __init__(
        self,
        ontology: Ontology,
        *,
        reasoners: Reasoners = NO_REASONERS,
        clock: Callable[[], float] = lambda: 0.0,
        past: Past | None = None,
    ) -> None:
        """Opens a world.

        Args:
            ontology: The ontology.
            reasoners: Reasoners that evaluate computed relations and may reject changes.
            clock: Gives the time [s, simulated].
            past: The previous state, read from a journal; changes are written there before they take effect.
        """
        self.clock = clock
        self.locks = Locks(known=lambda name: self._base.has(name), related=lambda names: _related(self._base, names))
        past = past or Past(abstract_individuals(ontology, reasoners))
        self._base = past.index.copy()
        self._base.version = past.log.version
        self._ids = past.ids
        self.log = past.log
        self._writing = threading.Lock()
        self._writer: tuple[int, str] | None = None
        self._subscribers: dict[int, Callable[[Change], None]] = {}
        self._subscriptions = count()
        self._queued: deque[tuple[int, Change]] = deque()
        self._notify_lock = threading.RLock()
        self._notifying = False
        self._store: TripleStore | None = None
        self._making_store = threading.Lock()

    # ------------------------------------------------------------ writing

    @contextmanager
    def transaction(
        self,
        author: str,
        reason: str,
        *,
        writer: Writer = Writer.SKILL,
        expects: Mapping[str, int] | None = None,
        undoes: int | None = None,
        holder: str = "",
    ) -> Iterator[Transaction]:
        """Opens a write: ``with world.transaction("pick", "the fingers hold it") as tx: tx.place(...)``.

        Nothing is visible before the block ends; if it raises, nothing is changed. Waits for other threads'
        transactions. A transaction without net effect makes no change.

        Args:
            author: The author.
            reason: Why, in readable form.
            writer: What kind of author that is; locks of others keep people and jobs out.
            expects: For elements by id, the version (:meth:`stamp`) that the author has seen; for "" that of the world.
            undoes: Number of the change that this one undoes.
            holder: The lock holder, if different from the author.

        Raises:
            WorldError: The ontology or a reasoner does not allow what was written (the text names every problem and
                its correction), or this thread already has an open transaction.
            UsageError: There is no author or no reason, or an expected element never existed.
            StaleVersion: An element was changed or removed since the author saw it.
            Locked: Another user has locked one of the elements.
        """
        write = _Write(_text("author", author), _text("reason", reason), _kind(writer), undoes, holder or author)
        here, other = self._writer or (None, "")
        if here == threading.get_ident():
            raise WorldError(f"{author} cannot write: {other} has a transaction open in the same thread")
        with self._writing:
            self._writer = (threading.get_ident(), author)
            try:
                self._check_versions(expects or {})
                tx = Transaction(self._base, self._ids)
                try:
                    yield tx
                finally:
                    tx.close()
                with self.locks.unchanged():
                    self._publish(tx, write)
            finally:
                self._writer = None
        self._notify()

    @property
    def version(self) -> int:
        """Number of the last change; 0 for a world that is still empty."""
        return self._base.version

    @property
    def changes(self) -> Sequence[Change]:
        """Every change that is kept, in order; see :meth:`changes_since`."""
        return self.log.since(self.log.first - 1)

    def changes_since(self, version: int) -> Sequence[Change]:
        """Returns the changes after a version, in order.

        Raises:
            WorldError: They are no longer kept: the journal was compacted since.
        """
        return self.log.since(version)

    def subscribe(self, callback: Callable[[Change], None]) -> Callable[[], None]:
        """Calls the callback with each later change, in order, once it is visible; returns how to unsubscribe.

        A callback that raises is logged. It may write: other subscribers are notified of that afterwards. It runs in
        the thread that wrote, so it must be quick, and must never wait for another thread that writes.
        """
        key = next(self._subscriptions)
        self._subscribers[key] = callback

        def unsubscribe() -> None:
            self._subscribers.pop(key, None)

        return unsubscribe

    def snapshot(self) -> Index:
        """Returns the current state: immutable, with its version, and without the writes of an open transaction."""
        return self._base

    @property
    def goals(self) -> tuple[str, ...]:
        """Texts of the goals stored with the scene, sorted."""
        return self._base.goals

    @property
    def store(self) -> TripleStore:
        """The same content as RDF triples; created on first use, updated on every query."""
        from skiros_py.world.store.projection import TripleStore  # most runs never query

        with self._making_store:
            if self._store is None:
                self._store = TripleStore(self)
            return self._store

    # ------------------------------------------------------------ the world view

    def stamp(self, element_id: str) -> Stamp:
        """Returns which change last touched an element, and when.

        Raises:
            UnknownName: There is none of that id.
        """
        return self._base.stamp(element_id)

    def forked(self) -> tuple[WorldView, Index]:
        """Returns a copy of the current state."""
        return self._base.forked()

    # ------------------------------------------------------------ the life of a transaction

    def _check_versions(self, expects: Mapping[str, int]) -> None:
        for name, seen in expects.items():
            if isinstance(seen, bool) or not isinstance(seen, int):
                raise UsageError(f"the version of {name or 'the world'} is a whole number, not {seen!r}")
            if name and not self._base.has(name) and self._ids.used(name):
                raise StaleVersion(
                    Message(
                        "{name} is gone, and version {seen} was expected: it was removed since", name=name, seen=seen
                    )
                )
            now = self.version if name == "" else self._base.stamp(name).change
            if now != seen:
                what = name or "the world"
                raise StaleVersion(
                    Message(
                        "{what} is at version {now}, and {seen} was expected: it was changed since",
                        what=what,
                        now=now,
                        seen=seen,
                    )
                )

    def _publish(self, tx: Transaction, write: _Write) -> None:
        before = self._base
        try:
            index, edits = tx.finish()
            if edits:
                self._check_outside(before, index, edits, write)
        except WorldError as error:
            error.args = (
                Message(
                    "transaction of {author} ({reason}) {error}", author=write.author, reason=write.reason, error=error
                ),
            )  # its data stay with it
            raise
        if edits:
            change = Change(
                self.log.version + 1, write.author, write.reason, self.clock(), edits, write.writer, write.undoes
            )
            index.mark(change.marks(), Stamp(change.number, change.time))
            index.version = change.number
            self.log.append(change)  # a journal that cannot write raises here, and nothing has happened
            self._base = index
            tx.change = change
            for edit in edits:
                if isinstance(edit, ElementEdit) and edit.new is not None:
                    self._ids.claim(edit.element)  # elements added and removed in one transaction were never visible
            self._queued.extend((key, change) for key in tuple(self._subscribers))

    def _check_outside(self, before: Index, after: Index, edits: Sequence[Edit], write: _Write) -> None:
        """Checks a change that the ontology allows against locks and reasoners."""
        if write.writer in (Writer.PERSON, Writer.JOB):
            concerned = {name for edit in edits for name in edit.concerns()}
            locked = self.locks.fault(_wholes(before, after, concerned), write.holder)
            if locked is not None:
                raise Locked(Message("refused: {why}", why=locked), locked.locks)
        vetoes = self.reasoners.vetoes(Proposal(before, after, edits, write.author, write.writer))
        if vetoes:
            raise WorldError("refused: {why}", why=joined("; ", vetoes))

    def _notify(self) -> None:
        with self._notify_lock:
            if self._notifying:  # a callback wrote: the loop that called it notifies of that, in order
                return
            self._notifying = True
            try:
                while self._queued:
                    key, change = self._queued.popleft()
                    callback = self._subscribers.get(key)
                    if callback is not None:
                        _call(callback, change)
            finally:
                self._notifying = False


_LONGEST_TEXT = 1000
"""Characters that an author or a reason may have; more are cut off."""


def _text(what: str, text: str) -> str:
    if not isinstance(text, str) or not text.strip():
        raise UsageError(f"a transaction needs its {what}: a text that says {_SAYS[what]}")
    if not text.isprintable():  # it is shown on a terminal line and written to a file
        text = "".join(character if character.isprintable() else " " for character in text)
    return text if len(text) <= _LONGEST_TEXT else f"{text[:_LONGEST_TEXT]}…"


def _kind(writer: Writer) -> Writer:
    try:
        return Writer(writer)
    except ValueError:
        kinds = ", ".join(kind.value for kind in Writer)
        raise UsageError(f"a writer is one of {kinds}, not {writer!r}") from None


def _wholes(before: Index, after: Index, names: Iterable[str]) -> tuple[str, ...]:
    """The named elements and those that they are parts of, on all levels: locking a kit also locks its compartments."""
    return reached(names, lambda name: (*before.owners(name), *after.owners(name)))


def _related(index: Index, names: Iterable[str]) -> set[str]:
    """The named elements, their wholes and their parts, on all levels."""
    given = tuple(names)
    return {*_wholes(index, index, given), *reached(given, lambda name: index.objects(name, STRUCTURE))}


_SAYS = {"author": "who writes", "reason": "why, in words for people"}


def _call(callback: Callable[[Change], None], change: Change) -> None:
    try:
        callback(change)
    except (Exception, SystemExit):  # noqa: BLE001  any exception is the subscriber's fault
        _log.exception("a subscriber failed on change %d of the world", change.number)
