"""The order in which robots visit places and work on things, if the user specifies one (paper §6.3).

Locations may have a sequence number and a work number; they apply if enabled on the scene's floor. Within one task no
robot visits a lower number after a higher one, like pickers on their round through a warehouse; and the conditions
about the thing with the lower work number, such as the first of several kits, are fulfilled before those about the
next.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy

from skiros_py.messages import Message
from skiros_py.skills.conditions import Condition, Verdict, judge
from skiros_py.skills.conditions.effects import Relate, effects_of
from skiros_py.skills.conditions.pattern import number_of
from skiros_py.skills.inference.inferring import applying
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView, wholes
from skiros_py.world.vocabulary import FLOOR, ROBOT, SEQUENCE_NUMBER, USE_SEQUENCE_NUMBERS, WORK_NUMBER


def counts(view: WorldView) -> bool:
    """Returns whether sequence and work numbers apply in a scene."""
    if USE_SEQUENCE_NUMBERS not in view.ontology.properties:
        return False
    return any(view.value(floor, USE_SEQUENCE_NUMBERS) is True for floor in view.instances(FLOOR))


def without_numbers(view: WorldView) -> Overlay:
    """Returns the world with sequence and work numbers disabled."""
    overlay = Overlay(view)
    for floor in view.instances(FLOOR):
        overlay.set_value(floor, USE_SEQUENCE_NUMBERS, False)
    return overlay


def sequence_number(view: WorldView, location: str) -> int | None:
    """Returns the number of a location; None if it may be visited at any time."""
    return _number(view, location, SEQUENCE_NUMBER)


def turn_of(view: WorldView, place: str) -> tuple[int, str] | None:
    """Returns the work number of a place or of the whole it is part of, with its owner; None if there is none."""
    numbers = ((_number(view, whole, WORK_NUMBER), whole) for whole in wholes(view, place))
    return next(((number, whole) for number, whole in numbers if number is not None), None)


def turns_of_goal(view: WorldView, goal: Sequence[Condition]) -> tuple[tuple[int, str] | None, ...]:
    """Returns the work number and owner of each condition of a goal; of several, the last."""
    return tuple(_turn_of_condition(view, condition) for condition in goal)


def _turn_of_condition(view: WorldView, condition: Condition) -> tuple[int, str] | None:
    turns = [turn for a in condition.arguments if view.has(a) and (turn := turn_of(view, a))]
    return max(turns, default=None)


def _number(view: WorldView, element: str, property_: str) -> int | None:
    number = number_of(view, element, property_)
    return None if number is None else int(number)


class Round:
    """Tracks one task's progress through the numbers.

    Args:
        view: The world that the task starts from.
        goal: The goal of the task.
        reached: The highest number that each robot has visited in this task so far.

    Attributes:
        reached: The same, kept up to date by :meth:`take`.
    """

    def __init__(
        self, view: WorldView, goal: Sequence[Condition] = (), reached: Mapping[str, int] | None = None
    ) -> None:
        self.reached = dict(reached or {})
        self._counts = counts(view)
        turns = turns_of_goal(view, goal) if self._counts else ()
        self._wanted = [(turn, condition) for turn, condition in zip(turns, goal, strict=False) if turn is not None]

    def copy(self) -> Round:
        """Returns a copy that goes on by itself."""
        other = copy(self)
        other.reached = dict(self.reached)
        return other

    def take(self, view: WorldView, skill: SkillDescription, arguments: Mapping[str, str]) -> Verdict | None:
        """Applies a step with the moves in its postconditions.

        Args:
            view: The world just before it.
            skill: Its skill.
            arguments: Its arguments, defaults included.

        Returns:
            Why it violates the order; None if it does not.
        """
        if not self._counts:
            return None
        ontology = view.ontology
        for condition in applying(skill.post, arguments):
            for effect in effects_of(condition.bind(arguments)):
                if isinstance(effect, Relate) and ontology.is_placement(effect.relation):
                    moved, placement = ontology.placed(effect.subject, effect.relation, effect.object)
                    is_robot = ontology.is_a(view.element(moved).type, ROBOT)
                    wrong = (self._visit if is_robot else self._begin)(view, moved, placement.place)
                    if wrong is not None:
                        return wrong
        return None

    def _visit(self, view: WorldView, robot: str, place: str) -> Verdict | None:
        number = sequence_number(view, place)
        if number is None:
            return None
        last = self.reached.get(robot, number)
        if number < last:
            text = Message(
                "{robot} comes to {place} (sequence number {number}) after number {last}",
                robot=robot,
                place=place,
                number=number,
                last=last,
            )
            return Verdict(
                False,
                Message(
                    "{text}: sequence numbers count here, so no robot visits a lower one after a higher", text=text
                ),
            )
        self.reached[robot] = number
        return None

    def _begin(self, view: WorldView, moved: str, place: str) -> Verdict | None:
        turn = turn_of(view, place)
        if turn is None:
            return None
        for earlier, condition in self._wanted:
            if earlier[0] < turn[0] and not judge(condition, view):
                text = Message(
                    "{moved} goes to {place} (work number {number}) before {condition} holds",
                    moved=moved,
                    place=turn[1],
                    number=turn[0],
                    condition=condition,
                )
                first = {"place": earlier[1], "number": earlier[0]}
                return Verdict(
                    False, Message("{text}: {place} has work number {number} and is done first", text=text, **first)
                )
        return None
