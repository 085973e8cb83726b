"""Reservations of robots and things: a task does not touch what another one plans to use or move."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from skiros_py.planning.domain.actions import with_defaults
from skiros_py.planning.plan import Step
from skiros_py.skills.conditions import Condition
from skiros_py.skills.conditions.effects import Assign, Effect, Relate, Unrelate, effects_of
from skiros_py.skills.conditions.pattern import NumberChange
from skiros_py.skills.inference.inferring import applying
from skiros_py.skills.skill import SkillDescription
from skiros_py.skills.surroundings import robot_of
from skiros_py.world.stock import is_token
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ROBOT


@dataclass(frozen=True, slots=True, eq=False)
class _Braking:
    """Elements of a finished task that are still moving."""

    who: str
    ids: frozenset[str]
    stands: Callable[[], bool]


class Reservations:
    """Robots and things of all tasks of a cell; used in the control thread only.

    A task gets everything it requested or nothing, in the order of requests; a waiting task keeps only what still
    moves. So the first to request is served first, and no task waits forever.
    """

    def __init__(self) -> None:
        self._held: dict[str, frozenset[str]] = {}
        self._wanted: dict[str, frozenset[str]] = {}
        self._braking: list[_Braking] = []

    def claim(self, who: str, wanted: Iterable[str], keeps: Iterable[str], *, starts: bool = True) -> bool:
        """Reserves everything the rest of a task's plan uses, replacing its earlier request.

        Args:
            who: Name of the task.
            wanted: Ids of robots and things.
            keeps: What it keeps while it waits because its steps still run there.
            starts: False while no step may start: then it takes nothing and does not block others.

        Returns:
            True if all of it is reserved.
        """
        needs, held = frozenset(wanted), self._held.get(who, frozenset())
        if needs <= held:
            self._wanted.pop(who, None)
            self._held[who] = needs
            return True
        self._held[who] = held.intersection(keeps)
        if not starts:
            self._wanted.pop(who, None)
            return False
        self._wanted[who] = needs
        if self.waits_for(who):
            return False
        self._held[who] |= self._wanted.pop(who)
        return True

    def waits_for(self, who: str) -> tuple[str, ...]:
        """Returns what a task's request is waiting for: "robot_1 (kit 7)"."""
        wanted = self._wanted.get(who, frozenset())
        return tuple(f"{id_} ({other})" for id_ in sorted(wanted) if (other := self._ahead(who, id_)) is not None)

    def of(self, who: str) -> frozenset[str]:
        """Returns everything a task holds."""
        return self._held.get(who, frozenset())

    def release(self, who: str, moving: Iterable[str] = (), stands: Callable[[], bool] = lambda: True) -> None:
        """Releases everything a task holds and withdraws its request.

        Args:
            who: Name of the task; it may be reused soon.
            moving: Those elements that become free only once they are at rest.
            stands: Returns whether they are at rest.
        """
        self._wanted.pop(who, None)
        ids = self._held.pop(who, frozenset()).intersection(moving)
        if ids:
            self._braking.append(_Braking(who, ids, stands))

    def of_others(self, who: str) -> frozenset[str]:
        """Returns everything other tasks hold or wait for."""
        all_ = (*self._held.items(), *self._wanted.items())
        theirs = frozenset(id_ for other, ids in all_ if other != who for id_ in ids)
        return theirs.union(*(one.ids for one in self._still_braking()))

    def _ahead(self, who: str, id_: str) -> str | None:
        """Returns the task that holds a thing or requested it earlier."""
        for one in self._still_braking():
            if id_ in one.ids:
                return one.who
        for other, ids in self._held.items():
            if other != who and id_ in ids:
                return other
        for other, ids in self._wanted.items():
            if other == who:
                break
            if id_ in ids:
                return other
        return None

    def _still_braking(self) -> list[_Braking]:
        self._braking = [one for one in self._braking if not one.stands()]
        return self._braking


def in_hands(view: WorldView, ids: Iterable[str]) -> frozenset[str]:
    """Returns which of the given things are held or carried by robots, and these robots."""
    found: set[str] = set()
    for id_ in ids:
        placement = view.placement(id_) if view.has(id_) else None
        if placement is not None and (robot := robot_of(view, placement.place)) != placement.place:
            found |= {id_, robot}
    return frozenset(found)


def used_by(steps: Sequence[Step], skills: Mapping[str, SkillDescription], view: WorldView) -> frozenset[str]:
    """Returns what steps use exclusively: robots, moved elements and their target places."""
    robots = {robot_of(view, step.arguments[skills[step.skill].agent]) for step in steps}
    changed = (id_ for step in steps for id_ in _changed(step, skills[step.skill], view) if not is_token(id_))
    return frozenset(robots.union(changed))  # things in stock are first come, first served


def _changed(step: Step, skill: SkillDescription, view: WorldView) -> set[str]:
    values = with_defaults(skill, step.arguments)
    return {id_ for post in applying(skill.post, values) for id_ in _ends(post.bind(values), view)}


def _ends(condition: Condition, view: WorldView) -> set[str]:
    return {id_ for effect in effects_of(condition) for id_ in _ends_of(effect, view)}


def _ends_of(effect: Effect, view: WorldView) -> tuple[str, ...]:
    match effect:
        case Relate(relation, subject, object_) if view.ontology.is_placement(relation):
            element, placement = view.ontology.placed(subject, relation, object_)
            own = robot_of(view, placement.place) != placement.place  # in a hand of the robot
            drives = view.has(element) and view.ontology.is_a(view.element(element).type, ROBOT)
            return (element,) if drives or own else (element, placement.place)
        case Relate(_, subject, _) | Unrelate(_, subject, _) | Assign(_, subject) | NumberChange(_, subject):
            return (subject,)
