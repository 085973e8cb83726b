"""Finding elements by their features."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import TypeAlias

from skiros_py.errors import UnknownName, UsageError
from skiros_py.world.branches import BACKWARDS
from skiros_py.world.element import Value, is_abstract
from skiros_py.world.literals import DATATYPES, shown
from skiros_py.world.reasoners.registry import computed_others
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
    stated: list[tuple[str, ...]] = []
    computed: list[tuple[str, str, bool]] = []
    for relation, other in relations.items():
        view.element(other)
        name, backwards = relation.removeprefix(BACKWARDS), relation.startswith(BACKWARDS)
        if view.ontology.family(name) is Family.COMPUTED:
            computed.append((other, name, not backwards))
        else:
            stated.append(view.objects(other, name) if backwards else view.subjects(name, other))
    tests = [_is_of(view, class_, abstract=abstract)] if stated else []  # otherwise only these are iterated
    if label is not None:
        tests.append(lambda name: view.element(name).label == label)
    found: Iterable[str] = (
        set(stated[0]).intersection(*stated) if stated else _of_class(view, class_, abstract=abstract)
    )
    for test in (*tests, *(_value_test(view, name, wanted) for name, wanted in properties.items())):
        found = filter(test, found)
    for other, name, to_it in computed:  # only for the candidates that are left
        found = computed_others(view, other, name, backwards=to_it, among=tuple(sorted(found)))
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
        there_are = _of_class(view, class_, abstract=abstract)
        raise UsageError(f"there is no {class_}{called}{like}. {_listed('Of that class', there_are)}")
    raise UsageError(f"{len(found)} elements are a {class_}{called}{like}: say which. {_listed('There are', found)}")


def _of_class(view: WorldView, class_: str, *, abstract: bool) -> tuple[str, ...]:
    return view.abstracts(class_) if abstract else view.instances(class_)


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
