"""Elements for several variables at once, so that all patterns hold, and the choice between several solutions.

The variable with the fewest candidates is bound first; what it is bound to narrows down the others through the index.
What the index cannot say (computed relations, negations, an author's own patterns) only tests what is left.

Where several parameters have a preference, the one described first counts first; so it is with costs and ids. Ids are
in the order of the world's own answers, that of their characters: ``ball_10`` comes before ``ball_2``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from skiros_py.errors import DescriptionError, SkirosError
from skiros_py.messages import Message, joined
from skiros_py.skills.conditions import AllOf, AnyOf, Binding, Computed, Exists, Not, Nothing, Pattern, Related
from skiros_py.skills.parameters import IT, Param
from skiros_py.skills.references import variables
from skiros_py.world.element import is_abstract
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView


def conjuncts(pattern: Pattern) -> tuple[Pattern, ...]:
    """Returns the patterns that must all hold for this one to hold."""
    if isinstance(pattern, AllOf):
        return tuple(part for inner in pattern.patterns for part in conjuncts(inner))
    return (pattern,)


def is_indexed(pattern: Pattern, ontology: Ontology) -> bool:
    """Tells whether :func:`candidates` gives exactly what fits, as soon as one end of the pattern is bound."""
    if not isinstance(pattern, Related) or pattern.subject == pattern.object:
        return False
    return ontology.family(pattern.relation) is not Family.COMPUTED


def candidates(pattern: Pattern, name: str, binding: Binding, view: WorldView) -> tuple[str, ...] | None:
    """Returns all elements for which a pattern may hold, sorted; None where no index can say.

    Args:
        pattern: The pattern.
        name: The variable that is looked for.
        binding: The others, as far as they are bound.
        view: The world.
    """
    match pattern:
        case Related(relation, subject, object_) if is_indexed(pattern, view.ontology):
            if subject == name and object_ in binding:
                return view.subjects(relation, binding[object_])
            return view.objects(binding[subject], relation) if object_ == name and subject in binding else None
        case AllOf(patterns):
            found = [c for p in patterns if (c := candidates(p, name, binding, view)) is not None]
            return tuple(sorted(set(found[0]).intersection(*found[1:]))) if found else None
        case AnyOf(patterns):
            return _united(candidates(p, name, binding, view) for p in patterns)
        case Exists():
            return _through(pattern, name, binding, view)
        case _:
            return None


def that_fit(pattern: Pattern, name: str, values: Sequence[str], binding: Binding, view: WorldView) -> tuple[str, ...]:
    """Returns those values of a variable for which a pattern holds, in their order; all its others are bound."""
    match pattern:
        case Nothing(relation, _):
            return tuple(value for value in values if not view.subjects(relation, value))
        case Computed():
            held = _computed(pattern, name, values, binding, view)
            return tuple(value for value in values if value in held)
        case Not(inner):
            held = frozenset(that_fit(inner, name, values, binding, view))
            return tuple(value for value in values if value not in held)
        case _:
            return tuple(value for value in values if pattern.evaluate(view, {**binding, name: value}))


def _united(parts: Iterable[tuple[str, ...] | None]) -> tuple[str, ...] | None:
    found: set[str] = set()
    for part in parts:
        if part is None:
            return None
        found.update(part)
    return tuple(sorted(found))


def _through(pattern: Exists, name: str, binding: Binding, view: WorldView) -> tuple[str, ...] | None:
    """What can be reached by way of the element that must exist: the robot of a deck on which the kit stands."""
    outside = {key: value for key, value in binding.items() if key != pattern.variable}
    between = candidates(pattern.pattern, pattern.variable, outside, view)
    if between is None or name == pattern.variable:
        return None
    fitting = (e for e in between if view.ontology.is_a(view.element(e).type, pattern.class_))
    return _united(candidates(pattern.pattern, name, {**outside, pattern.variable: e}, view) for e in fitting)


def _computed(pattern: Computed, name: str, values: Sequence[str], binding: Binding, view: WorldView) -> frozenset[str]:
    """Asks for all values together, but for the other end itself: reasoners leave that out of many."""
    ends = {pattern.subject, pattern.object} - {name}
    other = binding[ends.pop()] if ends else None
    alone = values if other is None else [value for value in values if value == other]
    held = {value for value in alone if pattern.evaluate(view, {**binding, name: value})}
    if other is None:
        return frozenset(held)
    apart = tuple(value for value in values if value != other)
    if pattern.subject == name:
        return frozenset(held.union(subject for subject, _ in pattern.pairs(view, apart, (other,))))
    return frozenset(held.union(object_ for _, object_ in pattern.pairs(view, (other,), apart)))


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
        about_known = (c.pattern for c in self._constraints if c.names <= self._known.keys())
        if not all(pattern.evaluate(self._view, self._known) for pattern in about_known):
            return
        domains = self._narrowed(self._constraints, self._known, dict.fromkeys(self._classes))
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
            left = self._narrowed([c for c in self._constraints if name in c.names], bound, rest)
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

    def _narrowed(
        self, constraints: Iterable[_Constraint], binding: Binding, domains: Mapping[str, _Domain]
    ) -> dict[str, _Domain] | None:
        """Lets patterns narrow down the one variable that each still leaves open; None where one has none left."""
        narrowed = dict(domains)
        for constraint in constraints:
            free = constraint.names - binding.keys()
            if len(free) == 1:
                (name,) = free
                found = candidates(constraint.pattern, name, binding, self._view)
                if found is not None:
                    narrowed[name] = dict.fromkeys(self._of_class(name, found, narrowed[name]))
                    if not narrowed[name]:
                        return None
        return narrowed

    def _of_class(self, name: str, found: Sequence[str], domain: _Domain) -> Iterator[str]:
        if domain is not None:
            yield from (value for value in found if value in domain)
            return
        is_a, class_ = self._view.ontology.is_a, self._classes[name]
        for value in found:
            if not is_abstract(value) and is_a(self._view.element(value).type, class_):
                yield value


Solution = Mapping[str, str]
"""Element by key, of the parameters that are chosen together."""


def choose(
    params: Sequence[Param], solutions: Sequence[Solution], known: Binding, view: WorldView
) -> tuple[Solution, dict[str, str]]:
    """Returns the best solution, and for each parameter why it is that one.

    Args:
        params: The parameters that are chosen together, in the order in which they are described.
        solutions: At least one.
        known: What is bound already.
        view: The world.

    Raises:
        DescriptionError: An author's cost function broke.
    """
    why: dict[str, list[str]] = {param.key: [] for param in params}
    best = solutions
    for narrow in (partial(_most_preferred, known), _cheapest):
        for param in params:
            kept, reason = narrow(param, best, view)
            if len(kept) < len(best):
                why[param.key].append(reason)
            best = kept
    chosen = min(best, key=lambda solution: tuple(solution[param.key] for param in params))
    return chosen, {param.key: _reason(param, solutions, best, why[param.key]) for param in params}


def _reason(param: Param, solutions: Sequence[Solution], best: Sequence[Solution], why: Sequence[str]) -> str:
    fitting = len({solution[param.key] for solution in solutions})
    if fitting == 1:
        return Message("the only one that fits")
    several = len({solution[param.key] for solution in best}) > 1
    how = [*why, Message("the first by id")] if several else why or [Message("the one that goes with the rest")]
    return Message("of {count} that fit, {why}", count=fitting, why=joined(", ", how))


def _most_preferred(
    known: Binding, param: Param, solutions: Sequence[Solution], view: WorldView
) -> tuple[Sequence[Solution], str]:
    for pattern in param.preferred:
        own = pattern.rename({IT: param.key})
        kept = _fulfilling(own, param.key, solutions, known, view)
        if kept:
            return kept, Message("preferred: {why}", why=own.evaluate(view, {**known, **kept[0]}).text)
    return solutions, ""


def _fulfilling(
    pattern: Pattern, key: str, solutions: Sequence[Solution], known: Binding, view: WorldView
) -> list[Solution]:
    """Those solutions for which a pattern holds; asked for many candidates together where the rest is the same."""
    others = [name for name in variables(pattern) if name != key]
    if any(name not in known and name not in solutions[0] for name in others):
        return []  # it speaks of an optional parameter that is left open
    groups: dict[tuple[str, ...], list[Solution]] = {}
    for solution in solutions:
        groups.setdefault(tuple(solution[n] for n in others if n in solution), []).append(solution)
    held: set[int] = set()
    for group in groups.values():
        values = tuple(dict.fromkeys(solution[key] for solution in group))
        fits = frozenset(that_fit(pattern, key, values, {**known, **group[0]}, view))
        held.update(id(solution) for solution in group if solution[key] in fits)
    return [solution for solution in solutions if id(solution) in held]


def _cheapest(param: Param, solutions: Sequence[Solution], view: WorldView) -> tuple[Sequence[Solution], str]:
    cost = param.cost
    if cost is None:
        return solutions, ""
    costs = {value: _cost(param, value, view) for value in dict.fromkeys(s[param.key] for s in solutions)}
    least = min(costs.values())
    what = local_name(cost) if isinstance(cost, str) else Message("cost")
    why = Message("the one of least {property} ({value:g})", property=what, value=least)
    return [s for s in solutions if costs[s[param.key]] == least], why


def _cost(param: Param, element: str, view: WorldView) -> float:
    """What a candidate costs; what has no number for it comes last."""
    if isinstance(param.cost, str):
        value: object = view.value(element, param.cost)
    else:
        assert param.cost is not None
        try:
            value = param.cost(view, element)
        except SkirosError:
            raise
        except Exception as error:
            what = f"the cost of {element} as parameter {param.key}"
            raise DescriptionError(f"{what} could not be worked out: {type(error).__name__}: {error}") from error
    if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
        return math.inf
    return float(value)
