"""Conditions under watch: evaluated again only when something changed that their evaluation read."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from skiros_py.skills.conditions.condition import Condition
from skiros_py.skills.conditions.pattern import Binding, Verdict
from skiros_py.world.change import Change, Edit, ElementEdit, GoalsEdit, PlacementEdit, PropertyEdit, SourceEdit
from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.index import Index
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import computed_others
from skiros_py.world.taught import TEACHABLE, lessons
from skiros_py.world.terms import Family
from skiros_py.world.view import Sensors, WorldView
from skiros_py.world.world import World

Key = tuple[str, ...]
"""A piece of the world: its kind, and which.

``is`` an element's being there, ``all`` of its own values, one ``value``, its ``place``, what it relates ``from`` and
``to``, whether a relation is ``between`` two, who is of a ``class``.
"""


class ReadingView(WorldView):
    """One state of the world that notes what is read of it.

    Reasoners are asked with this view, so what they read is noted too.

    Attributes:
        keys: What was read so far.
        sensed: Whether sensors were asked for.
    """

    def __init__(self, state: Index, sensors: Sensors) -> None:
        self.keys: set[Key] = set()
        self.sensed = False
        self._base = state
        self._sensors = sensors

    @property
    def sensors(self) -> Sensors:
        """What devices say in this cycle."""
        self.sensed = True
        return self._sensors

    def element(self, element_id: str) -> Element:
        """Returns one element."""
        self.keys |= {("is", element_id), ("all", element_id)}
        return self._base.element(element_id)

    def has(self, element_id: str) -> bool:
        """Returns True when there is an element of that id."""
        self.keys.add(("is", element_id))
        return self._base.has(element_id)

    def instances(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of all elements of a class."""
        self.keys.add(("class", class_))
        return self._base.instances(class_)

    def some_instances(self, class_: str, limit: int, after: str = "") -> tuple[str, ...]:
        """Returns the first of the elements of a class."""
        self.keys.add(("class", class_))
        return self._base.some_instances(class_, limit, after)

    def instances_among(self, class_: str, ids: Iterable[str]) -> tuple[str, ...]:
        """Returns which of some ids are of elements of a class."""
        asked = tuple(ids)
        self.keys.update(("is", name) for name in asked)
        return self._base.instances_among(class_, asked)

    def abstracts(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of the abstract elements of a class."""
        self.keys.add(("class", class_))
        return self._base.abstracts(class_)

    def value(self, element_id: str, property_: str) -> Value | None:
        """Returns a property's value."""
        self.keys |= {("is", element_id), ("value", element_id, property_)}
        if property_ in TEACHABLE:
            lessons(self)  # what is taught later counts, too
        return self._base.value(element_id, property_)

    def objects(self, subject: str, relation: str) -> tuple[str, ...]:
        """Returns ids of what the subject is related to."""
        if self.ontology.family(relation) is Family.COMPUTED:
            return computed_others(self, subject, relation)
        self.keys.update(("from", subject, below) for below in self.ontology.sub_relations(relation))
        return self._base.objects(subject, relation)

    def subjects(self, relation: str, object_: str) -> tuple[str, ...]:
        """Returns ids of what is related to the object."""
        if self.ontology.family(relation) is Family.COMPUTED:
            return computed_others(self, object_, relation, backwards=True)
        self.keys.update(("to", below, object_) for below in self.ontology.sub_relations(relation))
        return self._base.subjects(relation, object_)

    def related(self, subject: str, relation: str, object_: str) -> bool:
        """Returns True when the relation holds between the two."""
        if self.ontology.family(relation) is Family.COMPUTED:
            return self.reasoners.answer(self, subject, relation, object_).holds
        self.keys.update(("between", subject, below, object_) for below in self.ontology.sub_relations(relation))
        return self._base.related(subject, relation, object_)

    def placement(self, element_id: str) -> Placement | None:
        """Returns where an element is."""
        self.keys |= {("is", element_id), ("place", element_id)}
        return self._base.placement(element_id)

    def any_placed(self, class_: str, relation: str) -> bool:
        """Returns True when exactly this placement relation holds for an element of a class."""
        placements = map(self.placement, self.instances(class_))
        return any(one is not None and one.relation == relation for one in placements)


def touched_by(edit: Edit, ontology: Ontology) -> Iterator[Key]:
    """Yields what an edit changes, as it would be read."""
    match edit:
        case ElementEdit(element, old, new):
            yield ("is", element)
            type_ = (new or old or Element(element, "", "")).type
            yield from (("class", above) for above in ontology.ancestors(type_))
        case PropertyEdit(element, property_):
            yield from (("all", element), ("value", element, property_))
        case PlacementEdit(element, old_place, new_place):
            yield ("place", element)
            for place in filter(None, (old_place, new_place)):
                yield from _statement(*ontology.placement_statement(element, place))
        case GoalsEdit() | SourceEdit():
            pass
        case _:
            yield from _statement(edit.subject, edit.relation, edit.object)


def _statement(subject: str, relation: str, object_: str) -> Iterator[Key]:
    yield from (("from", subject, relation), ("to", relation, object_), ("between", subject, relation, object_))


_UNSEEN = Verdict(True, "")


@dataclass(slots=True, eq=False)
class Reads:
    """What was read of the world for an answer; told of changes by :meth:`Watches.note`.

    Attributes:
        stale: Whether some of it may have changed, or nothing was read yet. False is set before the world is read, so
            that later changes count.
        keys: What was read.
    """

    stale: bool = True
    keys: frozenset[Key] = frozenset()

    def touch(self) -> None:
        """Hears that some of it has changed; called in the writer's thread."""
        self.stale = True


@dataclass(slots=True, eq=False, kw_only=True)
class _Watched(Reads):
    """One condition under watch.

    Attributes:
        senses: Whether it asks sensors, which change in every cycle.
        verdict: What was found last.
    """

    watch: Watch
    condition: Condition
    binding: Binding
    senses: bool = False
    verdict: Verdict = _UNSEEN

    def touch(self) -> None:
        self.stale = True
        self.watch.stale = True


class Watch:
    """Some conditions under watch; made by :meth:`Watches.add`.

    Attributes:
        stale: Whether something that one of them reads may have changed.
    """

    def __init__(self, watches: Watches, conditions: Sequence[Condition], binding: Binding) -> None:
        self._watches = watches
        self._watched = tuple(_Watched(watch=self, condition=condition, binding=binding) for condition in conditions)
        self.stale = True
        self._senses = False
        self._broken: Verdict | None = None

    def broken(self) -> Verdict | None:
        """Returns the verdict of the first condition that does not hold now; None while all hold.

        Raises:
            SkirosError: A condition cannot be evaluated.
        """
        if self.stale or self._senses:
            self._look()
        return self._broken

    @property
    def found(self) -> tuple[tuple[Condition, Verdict], ...]:
        """What was found last of each condition that was evaluated."""
        return tuple((one.condition, one.verdict) for one in self._watched if one.verdict.text)

    def close(self) -> None:
        """Ends it; it answers as it did last."""
        self.stale = self._senses = False
        self._watches.forget(self._watched)

    def _look(self) -> None:
        self.stale = False
        try:
            for one in self._watched:
                if one.stale or one.senses:
                    self._watches.evaluate(one)
        except BaseException:
            self.stale = True
            raise
        self._senses = any(one.senses for one in self._watched)
        self._broken = next((one.verdict for one in self._watched if not one.verdict), None)


class Watches:
    """Watches conditions on the live world.

    Watches are added, asked and closed by one thread; the world may be written by any.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._readers: dict[Key, set[Reads]] = {}
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
        state = self._world.snapshot()
        view = ReadingView(state, self._world.sensors)
        try:
            one.verdict = one.condition.evaluate(view, one.binding)
        except BaseException:
            one.stale = True
            raise
        one.senses = view.sensed
        self.note(one, frozenset(view.keys), state.version)

    def forget(self, watched: Sequence[_Watched]) -> None:
        """Ends the watch of conditions."""
        for one in watched:
            self.note(one, frozenset(), self._heard)

    def note(self, one: Reads, keys: frozenset[Key], version: int) -> None:
        """Notes what was read for an answer, and of which version of the world."""
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
                one.touch()

    def _hear(self, change: Change) -> None:
        """Marks the conditions that read what changed. Called in the writer's thread, so it must be quick."""
        with self._lock:
            self._heard = change.number
            for edit in change.edits:
                for key in touched_by(edit, self._world.ontology):
                    for one in self._readers.get(key, ()):
                        one.touch()
