"""Reads goals written by people and checks every word of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedEOF, UnexpectedInput, UnexpectedToken

from skiros_py.errors import GoalSyntaxError, UnknownName, UsageError
from skiros_py.skills.conditions import Condition, ConditionType
from skiros_py.world.view import WorldView

__all__ = ["parse_goal"]

_WORDS = {
    "LPAR": "'('",
    "RPAR": "')'",
    "COMMA": "','",
    "NAME": "a name",
    "NOT": "'not'",
    "AND": "'and'",
    "$END": "the end",
}


def parse_goal(texts: Sequence[str], view: WorldView, conditions: Mapping[str, ConditionType]) -> tuple[Condition, ...]:
    """Reads goal texts such as ``"ObjectAtLocation(Starter, kit_1_a) and RobotAtLocation(robot_1, pallet_a)"``.

    Args:
        texts: One or more texts; all their conditions must hold together.
        view: The world, for elements and classes; an element may be given by id or by its label.
        conditions: The condition words there are.

    Raises:
        GoalSyntaxError: A text does not follow the grammar.
        UnknownName: A word is unknown; the message gives the nearest that exists.
        UsageError: An argument is of the wrong class, or abstract where that is not allowed.
    """
    found = [condition for text in texts for condition in _parse(text, view, conditions)]
    return tuple(dict.fromkeys(found))


@cache
def _grammar() -> Lark:
    text = (Path(__file__).parent / "goal_grammar.lark").read_text(encoding="utf-8")
    return Lark(text, parser="lalr", propagate_positions=True, maybe_placeholders=True)


def _parse(text: str, view: WorldView, conditions: Mapping[str, ConditionType]) -> list[Condition]:
    try:
        tree = _grammar().parse(text)
    except UnexpectedInput as error:
        raise GoalSyntaxError(text, _column(error, text), _reason(error)) from error
    return [_condition(child, view, conditions) for child in tree.children if isinstance(child, Tree)]


def _column(error: UnexpectedInput, text: str) -> int:
    at_end = isinstance(error, UnexpectedEOF) or (isinstance(error, UnexpectedToken) and error.token.type == "$END")
    return len(text.rstrip()) + 1 if at_end else error.column


def _reason(error: UnexpectedInput) -> str:
    names: set[str] = set()
    if isinstance(error, UnexpectedToken):
        names = set(error.accepts or error.expected)
    elif isinstance(error, UnexpectedCharacters):
        names = set(error.allowed or ())
    expected = " or ".join(sorted(_WORDS[name] for name in names if name in _WORDS))
    return f"expected {expected or 'a condition such as InKit(Starter, kit_1)'}"


def _condition(tree: Tree[Any], view: WorldView, conditions: Mapping[str, ConditionType]) -> Condition:
    negation, word, *rest = tree.children
    names = [str(argument.children[0]) for argument in rest if isinstance(argument, Tree)]
    type_ = _word(word, conditions)
    if len(names) != len(type_.roles):
        roles = ", ".join(f"{role.name}: {role.class_.partition(':')[2]}" for role in type_.roles)
        raise UsageError(f"{type_.name} takes {len(type_.roles)} arguments ({roles}), got {len(names)}")
    arguments = [_argument(name, index, type_, view) for index, name in enumerate(names)]
    condition = type_(*arguments)
    return ~condition if negation is not None else condition


def _word(word: Token | Tree[Any] | None, conditions: Mapping[str, ConditionType]) -> ConditionType:
    folded = {name.casefold(): type_ for name, type_ in conditions.items()}
    if str(word).casefold() not in folded:
        raise UnknownName("condition", str(word), conditions, where="in the goal")
    return folded[str(word).casefold()]


def _argument(name: str, index: int, type_: ConditionType, view: WorldView) -> str:
    role = type_.roles[index]
    where = f"{type_.name}, argument {index + 1} ({role.name})"
    element = _element(name, view, role.class_)
    if element is not None:
        class_ = view.element(element).type
        if not view.ontology.is_a(class_, role.class_):
            fitting = ", ".join(view.instances(role.class_)) or "none"
            raise UsageError(f"{where}: {name} is a {_local(class_)}, not a {_local(role.class_)}. There is {fitting}.")
        return element
    return _abstract(name, role.class_, type_, where, view)


def _element(name: str, view: WorldView, class_: str) -> str | None:
    """An id comes first, then a class (a part without a label of its own is called like its class), then a label."""
    if view.has(name):
        return name
    if any(name in (c, _local(c)) for c in view.ontology.subclasses(class_)):
        return None
    labelled = [i for i in view.instances("sk:Element") if view.element(i).label == name]
    return labelled[0] if len(labelled) == 1 else None


def _abstract(name: str, class_: str, type_: ConditionType, where: str, view: WorldView) -> str:
    ontology = view.ontology
    subclasses = [c for c in ontology.classes if ontology.is_a(c, class_)]
    by_name = {n: c for c in subclasses for n in (c, _local(c))}
    if name not in by_name:
        known = [*view.instances(class_), *((_local(c) for c in subclasses) if type_.abstract else ())]
        raise UnknownName("element", name, known, where=f"in {where}")
    if not type_.abstract:
        there = ", ".join(view.instances(class_)) or "none"
        raise UsageError(f"{where}: {name} is a class; {type_.name} needs one element of the scene: {there}.")
    return by_name[name]


def _local(curie: str) -> str:
    return curie.partition(":")[2] or curie
