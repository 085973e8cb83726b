"""Goals as text and as plain data: reading, looking up words, and writing such that reading gives the same goal."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from math import prod
from typing import Any

from pydantic import ValidationError

from skiros_py.errors import DescriptionError, UnknownName, UsageError
from skiros_py.messages import Message, listed
from skiros_py.planning.domain.pddl import NameMap
from skiros_py.skills.conditions import Condition, ConditionType, all_of, any_of, exists, for_all
from skiros_py.skills.conditions.compound import Junction, Quantified
from skiros_py.tasks.goals import forms
from skiros_py.tasks.goals.forms import Form
from skiros_py.world.element import is_abstract
from skiros_py.world.names import local_name
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ELEMENT, SPATIAL_THING

DEEPEST = 50
"""Conditions nested deeper than this are refused: the explanations would be unreadable."""

MOST_LOOKED_AT = 2_000
"""Maximum number of condition evaluations per goal, since the control cycle waits for them."""

_OF_A_CLASS = 10
"""How many elements of a class argument ("any of them") are evaluated per unit of work."""

_Scope = Mapping[str, str]
"""Class by variable; empty where it may be anything."""


def goal_of(parsed: Iterable[Form], view: WorldView, conditions: Mapping[str, ConditionType]) -> tuple[Condition, ...]:
    """Returns the conditions that must hold together, each once; what "and" joins becomes several.

    Args:
        parsed: The parsed goals.
        view: The world, for elements and classes.
        conditions: The known condition words.

    Raises:
        UnknownName: A word is unknown; the message gives the nearest that exists.
        UsageError: An argument is of the wrong class, abstract where that is not allowed, or a variable out of place.
    """
    meaning = Meaning(view, conditions)
    goal = tuple(dict.fromkeys(condition for one in parsed for condition in _split(meaning.of(one, {}))))
    number = sum(_work(condition, view) for condition in goal)
    if number > MOST_LOOKED_AT:
        raise UsageError(
            "the goal has to be looked at in {number} places to tell whether it holds, and {most} are allowed: each"
            " element that a quantifier stands for counts, in nested ones each combination of them; choose narrower"
            " classes, or say it in several goals",
            number=number,
            most=MOST_LOOKED_AT,
        )
    return goal


def _split(condition: Condition) -> tuple[Condition, ...]:
    match condition:
        case Junction(word="and", negated=False, parts=parts):
            return parts
    return (condition,)


def _work(condition: Condition, view: WorldView) -> int:
    """Returns how many evaluations it takes to tell whether a condition holds."""
    match condition:
        case Junction(parts=parts):
            return sum(_work(part, view) for part in parts)
        case Quantified(class_=class_, part=part):
            return max(1, len(view.instances(class_))) * _work(part, view)
        case _:
            classes = (name for name in condition.arguments if name in view.ontology.classes)
            return 1 + prod(len(view.instances(class_)) for class_ in classes) // _OF_A_CLASS


class Meaning:
    """Turns parsed goals into conditions: looks their words up, for one goal.

    Args:
        view: The world, for elements and classes.
        conditions: The condition words there are.
    """

    def __init__(self, view: WorldView, conditions: Mapping[str, ConditionType]) -> None:
        self._view = view
        self._conditions = conditions
        self._spelt_classes: dict[str, NameMap] = {}
        self._spelt_elements: dict[str, NameMap] = {}

    def of(self, form: Form, scope: _Scope, depth: int = 0) -> Condition:
        """Returns the condition.

        Args:
            form: The parsed goal.
            scope: Class by variable bound in the enclosing goal.
            depth: Its nesting depth.

        Raises:
            UnknownName: A word is unknown.
            UsageError: It makes no sense.
        """
        if depth > DEEPEST:
            raise UsageError(
                "the goal is nested deeper than {levels} levels: say it in several conditions", levels=DEEPEST
            )
        match form:
            case forms.Word():
                return self._word(form, scope)
            case forms.Negation(part=part):
                return ~self.of(part, scope, depth + 1)
            case forms.Implication(premise=premise, then=then):
                return any_of(~self.of(premise, scope, depth + 1), self.of(then, scope, depth + 1))
            case forms.AllOf(parts=parts) | forms.AnyOf(parts=parts):
                if not parts:
                    raise UsageError("'{word}' joins nothing: give at least one condition", word=form.word)
                conditions = [self.of(part, scope, depth + 1) for part in parts]
                return (all_of if isinstance(form, forms.AllOf) else any_of)(*conditions)
            case forms.ForAll() | forms.Exists():
                return self._quantified(form, scope, depth)

    def _quantified(self, form: forms.ForAll | forms.Exists, scope: _Scope, depth: int) -> Condition:
        name = form.variable
        where = Message("in '{quantifier} {name}'", quantifier=form.quantifier, name=name)
        class_ = self._class_of(form.class_, ELEMENT)
        if class_ is None:
            raise UnknownName(
                "class", form.class_, map(local_name, self._view.ontology.subclasses(ELEMENT)), where=where
            )
        if form.variable in scope:
            raise UsageError(
                "{where}: {name} is bound already around it; call one of the two otherwise", where=where, name=name
            )
        if self._is_taken(form.variable):
            raise UsageError(
                "{where}: something else is called {name}; call the variable otherwise", where=where, name=name
            )
        inner = {**scope, form.variable: class_}
        part = self.of(form.holds, inner, depth + 1)
        make = for_all if isinstance(form, forms.ForAll) else exists
        try:
            return make(form.variable, class_, part)
        except DescriptionError as error:
            raise UsageError("goal: {error}", error=error) from error

    def _word(self, form: forms.Word, scope: _Scope) -> Condition:
        type_ = self._type(form.condition)
        if len(form.arguments) != len(type_.roles):
            roles = ", ".join(f"{role.name}: {local_name(role.class_)}" for role in type_.roles)
            raise UsageError(
                "{condition} takes {count} arguments ({roles}), got {given}",
                condition=type_.name,
                count=len(type_.roles),
                roles=roles,
                given=len(form.arguments),
            )
        return type_(*(self._argument(name, index, type_, scope) for index, name in enumerate(form.arguments)))

    def _argument(self, name: forms.Name, index: int, type_: ConditionType, scope: _Scope) -> str:
        role = type_.roles[index]
        where = Message(
            "{condition}, argument {number} ({role})", condition=type_.name, number=index + 1, role=role.name
        )
        if name.variable is not False and name.text in scope:
            return self._variable(name.text, scope[name.text], role.class_, where)
        if name.variable:
            bound = ", ".join(f"?{variable}" for variable in scope) or Message("none is")
            raise UsageError(
                "{where}: no quantifier around it binds ?{name} (bound: {bound})",
                where=where,
                name=name.text,
                bound=bound,
            )
        element = self._element(name.text, role.class_)
        if element is None:
            return self._class(name.text, index, type_, where, scope)
        self._check_element(element, name.text, type_, role.class_, where)
        return element

    def _variable(self, variable: str, class_: str, wanted: str, where: str) -> str:
        if not class_ or self._view.ontology.is_a(class_, wanted):
            return variable
        raise UsageError(
            "{where}: {name} is any {kind}, not only a {wanted}; say '{name}: {wanted}' where it is bound",
            where=where,
            name=variable,
            kind=local_name(class_),
            wanted=local_name(wanted),
        )

    def _check_element(self, element: str, name: str, type_: ConditionType, wanted: str, where: str) -> None:
        ontology, class_ = self._view.ontology, self._view.element(element).type
        there = _some(self._view, wanted)
        if not ontology.is_a(class_, wanted):
            raise UsageError(
                "{where}: {name} is a {kind}, not a {wanted}. There is {things}.",
                where=where,
                name=name,
                kind=local_name(class_),
                wanted=local_name(wanted),
                things=there,
            )
        if is_abstract(element) and not type_.abstract and ontology.is_a(wanted, SPATIAL_THING):
            raise UsageError(
                "{where}: {name} is abstract; {condition} needs one element of the scene: {things}.",
                where=where,
                name=name,
                condition=type_.name,
                things=there,
            )

    def _class(self, name: str, index: int, type_: ConditionType, where: str, scope: _Scope) -> str:
        wanted = type_.roles[index].class_
        class_ = self._class_of(name, wanted)
        if class_ is None:
            classes = self._view.ontology.subclasses(wanted) if type_.abstract else ()
            abstract = self._view.abstracts(wanted) if type_.abstract else ()
            known = (*scope, *self._view.instances(wanted), *map(local_name, (*classes, *abstract)))
            raise UnknownName("element", name, known, where=Message("in {where}", where=where))
        if not type_.abstract:
            raise UsageError(
                "{where}: {name} is a class; {condition} needs one element of the scene: {things}.",
                where=where,
                name=name,
                condition=type_.name,
                things=_some(self._view, wanted),
            )
        return class_

    # ------------------------------------------------------------------ looking words up

    def _type(self, word: str) -> ConditionType:
        """Returns a condition's word, ignoring case; "lab.Near" also by its last part, if no other word ends so.

        Raises:
            UnknownName: There is none.
        """
        if word.casefold() not in self._words:
            raise UnknownName("condition", word, self._conditions, where=Message("in the goal"))
        return self._words[word.casefold()]

    @cached_property
    def _words(self) -> dict[str, ConditionType]:
        spelt = NameMap(sorted(self._conditions))
        own = {name.casefold(): type_ for name, type_ in self._conditions.items()}
        bare = [name.rpartition(".")[2] for name in own]
        only = {last: type_ for last, type_ in zip(bare, own.values(), strict=True) if bare.count(last) == 1}
        return only | {spelt.pddl(name): type_ for name, type_ in self._conditions.items()} | own

    def _class_of(self, name: str, above: str) -> str | None:
        """Returns the CURIE of a class, or None if no class at or below another one has that name.

        Raises:
            UsageError: Classes of several ontologies have that name.
        """
        below = self._view.ontology.subclasses(above)
        if name in below:
            return name
        named = [curie for curie in below if local_name(curie) == name]
        if len(named) > 1:
            raise UsageError(
                "{name} may be {names}: write the one that is meant", name=name, names=listed(named, either=True)
            )
        if above not in self._spelt_classes:
            self._spelt_classes[above] = NameMap(below)
        return named[0] if named else _back(self._spelt_classes[above], name)

    def _is_taken(self, variable: str) -> bool:
        """Returns whether an element or a class has this very name: the variable would be mistaken for it."""
        return self._view.has(variable) or variable in map(local_name, self._view.ontology.subclasses(ELEMENT))

    def _element(self, name: str, class_: str) -> str | None:
        """Returns the id of the element with that name, or None.

        An id comes first, then a class, for which None is returned (a part without a label of its own is called like
        its class), then a label that no other element has, one of the scene before an abstract one, then the id of an
        element of the wanted class in PDDL's spelling.

        Raises:
            UsageError: Classes of several ontologies are called so.
        """
        if self._view.has(name):
            return name
        if self._class_of(name, class_) is not None:
            return None
        labelled = next((found for labels in self._labels if (found := labels.get(name))), [])
        if len(labelled) == 1:
            return labelled[0]
        if class_ not in self._spelt_elements:
            self._spelt_elements[class_] = NameMap((*self._view.instances(class_), *self._view.abstracts(class_)))
        return _back(self._spelt_elements[class_], name)

    @cached_property
    def _labels(self) -> Sequence[Mapping[str, Sequence[str]]]:
        """Elements by label: those of the scene, then abstract ones."""
        found: tuple[defaultdict[str, list[str]], ...] = defaultdict(list), defaultdict(list)
        for labels, elements in zip(found, (self._view.instances(ELEMENT), self._view.abstracts(ELEMENT)), strict=True):
            for element in elements:
                labels[self._view.element(element).label].append(element)
        return found


def _some(view: WorldView, class_: str) -> str:
    """Names elements of a class; if there are very many, only the first."""
    there = view.instances(class_)
    return (", ".join(there[:_SHOWN]) + (", …" if len(there) > _SHOWN else "")) or Message("none")


_SHOWN = 20


def _back(spelt: NameMap, name: str) -> str | None:
    return spelt.back(name) if spelt.gives(name.lower()) else None


def parse_goal(texts: Sequence[str], view: WorldView, conditions: Mapping[str, ConditionType]) -> tuple[Condition, ...]:
    """Reads goals such as ``"InKit(Starter, kit_1) and not EmptyHanded(gripper_1)"``, or such in PDDL.

    Args:
        texts: One or more goals; all must hold together.
        view: The world, for elements and classes; an element may be given by id or by its label.
        conditions: The known condition words.

    Returns:
        Conditions that must hold together, each once; what "and" joins becomes several.

    Raises:
        GoalSyntaxError: A text does not follow the grammar.
        UnknownName: A word is unknown; the message gives the nearest that exists.
        UsageError: An argument is of the wrong class, abstract where that is not allowed, or a variable out of place.
    """
    return goal_of(map(forms.read, texts), view, conditions)


def goal_as_text(goal: Sequence[Condition]) -> str:
    """Writes a goal as text that :func:`parse_goal` reads back as the same goal in a world with the same elements."""
    return all_of(*goal).written(forms.quoted) if goal else ""


def goal_from_data(data: object, view: WorldView, conditions: Mapping[str, ConditionType]) -> tuple[Condition, ...]:
    """Creates a goal from plain data.

    Args:
        data: One condition, or a list of them that must hold together; see :mod:`skiros_py.tasks.goals.forms`.
        view: The world, for elements and classes; an element may be given by id or by its label.
        conditions: The known condition words.

    Returns:
        Conditions that must hold together, each once; what "all_of" joins becomes several.

    Raises:
        UnknownName: A word is unknown; the message gives the nearest that exists.
        UsageError: A field is wrong, and the message gives its path; or the goal makes no sense.
    """
    several = isinstance(data, list | tuple)
    try:
        parsed = forms.FORMS.validate_python(data if several else [data])
    except ValidationError as error:
        problems = [(one["loc"] if several else one["loc"][1:], one["msg"]) for one in error.errors()]
        lines = (f"goal{forms.field_path(loc)}: {message[:1].lower()}{message[1:]}" for loc, message in problems)
        raise UsageError("\n".join(lines)) from None
    return goal_of(parsed, view, conditions)


def goal_as_data(goal: Sequence[Condition]) -> list[dict[str, Any]]:
    """Returns a goal as plain data that :func:`goal_from_data` turns back into the same goal."""
    return [_data(condition) for condition in goal]


def _data(condition: Condition) -> dict[str, Any]:
    if condition.negated:
        return {"not": _data(~condition)}
    match condition:
        case Junction(word=word, parts=parts):
            return {"all_of" if word == "and" else "any_of": [_data(part) for part in parts]}
        case Quantified(quantifier=quantifier, variable=variable, class_=class_, part=part):
            return {quantifier.replace(" ", "_"): variable, "class": class_, "holds": _data(part)}
        case _:
            return {"condition": condition.type.name, "arguments": list(condition.arguments)}
