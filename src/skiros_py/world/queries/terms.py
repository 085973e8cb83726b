"""Python values as RDF terms and back."""

from __future__ import annotations

from decimal import Decimal

import pyoxigraph as ox

from skiros_py.errors import UsageError
from skiros_py.world.element import Value
from skiros_py.world.literals import ANY_LITERAL, any_value, format_value, literal_type
from skiros_py.world.names import Names

__all__ = ["Binding", "Text", "bound_term", "literal", "value_of"]


class Text(str):
    """Marks a bound text as a literal; any other string that is bound is a name."""

    __slots__ = ()


Binding = Value | Decimal
"""What a parameter may stand for. A pattern is met by a number of the same type only: of an ``xsd:decimal`` property, a
Decimal. ``FILTER`` compares numbers of all types."""


def bound_term(names: Names, value: Binding) -> ox.NamedNode | ox.Literal:
    """Returns what a parameter stands for.

    Args:
        names: The prefix table.
        value: A string is a scene id or CURIE, :class:`Text` a text, anything else a value.

    Raises:
        UsageError: It is no name, or no value.
    """
    if isinstance(value, str) and not isinstance(value, Text):
        try:
            return ox.NamedNode(names.iri(value))
        except ValueError as error:
            raise UsageError(f"'{value[:100]}' is no name: {error}") from None
    if isinstance(value, Decimal) and value.is_finite():
        return ox.Literal(f"{value:f}", datatype=ox.NamedNode(names.iri("xsd:decimal")))
    try:
        return literal(names, value)  # type: ignore[arg-type]  # what is no value raises
    except ValueError:
        raise UsageError(
            f"{value!r} is no value: bind a name, Text, bool, int, float, Decimal, Pose or vector"
        ) from None


def literal(names: Names, value: Value) -> ox.Literal:
    """Returns a value as a literal of the type that is Python's.

    Raises:
        ValueError: It is none that a property may have.
    """
    if isinstance(value, str):
        return ox.Literal(str(value))
    datatype = ox.NamedNode(names.iri(literal_type(value, ANY_LITERAL)))
    return ox.Literal(format_value(value, ANY_LITERAL), datatype=datatype)


def value_of(names: Names, term: object) -> Value | None:
    """Returns a scene id or CURIE for a name, a Python value for a literal, None for no term."""
    if isinstance(term, ox.NamedNode):
        return names.name(term.value)
    if not isinstance(term, ox.Literal):
        return None if term is None else str(term)
    return any_value(term.value, names.name(term.datatype.value))
