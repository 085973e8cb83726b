"""Finding elements by their features."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import TypeAlias

from skiros_py.errors import UnknownName, UsageError
from skiros_py.world.branches import BACKWARDS
from skiros_py.world.element import Value, is_abstract
from skiros_py.world.literals import DATATYPES, shown
from skiros_py.world.reasoners.registry import computed_objects, computed_subjects
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ELEMENT

Wanted: TypeAlias = Value | Callable[[Value], bool] | None
"""Requirement on a property: this value, one accepted by a function, or (None) no value at all."""

_NOTHING: Mapping[str, str] = MappingProxyType({})
_Test = Callable[[str], bool]


def resolve(
    view: WorldView,
    class_: str = ELEMENT,
    *,
    label: str | None = None,
    properties: Mapping[str, Wanted] = _NOTHING,
    relations: Mapping[str, str] = _NOTHING,
    abstract: bool = False,
) -> tuple[str, ...]:
    """Returns the ids of all elements that are as described, sorted.

    >>> resolve(world, "kitting:Part", properties={"sk:mass": lambda kg: kg < 0.5}, relations={"sk:in": "pallet_a"})
    ('relay_box_1',)

    Args:
        view: The world.
        class_: CURIE of the class; subclasses count.
        label: The exact label.
        properties: Requirements on properties, own or of the class, by CURIE.
        relations: Ids of what it is related to, by CURIE of the relation; narrower relations count, computed ones are
            asked last. ``^`` before the CURIE: of what is related to it (``{"^sk:hasA": "kit_1"}``: pieces of the kit).
        abstract: True to find, instead of what the scene has, what the ontology describes and what was learned.

    Raises:
        UnknownName: There is no such class, property, relation or element.
        UsageError: A property can never have such a value.
    """
    stated, computed = _by_family(view, relations)
    tests = [_is_of(view, class_, abstract=abstract)] if stated else []  # otherwise only these are iterated
    if label is not None:
        tests.append(lambda name: view.element(name).label == label)
    found: Iterable[str] = _smallest(view, class_, stated, abstract=abstract)
    for test in (*tests, *(_value_test(view, name, wanted) for name, wanted in properties.items())):
        found = filter(test, found)
    for relation, other in computed:
        found = _computed(view, relation, other, tuple(sorted(found)))
    return tuple(sorted(found))


def the(
    view: WorldView,
    class_: str = ELEMENT,
    *,
    label: str | None = None,
    properties: Mapping[str, Wanted] = _NOTHING,
    relations: Mapping[str, str] = _NOTHING,
    abstract: bool = False,
) -> str:
    """Returns the id of the one element that is as described; see :func:`resolve`.

    Raises:
        UnknownName: There is no such class, property, relation or element.
        UsageError: A property can never have such a value, or there is no such element or more than one.
    """
    found = resolve(view, class_, label=label, properties=properties, relations=relations, abstract=abstract)
    if len(found) == 1:
        return found[0]
    called = f" called {shown(label)}" if label is not None else ""
    like = "".join(f", {name} {_asked(wanted)}" for name, wanted in (*properties.items(), *relations.items()))
    if not found:
        there_are = view.abstracts(class_) if abstract else view.instances(class_)
        raise UsageError(f"there is no {class_}{called}{like}. {_listed('Of that class', there_are)}")
    raise UsageError(f"{len(found)} elements are a {class_}{called}{like}: say which. {_listed('There are', found)}")


def _smallest(view: WorldView, class_: str, stated: list[tuple[str, str]], *, abstract: bool) -> tuple[str, ...]:
    """The elements that satisfy all stated relations, starting from the smallest set; without any, the whole class."""
    sets = sorted((_related(view, relation, other) for relation, other in stated), key=len)
    if not sets:
        return view.abstracts(class_) if abstract else view.instances(class_)
    return tuple(set(sets[0]).intersection(*sets[1:]))


def _by_family(view: WorldView, relations: Mapping[str, str]) -> tuple[list[tuple[str, str]], list[tuple[str, str]]]:
    computed: list[tuple[str, str]] = []
    stated: list[tuple[str, str]] = []
    for relation, other in relations.items():
        view.element(other)
        family = view.ontology.family(relation.removeprefix(BACKWARDS))
        (computed if family is Family.COMPUTED else stated).append((relation, other))
    return stated, computed


def _related(view: WorldView, relation: str, other: str) -> tuple[str, ...]:
    name = relation.removeprefix(BACKWARDS)
    return view.subjects(name, other) if name == relation else view.objects(other, name)


def _computed(view: WorldView, relation: str, other: str, candidates: tuple[str, ...]) -> tuple[str, ...]:
    """The candidates that a reasoner finds related; nothing else is computed."""
    name = relation.removeprefix(BACKWARDS)
    if name != relation:
        return computed_objects(view, other, name, candidates)
    return computed_subjects(view, name, other, candidates)


def _is_of(view: WorldView, class_: str, *, abstract: bool) -> _Test:
    classes = frozenset(view.ontology.subclasses(class_))
    return lambda name: is_abstract(name) is abstract and view.element(name).type in classes


def _value_test(view: WorldView, property_: str, wanted: Wanted) -> _Test:
    declared = view.ontology.properties.get(property_)
    if declared is None:
        raise UnknownName("property", property_, view.ontology.properties)
    if wanted is None:
        return lambda name: view.value(name, property_) is None
    if callable(wanted):
        return lambda name: (value := view.value(name, property_)) is not None and wanted(value)
    try:
        checked = DATATYPES[declared.range].check(wanted)
    except ValueError:
        says = DATATYPES[declared.range].says
        raise UsageError(f"{property_} is always {says}, never {shown(wanted)}") from None
    return lambda name: view.value(name, property_) == checked


def _asked(wanted: Wanted) -> str:
    if wanted is None:
        return "not set"
    return "as asked" if callable(wanted) else shown(wanted)


def _listed(what: str, names: tuple[str, ...]) -> str:
    if not names:
        return f"{what}: none."
    return f"{what}: {', '.join(names[:20])}{', …' if len(names) > 20 else ''}."
