"""Changes of the world, as they are told."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

from skiros_py.api.world import Change, ChangePage, Undoable, Written
from skiros_py.errors import UnknownName
from skiros_py.server.problems import Problem
from skiros_py.world import change as world_change
from skiros_py.world.journal import Entry, Journal
from skiros_py.world.transaction import Transaction
from skiros_py.world.undo import last_undoable
from skiros_py.world.world import World

__all__ = ["change_page", "history", "one_change", "told_change", "undoable", "written"]

MOST_EDITS = 100
"""Edits of a change that are told in a list; a scene has thousands."""


def told_change(
    change: world_change.Change, wall: float | None = None, *, start: int = 0, most: int = MOST_EDITS
) -> Change:
    """Tells of a change.

    Args:
        change: The change.
        wall: When it was written [s since 1970, UTC]; None where that is not known.
        start: The first edit to tell.
        most: How many of them at most.
    """
    total = len(change.edits)
    end = min(start + most, total)
    return Change(
        number=change.number,
        author=change.author,
        writer=change.writer.value,
        reason=change.reason,
        time=change.time,
        written=None if wall is None else datetime.fromtimestamp(wall, UTC),
        undoes=change.undoes,
        edits=[edit.as_json() for edit in change.edits[start:end]],
        edits_total=total,
        next=str(end) if end < total else None,
    )


def change_page(world: World, beyond: int, limit: int, *, newest_first: bool) -> ChangePage:
    """Tells of some changes.

    Raises:
        Problem: Changes were asked for that are remembered no longer (410).
    """
    journal = _journal(world)
    if not newest_first and beyond < journal.first - 1 and beyond > 0:
        raise _forgotten(journal, f"the changes after {beyond}")
    return _page(journal, journal.page(beyond, limit + 1, newest_first=newest_first), limit)


def history(world: World, element: str, beyond: int, limit: int, *, newest_first: bool) -> ChangePage:
    """Tells of some changes of an element, which may be gone.

    Raises:
        UnknownName: There never was one of that id.
    """
    journal = _journal(world)
    if not (world.has(element) or journal.was_given(element)):
        raise UnknownName("element", element, list(world.snapshot().ids()))
    entries = journal.page(beyond, limit + 1, element=element, newest_first=newest_first)
    return _page(journal, entries, limit)


def one_change(world: World, number: int, start: int, most: int) -> Change:
    """Tells of one change.

    Raises:
        Problem: There is none of that number (404), or it is remembered no longer (410).
    """
    journal = _journal(world)
    if 0 < number < journal.first:
        raise _forgotten(journal, f"change {number}")
    found = journal.page(number - 1, 1) if 0 < number <= journal.version else ()
    if not found or found[0].change.number != number:
        raise Problem(404, "NotFound", f"there is no change {number}: the latest is {journal.version}")
    return told_change(found[0].change, found[0].wall, start=start, most=most)


def undoable(world: World) -> Undoable | None:
    """Tells what an undo would take back."""
    last = last_undoable(world.log)
    return last and Undoable(number=last.number, author=last.author, reason=last.reason)


def written(world: World, tx: Transaction, ids: dict[str, str] | None = None) -> Written:
    """Tells what a transaction did, once it is over."""
    return Written(version=world.version, change=tx.change and told_change(tx.change), ids=ids or {})


def _page(journal: Journal, entries: Sequence[Entry], limit: int) -> ChangePage:
    shown = entries[:limit]
    return ChangePage(
        items=[told_change(entry.change, entry.wall) for entry in shown],
        next=str(shown[-1].change.number) if len(entries) > limit else None,
        remembered_from=journal.first,
        version=journal.version,
    )


def _journal(world: World) -> Journal:
    if not isinstance(world.log, Journal):
        raise Problem(409, "NoJournal", "this world is kept nowhere: serve it with a data directory")
    return world.log


def _forgotten(journal: Journal, what: str) -> Problem:
    text = f"{what} cannot be told: changes are remembered from number {journal.first} on"
    return Problem(410, "Forgotten", text, remembered_from=journal.first)
