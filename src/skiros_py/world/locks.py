"""Locks on named elements: they block edits by other users and jobs, never a skill's reports of sensed data."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass

from skiros_py.errors import Locked, UsageError
from skiros_py.messages import Message, joined

_LONGEST = 24 * 3600.0
"""Maximum duration of a lock [s], since its owner may have left."""


@dataclass(frozen=True, slots=True)
class Lock:
    """The exclusive right of one person or job to edit an element.

    Attributes:
        element: Id of the element.
        owner: Its owner: the author of the edits it allows, or an id that distinguishes users of the same name.
        until: When it expires [s, the locks' clock].
        name: Display name of the owner, if different.
    """

    element: str
    owner: str
    until: float
    name: str = ""

    @property
    def shown(self) -> str:
        """Display name of the owner."""
        return self.name or self.owner


class Locks:
    """All locks of a world (the paper's lock service, §3.2). They live as long as the process.

    Locking a thing also locks its parts: the world checks parts and wholes.

    Args:
        clock: Returns the time [s]; must be monotonic.
        known: Returns whether there is an element with an id.
        related: Returns the wholes and parts of elements, on all levels.
    """

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        known: Callable[[str], bool] = lambda _: True,
        related: Callable[[Iterable[str]], Iterable[str]] = lambda _: (),
    ) -> None:
        self.clock = clock
        self._known = known
        self._related = related
        self._guard = threading.RLock()
        self._locks: dict[str, Lock] = {}

    def acquire(self, elements: Iterable[str], owner: str, seconds: float, name: str = "") -> tuple[Lock, ...]:
        """Locks all of the elements or none; the owner of a lock extends it.

        Args:
            elements: Their ids.
            owner: The owner of the locks.
            seconds: How long until the lock expires [s].
            name: Display name of the owner, if different.

        Raises:
            Locked: Another owner has locked one of them, its whole, or one of its parts.
            UsageError: The time is not positive or too long, there is no owner, or there is no such element.
        """
        if not isinstance(seconds, int | float) or not 0.0 < seconds <= _LONGEST:
            raise UsageError(f"a lock lasts more than 0 s and at most {_LONGEST:.0f} s, not {seconds!r}")
        if not isinstance(owner, str) or not owner.strip():
            raise UsageError("a lock needs an owner: the author of the edits that it allows")
        names = _names(elements)
        unknown = [element for element in names if not self._known(element)]
        if unknown:
            raise UsageError("there is nothing to lock by the name of {names}", names=", ".join(unknown))
        with self._guard:
            fault = self._fault([*names, *sorted({*self._related(names)}.difference(names))], owner)
            if fault is not None:
                raise fault
            until = self.clock() + seconds
            taken = tuple(Lock(element, owner, until, name) for element in names)
            self._locks.update((lock.element, lock) for lock in taken)
        return taken

    def release(self, owner: str, elements: Iterable[str] | None = None) -> None:
        """Ends locks of an owner: on the given elements, or all; other locks are unaffected."""
        with self._guard:
            wanted = self._locks.keys() if elements is None else _names(elements)
            for name in self._locks.keys() & wanted:
                if self._locks[name].owner == owner:
                    del self._locks[name]

    def held(self) -> tuple[Lock, ...]:
        """Returns the locks in force, by element."""
        with self._guard:
            self._expire()
            return tuple(self._locks[name] for name in sorted(self._locks))

    def unchanged(self) -> AbstractContextManager[bool]:
        """Prevents changes of locks during its 'with' block."""
        return self._guard

    def fault(self, elements: Iterable[str], owner: str) -> Locked | None:
        """Returns the error of an edit of elements that another owner has locked, or None."""
        if not self._locks:
            return None
        with self._guard:
            return self._fault(sorted(set(elements)), owner)

    def _fault(self, elements: Sequence[str], owner: str) -> Locked | None:
        self._expire()
        now = self.clock()
        others = [self._locks[name] for name in elements if name in self._locks and self._locks[name].owner != owner]
        if not others:
            return None
        locks = tuple((lock.element, lock.shown, lock.until - now) for lock in others)
        return Locked(
            joined(
                "; ",
                (
                    Message("{name} is locked by {who} for {left:.0f} s more", name=name, who=who, left=left)
                    for name, who, left in locks
                ),
            ),
            locks,
        )

    def _expire(self) -> None:
        now = self.clock()
        for name in [name for name, lock in self._locks.items() if lock.until <= now]:
            del self._locks[name]


def _names(elements: Iterable[str]) -> list[str]:
    return [elements] if isinstance(elements, str) else sorted(set(elements))
