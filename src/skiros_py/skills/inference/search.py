"""Elements for several variables at once, so that all patterns hold: a small constraint search over the index.

The variable with the fewest candidates is bound first; what it is bound to narrows down the others through the index.
What the index cannot say (computed relations, negations, an author's own patterns) only tests what is left.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from skiros_py.skills.conditions import Binding, Computed, Pattern
from skiros_py.skills.inference.narrowing import candidates, is_indexed, that_fit
from skiros_py.skills.references import variables
from skiros_py.world.element import is_abstract
from skiros_py.world.view import WorldView

_Domain = Mapping[str, None] | None
"""Candidates in the order of their ids; None for every element of the class."""


@dataclass(frozen=True, slots=True)
class _Constraint:
    pattern: Pattern
    names: frozenset[str]
    indexed: bool


class Search:
    """One question: which elements of these classes make all these patterns hold.

    Args:
        view: The world.
        classes: Class of each variable that is looked for, by its name.
        patterns: What must hold, over these variables and those that are known.
        known: What is bound from the start.
    """

    def __init__(
        self, view: WorldView, classes: Mapping[str, str], patterns: Iterable[Pattern], known: Binding
    ) -> None:
        self._view = view
        self._classes = classes
        self._known = known
        made = [_Constraint(p, frozenset(variables(p)), is_indexed(p, view.ontology)) for p in patterns]
        self._constraints = sorted(made, key=lambda c: isinstance(c.pattern, Computed))  # the dear ones last
        self._instances: dict[str, tuple[str, ...]] = {}

    def solutions(self) -> Iterator[dict[str, str]]:
        """Yields every way to bind the variables, each once, in an order that is the same in every run."""
        domains: dict[str, _Domain] | None = dict.fromkeys(self._classes)
        for constraint in self._constraints:
            domains = self._narrowed(constraint, self._known, domains) if domains is not None else None
        if domains is not None:
            for binding in self._extensions(self._known, domains):
                yield {name: binding[name] for name in self._classes}

    def _extensions(self, binding: Binding, domains: Mapping[str, _Domain]) -> Iterator[Binding]:
        if not domains:
            yield binding
            return
        name = self._next(domains)
        rest = {other: domain for other, domain in domains.items() if other != name}
        for value in self._values(name, domains[name], binding):
            bound = {**binding, name: value}
            left = self._after(name, bound, rest)
            if left is not None:
                yield from self._extensions(bound, left)

    def _next(self, domains: Mapping[str, _Domain]) -> str:
        """The variable with the fewest candidates; a whole class is only gone through where nothing leads to it."""
        sizes = {name: len(domain) for name, domain in domains.items() if domain is not None}
        sizes = sizes or {name: len(self._all(name)) for name in domains}
        return min(sizes, key=sizes.__getitem__)

    def _all(self, name: str) -> tuple[str, ...]:
        class_ = self._classes[name]
        if class_ not in self._instances:
            self._instances[class_] = self._view.instances(class_)
        return self._instances[class_]

    def _values(self, name: str, domain: _Domain, binding: Binding) -> tuple[str, ...]:
        """The candidates that pass every test that can be made now."""
        values = self._all(name) if domain is None else tuple(domain)
        for constraint in self._constraints:
            if name in constraint.names and not constraint.indexed and constraint.names - {name} <= binding.keys():
                values = that_fit(constraint.pattern, name, values, binding, self._view)
        return values

    def _after(self, name: str, binding: Binding, domains: Mapping[str, _Domain]) -> Mapping[str, _Domain] | None:
        """The candidates of the other variables once one is bound; None where one has none left."""
        left: Mapping[str, _Domain] | None = domains
        for constraint in self._constraints if domains else ():
            if name in constraint.names and left is not None:
                left = self._narrowed(constraint, binding, left)
        return left

    def _narrowed(
        self, constraint: _Constraint, binding: Binding, domains: Mapping[str, _Domain]
    ) -> dict[str, _Domain] | None:
        """Lets one pattern narrow down the one variable that it still leaves open."""
        narrowed = dict(domains)
        free = constraint.names - binding.keys()
        if len(free) == 1:
            (name,) = free
            found = candidates(constraint.pattern, name, binding, self._view)
            if found is not None:
                narrowed[name] = dict.fromkeys(self._of_class(name, found, domains[name]))
                return narrowed if narrowed[name] else None
        return narrowed

    def _of_class(self, name: str, found: Sequence[str], domain: _Domain) -> Iterator[str]:
        if domain is not None:
            yield from (value for value in found if value in domain)
            return
        is_a, class_ = self._view.ontology.is_a, self._classes[name]
        for value in found:
            if not is_abstract(value) and is_a(self._view.element(value).type, class_):
                yield value
