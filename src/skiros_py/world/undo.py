"""Undoing the last edit made by a user, and redoing it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from skiros_py.errors import StaleVersion, WorldError
from skiros_py.messages import Message
from skiros_py.world.change import Change, SourceEdit, Writer
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
    _require(
        last,
        expects,
        partial(Message, "change {seen} is not the one that can be undone now, which is {now}: look again"),
    )
    if last is None:
        raise WorldError(
            "there is nothing to undo: no edit by a person since change {first} that was not undone already",
            first=world.log.first,
        )
    return _revert(
        world, last, Message("undoes change {number}: {reason}", number=last.number, reason=last.reason), author, holder
    )


def redo(world: World, author: str, *, expects: int | None = None, holder: str = "") -> Change:
    """Reverts the last undo, as a new change, until a user has made another edit; called again, the undo before it.

    Args:
        world: The world.
        author: The author of the redo.
        expects: Number of the undo that the caller expects to be reverted; None for the last one.
        holder: The lock holder, if different from the author.

    Raises:
        StaleVersion: It is no longer the last.
        WorldError: There is nothing to redo, or later changes depend on it; the text names them.
    """
    last = world.log.redoable()
    _require(
        last,
        expects,
        partial(Message, "undo {seen} is not the one that can be reverted now, which is {now}: look again"),
    )
    if last is None:
        raise WorldError(Message("there is nothing to redo: nothing was undone since the last edit by a person"))
    if any(isinstance(edit, SourceEdit) for edit in last.edits):
        raise WorldError(Message("there is nothing to redo: a scene that was taken back is loaded again instead"))
    return _revert(world, last, Message("redoes what was undone: {reason}", reason=last.reason), author, holder)


def _require(last: Change | None, expects: int | None, refusal: Callable[..., Message]) -> None:
    if expects is not None and (last is None or last.number != expects):
        now = Message("no change")
        if last is not None:
            now = Message("change {number} ({author}: {reason})", **_said(last))
        raise StaleVersion(refusal(seen=expects, now=now))


def _revert(world: World, change: Change, reason: str, author: str, holder: str) -> Change:
    with world.transaction(author, reason, writer=Writer.PERSON, undoes=change.number, holder=holder) as tx:
        # No one else can write inside the block.
        _check(change, world.log.about(subjects_of(change), after=change.number))
        tx.apply([edit.inverse() for edit in reversed(change.edits)])
    if tx.change is None:
        raise WorldError(
            "change {number} ({author}: {reason}) has no effect left that could be undone", **_said(change)
        )
    return tx.change


def _check(change: Change, later: Sequence[Change]) -> None:
    """Refuses if there is a later change of the same things that has not been undone."""
    reverted = {c.undoes for c in later}
    undone = {c.undoes for c in later if c.number not in reverted}
    if change.number in undone:
        raise WorldError("change {number} ({author}: {reason}) was just undone by somebody else", **_said(change))
    standing = [c for c in later if c.undoes is None and c.number not in undone]
    if standing:
        first = standing[0]
        names = ", ".join(sorted(first.marks() & change.marks())) or "the goals"
        raise WorldError(
            "change {number} ({author}: {reason}) cannot be undone: {names} changed since, by {other} ({why})",
            names=names,
            other=first.author,
            why=first.reason,
            **_said(change),
        )


def _said(change: Change) -> dict[str, object]:
    """Returns what messages say of a change."""
    return {"number": change.number, "author": change.author, "reason": change.reason}
