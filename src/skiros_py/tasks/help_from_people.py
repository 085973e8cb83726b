"""Asks the user what to do about a condition that the robots cannot achieve."""

from __future__ import annotations

import enum
from collections.abc import Iterable
from contextlib import suppress

from skiros_py.errors import DescriptionError, SkirosError
from skiros_py.messages import Message
from skiros_py.planning.problem.stock import believed
from skiros_py.skills.conditions import Condition
from skiros_py.skills.conditions.effects import effects_of, write_effects
from skiros_py.skills.context import QuestionKind
from skiros_py.skills.outcome import Failure
from skiros_py.skills.primitive import Execution
from skiros_py.skills.restart import last_place
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.handle import TaskHandle
from skiros_py.world.change import Writer
from skiros_py.world.element import Placement
from skiros_py.world.poses import forget_looks
from skiros_py.world.vocabulary import MISSING
from skiros_py.world.world import World


class Choice(enum.StrEnum):
    """The user's options."""

    RETRY = "retry"
    """The robots try again."""
    LOOK = "look again"
    """The missing things that it needs are back where they were, and are looked for there; offered if there are any."""
    BY_HAND = "done by hand"
    """The user has achieved it by hand."""
    SKIP = "skip"
    """It is given up; the rest of the goal is pursued."""
    ABORT = "abort"
    """The whole task ends."""


def ask_for_help(
    task: TaskHandle, context: TaskContext, condition: Condition, text: str
) -> Execution[tuple[Choice, str]]:
    """Posts a question and waits for the answer; the question is withdrawn when the caller stops waiting.

    It is answered with "retry" automatically when the set of skill managers changes: other plans may be possible now.

    Returns:
        The answer, and who gave it.
    """
    questions, able = context.questions, _able(context)
    lost = lost_things(context.world, condition)
    options = tuple(choice.value for choice in Choice if choice is not Choice.LOOK or lost)
    asked = questions.ask(QuestionKind.CHOOSE, text, options, asker=task.name, time=context.now)
    task.question, before, task.phase = asked.question, task.phase, "waiting"
    try:
        while asked.answer is None:
            if _able(context) != able:
                return Choice.RETRY, "the coming or going of a skill manager"
            yield
        return Choice(asked.answer), asked.by
    finally:
        questions.withdraw(asked)
        task.question, task.phase = None, before


def lost_things(world: World, condition: Condition) -> dict[str, Placement]:
    """Returns the missing things that a condition names, by id or by class, with the place where each was last."""
    named = {a for a in condition.arguments if world.has(a)}
    classes = [a for a in condition.arguments if a in world.ontology.classes]
    things = named.union(*(world.instances(class_) for class_ in classes))
    places = {thing: last_place(world, thing) for thing in sorted(things) if world.value(thing, MISSING) is True}
    return {thing: at for thing, at in places.items() if at is not None}


def believe_back(context: TaskContext, condition: Condition, by: str) -> Failure | None:
    """Puts missing things back where they were, in the world model, because the user says so; a look must find them.

    Returns:
        Why it could not be applied, or None.
    """
    world = context.world
    try:
        with world.transaction("operator", Message("it is back, says {by}", by=by), writer=Writer.PERSON) as tx:
            for thing, at in lost_things(world, condition).items():
                tx.place(thing, at.relation, at.place)
                forget_looks(tx, thing)
    except SkirosError as error:
        return Failure(str(error))
    return None


def believe_done(context: TaskContext, condition: Condition, by: str) -> Failure | None:
    """Makes a condition true in the world model because the user says so, if its effects are well defined.

    Returns:
        Why it could not be applied, or None.
    """
    world, refused = context.world, ""
    if not any(argument in world.ontology.classes for argument in condition.arguments):
        try:
            with suppress(DescriptionError):
                write_by_hand(world, (condition,), by)
        except SkirosError as error:
            refused = str(error)
    verdict = believed(condition, world)
    why = refused or verdict.why
    return (
        None if verdict else Failure(Message("{condition} is still not believed: {why}", condition=condition, why=why))
    )


def _able(context: TaskContext) -> frozenset[tuple[str, str]]:
    return frozenset((agent, skill) for agent, manager in context.managers.items() for skill in manager.descriptions)


def write_by_hand(world: World, conditions: Iterable[Condition], by: str, what: str = Message("done by hand")) -> None:
    """Makes conditions true in the world model, all or none.

    Args:
        world: The live world model.
        conditions: The conditions that now hold.
        by: Who says so.
        what: Description of the change, for the change log.

    Raises:
        DescriptionError: The effects of a condition are undefined ("one of these").
        WorldError: The world model rejects the change.
    """
    effects = [effect for condition in conditions for effect in effects_of(condition)]
    with world.transaction("operator", Message("{what}, says {by}", what=what, by=by), writer=Writer.PERSON) as tx:
        write_effects(tx, world.ontology, effects)
