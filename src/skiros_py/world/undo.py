"""Undoing the last edit made by a user."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.errors import StaleVersion, WorldError
from skiros_py.world.change import Change, Writer
from skiros_py.world.past import subjects_of
from skiros_py.world.world import World


def undo(world: World, author: str, *, expects: int | None = None, holder: str = "") -> Change:
    """Undoes the last edit made by a user, as a new change; called again, it undoes the one before.

    Args:
        world: The world.
        author: The author of the undo.
        expects: Number of the change the caller expects to undo; None for the last one.
        holder: The lock holder, if different from the author.

    Raises:
        StaleVersion: It is no longer the last.
        WorldError: There is nothing to undo, or later changes depend on it; the text names them.
    """
    last = world.log.undoable()
    if expects is not None and (last is None or last.number != expects):
        now = "none" if last is None else f"change {last.number} ({last.author}: {last.reason})"
        raise StaleVersion(f"change {expects} is not the one that can be undone now, which is {now}: look again")
    if last is None:
        since = f" since change {world.log.first}, from which on changes are remembered" if world.log.first > 1 else ""
        raise WorldError(f"there is nothing to undo: no edit by a person that was not undone already{since}")
    reason = f"undoes change {last.number}: {last.reason}"
    with world.transaction(author, reason, writer=Writer.PERSON, undoes=last.number, holder=holder) as tx:
        _check(last, world.log.about(subjects_of(last), after=last.number))  # no one else can write inside the block
        tx.apply([edit.inverse() for edit in reversed(last.edits)])
    if tx.change is None:
        raise WorldError(f"change {last.number} ({last.author}: {last.reason}) has no effect left that could be undone")
    return tx.change


def _check(change: Change, later: Sequence[Change]) -> None:
    """Refuses if there is a later change of the same things that has not been undone."""
    undone = {c.undoes for c in later}
    if change.number in undone:
        raise WorldError(f"change {change.number} ({change.author}: {change.reason}) was just undone by somebody else")
    standing = [c for c in later if c.undoes is None and c.number not in undone]
    if standing:
        first = standing[0]
        names = ", ".join(sorted(first.marks() & change.marks())) or "the goals"
        raise WorldError(
            f"change {change.number} ({change.author}: {change.reason}) cannot be undone: {names} changed since,"
            f" by {first.author} ({first.reason})"
        )
