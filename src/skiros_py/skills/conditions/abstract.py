"""What an abstract argument of a condition stands for: some element of a class, or some that fits a description."""

from __future__ import annotations

from skiros_py.skills.conditions.compare import Compare
from skiros_py.skills.conditions.pattern import AllOf, Exists, Pattern
from skiros_py.world.abstract import abstract_individuals
from skiros_py.world.element import Element, is_abstract
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import NO_REASONERS


def some_such(name: str, pattern: Pattern, ontology: Ontology, *, described: bool) -> Pattern:
    """Returns "there is something such that ...", where an argument is a class or an individual of the ontology.

    An individual describes things: whatever is of its class and has its own texts, numbers and truth values. Poses and
    sizes are no description of others.

    Args:
        name: The argument; any but an abstract one stands for itself.
        pattern: What is said of it.
        ontology: Tells what is abstract.
        described: Whether an individual describes things; else it is meant itself (a material, a maker).
    """
    if name in ontology.classes:
        return Exists(name, name, pattern)
    if not described or not is_abstract(name) or name not in ontology.individuals:
        return pattern
    element = abstract_individuals(ontology, NO_REASONERS).element(name)
    return Exists(name, element.type, AllOf((*_described(element), pattern)))


def _described(element: Element) -> tuple[Pattern, ...]:
    values = sorted(element.properties.items())
    return tuple(
        Compare(name, "=", element.id, value) for name, value in values if isinstance(value, str | int | float)
    )
