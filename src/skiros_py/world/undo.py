"""Taking back what a person did last."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.errors import WorldError
from skiros_py.world.change import Change, Writer
from skiros_py.world.world import World

__all__ = ["last_undoable", "undo"]


def last_undoable(changes: Sequence[Change]) -> Change | None:
    """Returns the last change by a person that was not taken back yet, or None."""
    undone = {change.undoes for change in changes}
    by_people = (c for c in reversed(changes) if c.writer is Writer.PERSON and c.undoes is None)
    return next((change for change in by_people if change.number not in undone), None)


def undo(world: World, author: str) -> Change:
    """Takes back the last edit that a person made, as a new change; called again, it takes back the one before.

    Args:
        world: The world.
        author: Who wants it.

    Raises:
        WorldError: There is nothing to take back, or something was built on it since; the text says what.
    """
    changes = world.changes
    last = last_undoable(changes)
    if last is None:
        raise WorldError("there is nothing to undo: no edit by a person that was not undone already")
    later = _built_on(last, changes)
    if later:
        names = ", ".join(sorted(later[0].marks() & last.marks()))
        raise WorldError(
            f"change {last.number} ({last.author}: {last.reason}) cannot be undone: {names} changed since,"
            f" by {later[0].author} ({later[0].reason})"
        )
    reason = f"undoes change {last.number}: {last.reason}"
    with world.transaction(author, reason, writer=Writer.PERSON, undoes=last.number) as tx:
        tx.apply([edit.inverse() for edit in reversed(last.edits)])
    return world.changes[-1]


def _built_on(change: Change, changes: Sequence[Change]) -> list[Change]:
    """Later changes of the same things, but for those that were undone together with what undid them."""
    later = [c for c in changes if c.number > change.number]
    undone = {c.undoes for c in later if c.undoes is not None}
    standing = [c for c in later if c.undoes is None and c.number not in undone]
    return [c for c in standing if c.marks() & change.marks() or (_sets_goals(c) and _sets_goals(change))]


def _sets_goals(change: Change) -> bool:
    return any(edit.marks() == () for edit in change.edits)
