"""Writing to the world on behalf of remote callers, and its changes as the API shows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from datetime import UTC, datetime, timedelta

from skiros_py.api import transactions
from skiros_py.api.wire import moment
from skiros_py.api.world import Addition, Change, ChangePage, ElementPatch, Lock, NewRelation, Undoable, Written
from skiros_py.errors import Refused, UsageError
from skiros_py.messages import Message
from skiros_py.station.requests import Author
from skiros_py.station.world.values import set_value
from skiros_py.world import change as world_change
from skiros_py.world.branches import add_draft, draft_of, instantiate, learn
from skiros_py.world.change import Edit, Writer
from skiros_py.world.element import is_abstract, is_learned
from skiros_py.world.journal.journal import Journal
from skiros_py.world.journal.records import Entry
from skiros_py.world.locks import Lock as WorldLock
from skiros_py.world.transaction import Transaction
from skiros_py.world.vocabulary import LABEL, STRUCTURE
from skiros_py.world.world import World

_MOST_EDITS = 100
"""Maximum number of edits listed with a change; loading a scene has thousands."""


def change_view(change: world_change.Change) -> Change:
    """Describes a change that was just made."""
    return _view_of(change, change.edits[:_MOST_EDITS], 0, len(change.edits))


def _view_of(
    change: world_change.Change, edits: Sequence[Edit], start: int, total: int, wall: float | None = None
) -> Change:
    end = start + len(edits)
    return Change.view_of(
        change,
        writer=change.writer.value,
        written=moment(wall),
        edits=[edit.as_json() for edit in edits],
        edits_total=total,
        next=str(end) if edits and end < total else None,
    )


def change_page(world: World, beyond: int, limit: int, *, newest_first: bool) -> ChangePage:
    """Returns a page of changes.

    Raises:
        Refused: Some of the requested changes are no longer kept.
    """
    journal = _journal(world)
    if not newest_first and 0 < beyond < journal.first - 1:
        raise _forgotten(journal, f"the changes after {beyond}")
    return _page(journal, journal.page(beyond, limit + 1, newest_first=newest_first), limit)


def history(world: World, element: str, beyond: int, limit: int, *, newest_first: bool) -> ChangePage:
    """Returns a page of changes of an element, which may have been removed.

    Raises:
        UnknownName: There never was one with this id.
    """
    journal = _journal(world)
    if not (world.has(element) or journal.was_given(element)):
        raise world.snapshot().unknown(element)
    heads = journal.page(beyond, limit + 1, element=element, newest_first=newest_first)
    return _page(journal, heads, limit)


def one_change(world: World, number: int, start: int, most: int) -> Change:
    """Returns one change.

    Raises:
        Refused: There is none with this number, or it is no longer kept.
    """
    journal = _journal(world)
    if 0 < number < journal.first:
        raise _forgotten(journal, Message("change {number}", number=number))
    heads = journal.page(number - 1, 1) if 0 < number <= journal.version else ()
    if not heads:
        raise Refused(
            "NotFound",
            Message("there is no change {number}: the latest is {version}", number=number, version=journal.version),
        )
    head = heads[0]
    return _view_of(head.change, journal.edits(head, start, most), start, head.edits, head.wall)


def undoable(world: World) -> Undoable | None:
    """Returns the edit that an undo would revert."""
    head = _journal(world).undoable_entry()
    return None if head is None else Undoable.view_of(head.change)


def redoable(world: World) -> Undoable | None:
    """Returns the undo that a redo would revert."""
    head = _journal(world).redoable_entry()
    return None if head is None else Undoable.view_of(head.change)


def written(world: World, tx: Transaction, ids: dict[str, str] | None = None) -> Written:
    """Returns the effects of a finished transaction."""
    change = None if tx.change is None else change_view(tx.change)
    return Written(version=world.version, change=change, ids=ids or {})


def _page(journal: Journal, heads: Sequence[Entry], limit: int) -> ChangePage:
    shown = heads[:limit]
    return ChangePage(
        items=[_view_of(h.change, h.change.edits[:_MOST_EDITS], 0, h.edits, h.wall) for h in shown],
        next=str(shown[-1].change.number) if len(heads) > limit else None,
        remembered_from=journal.first,
        version=journal.version,
    )


def _journal(world: World) -> Journal:
    if not isinstance(world.log, Journal):
        raise Refused("NoJournal", Message("this world is kept nowhere: serve it with a data directory"))
    return world.log


def _forgotten(journal: Journal, what: str) -> Refused:
    text = Message("{what} is not known: changes are remembered from number {first} on", what=what, first=journal.first)
    return Refused("Forgotten", text, remembered_from=journal.first)


def writing(
    world: World, author: Author, reason: str, expects: Mapping[str, int] | None = None
) -> AbstractContextManager[Transaction]:
    """Opens a transaction of a person.

    Args:
        world: The world.
        author: The author.
        reason: The reason.
        expects: The versions that the author has seen.

    Raises:
        Locked: Another author has locked an affected element.
    """
    return world.transaction(author.name, reason, writer=Writer.PERSON, expects=expects, holder=author.holder)


def lock_view(world: World, lock: WorldLock) -> Lock:
    """Describes a lock, with its time of expiry and its remaining time [s]."""
    left = max(0.0, lock.until - world.locks.clock())
    until = datetime.now(UTC) + timedelta(seconds=left)
    return Lock(element=lock.element, owner=lock.shown, until=until, seconds=round(left, 1))


# ------------------------------------------------------------------ elements


def add(tx: Transaction, new: Addition, ids: Mapping[str, str] | None = None, *, learned: bool = False) -> str:
    """Adds an element with its values and relations, and returns its id.

    Args:
        tx: The transaction.
        new: Its description.
        ids: Ids of elements added before, by ref.
        learned: True to add a learned concept, instead of an element of the scene.

    Raises:
        UnknownName: The element to copy does not exist.
        UsageError: A ref was not defined before, or a relation does not have exactly one other end; or the id is none
            of a learned concept, and has to be.
    """
    element = _made(tx, new, ids or {}, learned=learned)
    if new.placement is not None:
        tx.place(element, new.placement.relation, _target(new.placement.place, ids or {}))
    for property_, value in new.properties.items():
        set_value(tx, element, property_, value)
    for relation in new.relations:
        _relate(tx, element, relation, ids or {})
    return element


def _made(tx: Transaction, new: Addition, ids: Mapping[str, str], *, learned: bool) -> str:
    if learned and new.id is not None and not is_learned(new.id):
        raise UsageError(f"the id of a learned concept begins with 'learned:', not '{new.id[:60]}'")
    if new.class_ is not None:
        return tx.add(new.class_, new.label, new.id, learned=learned)
    assert new.like is not None
    like = _target(new.like, ids)
    if learned:
        element = learn(tx, like)
    elif is_abstract(like):
        element = instantiate(tx, like)
    else:
        element = next(iter(add_draft(tx, draft_of(tx.view, like, STRUCTURE)).values()))
    if new.label is not None:
        tx.set(element, LABEL, new.label)
    return element


def _relate(tx: Transaction, element: str, relation: NewRelation, ids: Mapping[str, str]) -> None:
    if (relation.subject is None) == (relation.object is None):
        raise UsageError(f"{relation.relation} of a new element: give the other end, either 'subject' or 'object'")
    subject = element if relation.subject is None else _target(relation.subject, ids)
    object_ = element if relation.object is None else _target(relation.object, ids)
    tx.relate(subject, relation.relation, object_)


def change(tx: Transaction, element: str, patch: ElementPatch) -> None:
    """Applies a patch to an element."""
    if patch.label is not None:
        tx.set(element, LABEL, patch.label)
    if patch.placement is not None:
        tx.place(element, patch.placement.relation, patch.placement.place)
    for property_, value in patch.properties.items():
        set_value(tx, element, property_, value)


# ------------------------------------------------------------------ operations


def operate(tx: Transaction, operations: Sequence[transactions.Operation]) -> dict[str, str]:
    """Executes the operations of a transaction in order, and returns the ids of added elements, by ref.

    Raises:
        UsageError: An operation uses a ref that was not defined before it, or defines one again.
    """
    ids: dict[str, str] = {}
    for operation in operations:
        match operation:
            case transactions.AddOperation(ref=ref):
                if ref in ids:
                    raise UsageError(f"two operations add something as '{ref}': give each its own ref")
                element = add(tx, operation, ids)
                if ref is not None:
                    ids[ref] = element
            case transactions.RemoveOperation(element=element):
                tx.remove(_target(element, ids))
            case transactions.SetOperation(element=element):
                set_value(tx, _target(element, ids), operation.property, operation.value)
            case transactions.PlaceOperation(element=element):
                tx.place(_target(element, ids), operation.relation, _target(operation.place, ids))
            case transactions.RelateOperation(subject=subject, object=object_):
                tx.relate(_target(subject, ids), operation.relation, _target(object_, ids))
            case transactions.UnrelateOperation(subject=subject, object=object_):
                tx.unrelate(_target(subject, ids), operation.relation, _target(object_, ids))
    return ids


def _target(name: str, ids: Mapping[str, str]) -> str:
    if not name.startswith("$"):
        return name
    if name[1:] not in ids:
        known = ", ".join(f"${ref}" for ref in ids) or "none"
        raise UsageError(f"nothing was added as '{name[:100]}' before that operation; there is: {known}")
    return ids[name[1:]]
