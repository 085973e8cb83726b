"""Numbers that skills raise and lower: PDDL's functions, instead of one fact for each comparison of a property.

A change, and the number that an element has, are atoms like everything else that is said of elements. The comparisons
stay atoms, too: those that a change could ever make true are among the additions of an action, so that whatever
reasons without deletes (relevance, reachability, explanations) knows that the skill helps. Only the writer of PDDL and
the simulation of a task count exactly.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from math import inf

from skiros_py.planning.domain.literals import NOT, VALUE, compared
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.skills.conditions.condition import OPPOSITE, Comparison, Operator, kind_of
from skiros_py.skills.conditions.effects import Assign
from skiros_py.skills.conditions.pattern import NumberChange, number_of
from skiros_py.world.names import local_name
from skiros_py.world.view import WorldView

NUMBER = "number "
"""Prefix of the predicate stating which number a property has."""
ASSIGN, INCREASE, DECREASE = "assign", "increase", "decrease"


def change_atom(effect: Assign | NumberChange) -> Atom | None:
    """Returns what an effect does to a number as an atom: "increase my:charge 30.0" of the element.

    A second argument is the element whose property is the amount. None for effects on other values.
    """
    if isinstance(effect, NumberChange):
        word = INCREASE if effect.sign > 0 else DECREASE
        arguments = (effect.subject, *((effect.object,) if isinstance(effect.by, str) else ()))
        return Atom(f"{word} {effect.property} {effect.by}", arguments)
    if kind_of(effect.value) != "number":
        return None
    return Atom(f"{ASSIGN} {effect.property} {effect.value}", (effect.subject,))


def change_of(atom: Atom) -> tuple[str, str, float | str]:
    """Returns the word, the property and the amount of a change; the amount is a number or a property."""
    word, property_, amount = atom.predicate.split(" ")
    return word, property_, amount if len(atom.arguments) > 1 else float(amount)


def numbers_of(actions: Iterable[Action]) -> frozenset[str]:
    """Returns the properties that are PDDL functions: those that some action raises or lowers, and the amounts."""
    changes = [change_of(atom) for action in actions for atom in action.changes]
    relative = [(property_, amount) for word, property_, amount in changes if word != ASSIGN]
    return frozenset(name for pair in relative for name in pair if isinstance(name, str))


def number_needs(actions: Iterable[Action]) -> Iterator[str]:
    """Yields why planning needs a planner that can count, change by change."""
    for action in actions:
        for change in action.changes:
            word, property_, amount = change_of(change)
            if word != ASSIGN:
                by = local_name(amount) if isinstance(amount, str) else f"{amount:g}"
                effect = f"the {local_name(property_)} of {change.arguments[0].lstrip('?')} by {by}"
                yield f"skill '{action.skill}' {word}s {effect}, which a planner such as kairos can count"


def endless_changes(actions: Iterable[Action]) -> Iterator[str]:
    """Yields which changes of numbers no precondition limits: a search for a plan may then go on for ever."""
    for action in actions:
        for change in action.changes:
            word, property_, _ = change_of(change)
            if word != ASSIGN and not _limits(change, action.pre):
                yield f"nothing limits how far skill '{action.skill}' {word}s the {local_name(property_)}"


def number_compared(predicate: str) -> tuple[str, Comparison] | None:
    """Returns which property a predicate compares with which number, and how; None for other predicates.

    A negation is the opposite comparison: of an element without the number, neither holds.
    """
    if not predicate.removeprefix(NOT).startswith(VALUE):
        return None
    property_, comparison = compared(predicate.removeprefix(NOT))
    if kind_of(comparison.value) != "number":
        return None
    if predicate.startswith(NOT):
        comparison = Comparison(OPPOSITE[comparison.op], comparison.value)
    return property_, comparison


def number_facts(view: WorldView, properties: Collection[str], objects: Iterable[str]) -> set[Atom]:
    """Returns the numbers that elements have at the start."""
    values = ((name, element, number_of(view, element, name)) for name in properties for element in objects)
    return {Atom(f"{NUMBER}{name} {value}", (element,)) for name, element, value in values if value is not None}


def numbers_in(facts: Iterable[Atom]) -> dict[tuple[str, str], float]:
    """Returns the numbers of facts, by property and element."""
    told = ((fact.predicate.split(" "), fact) for fact in facts if fact.predicate.startswith(NUMBER))
    return {(property_, fact.arguments[0]): float(value) for (_, property_, value), fact in told}


def could_become_true(changes: Iterable[Atom], pre: Collection[Atom], asked: Iterable[str]) -> list[Atom]:
    """Returns the comparisons that raising and lowering numbers could make true, by any number of repetitions.

    Args:
        changes: Those of an action.
        pre: Its preconditions: from "at most 70", 30 more end at 100.
        asked: The predicates of all comparisons there are.
    """
    wanted = [(predicate, found) for predicate in asked if (found := number_compared(predicate)) is not None]
    return [
        Atom(predicate, change.arguments[:1])
        for change in changes
        for predicate, (property_, comparison) in wanted
        if property_ == change_of(change)[1] and _could_meet(comparison, change, pre)
    ]


def _could_meet(wanted: Comparison, change: Atom, pre: Collection[Atom]) -> bool:
    """Returns whether a change could bring a number to meet a comparison; what is assigned is known exactly."""
    word, _, amount = change_of(change)
    if word == ASSIGN:
        return False
    farther: Mapping[Operator, Operator] = {"=": ">="} if word == INCREASE else {"=": "<="}
    op = farther.get(wanted.op, wanted.op)
    return isinstance(amount, str) or op == "!=" or Comparison(op, wanted.value).allows(farthest(change, pre))


def farthest(change: Atom, pre: Collection[Atom]) -> float:
    """Returns how far a change can bring a number, by any number of repetitions; infinity if nothing limits it.

    Args:
        change: What an action does.
        pre: The preconditions of the action.
    """
    word, _, amount = change_of(change)
    if word == ASSIGN or isinstance(amount, str):
        return inf if isinstance(amount, str) else amount
    sign = 1.0 if word == INCREASE else -1.0
    end = min((sign * limit for limit in _limits(change, pre)), default=inf) + amount
    return sign * (round(end, 9) if end < inf else end)


def _limits(change: Atom, pre: Collection[Atom]) -> list[float]:
    """Returns the numbers beyond which an action with some preconditions does not raise, or lower, a number further."""
    word, property_, _ = change_of(change)
    said = (number_compared(atom.predicate) for atom in pre if atom.arguments == change.arguments[:1])
    ops = ("<", "<=", "=") if word == INCREASE else (">", ">=", "=")
    return [float(one[1].value) for one in said if one is not None and one[0] == property_ and one[1].op in ops]
