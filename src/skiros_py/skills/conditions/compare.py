"""A property's value compared with a constant: charged enough, scanned, a door that is open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from skiros_py.skills.conditions.comparison import Comparison, Constant, Operator
from skiros_py.skills.conditions.pattern import Binding
from skiros_py.skills.conditions.verdict import Verdict
from skiros_py.world.element import Value
from skiros_py.world.names import local_name
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class Compare:
    """A property of an element (or of its class) compares as wanted with a constant.

    Of an element without a value none of the comparisons holds, "!=" neither; ask that by ``Not(Has(...))``.

    Attributes:
        property: CURIE of the property.
        op: ``=``, ``!=``, and for numbers ``<``, ``<=``, ``>``, ``>=``.
        subject: Variable.
        value: A number, a text (also the name of a class or of a state), or true or false.

    Raises:
        DescriptionError: There is no such comparison, or not of such a value.
    """

    property: str
    op: Operator
    subject: str
    value: Constant

    def __post_init__(self) -> None:
        Comparison(self.op, self.value)

    def allows(self, value: Value | None) -> bool:
        """Tells whether it would hold of an element with this value, or with none."""
        return Comparison(self.op, self.value).allows(value)

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Compares."""
        subject = binding[self.subject]
        name = local_name(self.property)
        value = view.value(subject, self.property)
        return Comparison(self.op, self.value).judge(f"the {name} of {subject}", value, f"{subject} has no {name}")

    def rename(self, names: Mapping[str, str]) -> Compare:
        """Returns the same pattern with other variable names."""
        return Compare(self.property, self.op, names.get(self.subject, self.subject), self.value)
