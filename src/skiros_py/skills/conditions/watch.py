"""Conditions under watch: evaluated again only when something changed that they were found to read."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from skiros_py.skills.conditions.condition import Condition
from skiros_py.skills.conditions.pattern import Binding
from skiros_py.skills.conditions.reads import Key, ReadingView, touched_by
from skiros_py.skills.conditions.verdict import Verdict
from skiros_py.world.change import Change
from skiros_py.world.world import World


class _Watched:
    """One condition under watch.

    Attributes:
        stale: Whether something that it reads may have changed.
        senses: Whether it asks sensors, which change in every cycle.
        verdict: What was found last.
        keys: What was read for that.
    """

    def __init__(self, watch: Watch, condition: Condition, binding: Binding) -> None:
        self.watch = watch
        self.condition = condition
        self.binding = binding
        self.stale = True
        self.senses = False
        self.verdict = Verdict(True, "")
        self.keys: frozenset[Key] = frozenset()


class Watch:
    """Some conditions under watch; made by :meth:`Watches.add`."""

    def __init__(self, watches: Watches, conditions: Sequence[Condition], binding: Binding) -> None:
        self._watches = watches
        self._watched = tuple(_Watched(self, condition, binding) for condition in conditions)
        self._stale = True
        self._senses = False
        self._broken: Verdict | None = None

    def broken(self) -> Verdict | None:
        """Returns the verdict of the first condition that does not hold now; None while all hold.

        Raises:
            SkirosError: A condition cannot be evaluated.
        """
        if self._stale or self._senses:
            self._look()
        return self._broken

    @property
    def found(self) -> tuple[tuple[Condition, Verdict], ...]:
        """What was found last of each condition that was evaluated."""
        return tuple((one.condition, one.verdict) for one in self._watched if one.verdict.text)

    def touch(self) -> None:
        """Has those conditions that are stale evaluated when it is asked next."""
        self._stale = True

    def close(self) -> None:
        """Ends it; it answers as it did last."""
        self._stale = self._senses = False
        self._watches.forget(self._watched)

    def _look(self) -> None:
        self._stale = False
        try:
            for one in self._watched:
                if one.stale or one.senses:
                    self._watches.evaluate(one)
        except BaseException:
            self._stale = True
            raise
        self._senses = any(one.senses for one in self._watched)
        self._broken = next((one.verdict for one in self._watched if not one.verdict), None)


class Watches:
    """Watches conditions on the live world.

    Watches are added, asked and closed by one thread; the world may be written by any.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._readers: dict[Key, set[_Watched]] = {}
        self._heard = world.version
        self._lock = threading.Lock()
        self._unsubscribe = world.subscribe(self._hear)

    def add(self, conditions: Sequence[Condition], binding: Binding | None = None) -> Watch:
        """Takes conditions under watch.

        Args:
            conditions: What shall hold.
            binding: Element ids by parameter key; None when the arguments are ids or classes already.
        """
        return Watch(self, conditions, dict(binding or {}))

    def close(self) -> None:
        """Stops listening to changes; its watches must not be used any more."""
        self._unsubscribe()

    def evaluate(self, one: _Watched) -> None:
        """Evaluates a condition and notes what it read."""
        one.stale = False
        version, state = self._world.state()
        view = ReadingView(state, self._world.sensors)
        try:
            one.verdict = one.condition.evaluate(view, one.binding)
        except BaseException:
            one.stale = True
            raise
        one.senses = view.sensed
        self._note(one, frozenset(view.keys), version)

    def forget(self, watched: Sequence[_Watched]) -> None:
        """Ends the watch of conditions."""
        for one in watched:
            self._note(one, frozenset(), self._heard)

    def _note(self, one: _Watched, keys: frozenset[Key], version: int) -> None:
        with self._lock:
            for key in one.keys - keys:
                readers = self._readers[key]
                readers.discard(one)
                if not readers:
                    del self._readers[key]
            for key in keys - one.keys:
                self._readers.setdefault(key, set()).add(one)
            one.keys = keys
            if self._heard > version and keys:  # something changed while it was evaluated
                _touch(one)

    def _hear(self, change: Change) -> None:
        """Marks the conditions that read what changed. Called in the writer's thread, so it must be quick."""
        with self._lock:
            self._heard = change.number
            for edit in change.edits:
                for key in touched_by(edit, self._world.ontology):
                    for one in self._readers.get(key, ()):
                        _touch(one)


def _touch(one: _Watched) -> None:
    one.stale = True
    one.watch.touch()
