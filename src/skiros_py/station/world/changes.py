"""Changes of the world as the API shows them."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.api.wire import moment
from skiros_py.api.world import Change, ChangePage, Undoable, Written
from skiros_py.errors import Refused
from skiros_py.world import change as world_change
from skiros_py.world.change import Edit
from skiros_py.world.journal import Head, Journal
from skiros_py.world.transaction import Transaction
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
        raise _forgotten(journal, f"change {number}")
    heads = journal.page(number - 1, 1) if 0 < number <= journal.version else ()
    if not heads:
        raise Refused("NotFound", f"there is no change {number}: the latest is {journal.version}")
    head = heads[0]
    return _view_of(head.change, journal.edits(head, start, most), start, head.edits, head.wall)


def undoable(world: World) -> Undoable | None:
    """Returns the edit that an undo would revert."""
    head = _journal(world).undoable()
    if head is None:
        return None
    return Undoable.view_of(head.change)


def written(world: World, tx: Transaction, ids: dict[str, str] | None = None) -> Written:
    """Returns the effects of a finished transaction."""
    change = None if tx.change is None else change_view(tx.change)
    return Written(version=world.version, change=change, ids=ids or {})


def _page(journal: Journal, heads: Sequence[Head], limit: int) -> ChangePage:
    shown = heads[:limit]
    return ChangePage(
        items=[_view_of(h.change, h.change.edits[:_MOST_EDITS], 0, h.edits, h.wall) for h in shown],
        next=str(shown[-1].change.number) if len(heads) > limit else None,
        remembered_from=journal.first,
        version=journal.version,
    )


def _journal(world: World) -> Journal:
    if not isinstance(world.log, Journal):
        raise Refused("NoJournal", "this world is kept nowhere: serve it with a data directory")
    return world.log


def _forgotten(journal: Journal, what: str) -> Refused:
    text = f"{what} cannot be told: changes are remembered from number {journal.first} on"
    return Refused("Forgotten", text, remembered_from=journal.first)
