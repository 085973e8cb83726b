"""Patterns over the world: the one thing a condition is made of; and verdicts, which say why.

Everything is derived from the pattern: checking it with reasons (:meth:`Pattern.evaluate`), simulating it
(:mod:`skiros_py.planning.plan_validation`), and writing it as PDDL (:mod:`skiros_py.planning.domain.literals`).
Variables are names; a binding gives each the id of an element.
"""

from __future__ import annotations

import builtins
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType
from typing import ClassVar, Protocol, Self

from skiros_py.errors import DescriptionError
from skiros_py.messages import Message, joined
from skiros_py.world.names import local_name
from skiros_py.world.terms import Filler
from skiros_py.world.view import WorldView

_SHOWN = 5
"""So many reasons are said in one sentence."""
ALL_OF_THESE, ANY_OF_THESE = Message("all of these"), Message("any of these")
"""Texts of verdicts on several parts."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether something holds, and why.

    Attributes:
        holds: The answer.
        text: What was asked, with the answer in words ("starter_1 is not in pallet_a").
        parts: The verdicts this one was made from.
        vague: True when it only says that nothing was found; of several reasons the others say more.
    """

    holds: bool
    text: str
    parts: tuple[Verdict, ...] = ()
    vague: bool = False

    def __bool__(self) -> bool:
        return self.holds

    def lines(self, indent: int = 0) -> list[str]:
        """Returns the tree as indented lines, the decisive parts only: where it fails, why it fails."""
        text = self.text
        if self.parts:
            text = Message("{text} (holds)", text=text) if self.holds else Message("{text} (does not hold)", text=text)
        return [joined("", ("  " * indent, text)), *(line for part in self.decisive for line in part.lines(indent + 1))]

    @property
    def why(self) -> str:
        """What decides it, in one line for people: "ball_1 is not in box_b: it is in box_a"."""
        return self.sentence if all(end.vague for end in _ends(self)) else self._reasons

    @property
    def sentence(self) -> str:
        """What was asked, and what decides it: "In(ball_1, box_b): ball_1 is not in box_b: it is in box_a"."""
        return joined(": ", (self.text, self._reasons)) if self.parts else self.text

    @property
    def _reasons(self) -> str:
        """The ends of the tree of reasons, each once."""
        ends = tuple(_ends(self))
        said = list(dict.fromkeys(end.text for end in ends if not end.vague) or dict.fromkeys(end.text for end in ends))
        rest = [Message("and {count} more", count=len(said) - _SHOWN)] if len(said) > _SHOWN else []
        return joined("; ", (*said[:_SHOWN], *rest))

    @property
    def decisive(self) -> tuple[Verdict, ...]:
        """The parts that decide it: where it fails, those that fail."""
        return tuple(part for part in self.parts if part.holds == self.holds) or self.parts


def _ends(verdict: Verdict) -> Iterator[Verdict]:
    if not verdict.parts:
        yield verdict
    for part in verdict.decisive:
        yield from _ends(part)


Binding = Mapping[str, str]
"""Element id by variable."""


class Pattern(Protocol):
    """Something about the world that holds or not."""

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Tells whether it holds, and why. Every free variable must be bound."""

    def rename(self, names: Mapping[str, str]) -> Pattern:
        """Returns the same pattern with other variable names."""


@dataclass(frozen=True, slots=True)
class Atom:
    """Base of patterns without parts; its variables are the fields ``subject`` and ``object``."""

    def rename(self, names: Mapping[str, str]) -> Self:
        """Returns the same pattern with other variable names."""
        variables = {field: getattr(self, field) for field in ("subject", "object") if hasattr(self, field)}
        return replace(self, **{field: names.get(name, name) for field, name in variables.items()})


@dataclass(frozen=True, slots=True)
class Related(Atom):
    """A stored relation holds between two elements (sub-relations count)."""

    relation: str
    subject: str
    object: str

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Looks it up."""
        subject, object_ = binding[self.subject], binding[self.object]
        holds = view.related(subject, self.relation, object_)
        return Verdict(holds, _says(view, self.relation, subject, object_, holds))


def _says(view: WorldView, relation: str, subject: str, object_: str, holds: bool) -> str:
    said = {"subject": subject, "relation": local_name(relation), "object": object_}
    if holds:
        return Message("{subject} {relation} {object}", **said)
    place = view.placement(subject) if view.ontology.is_placement(relation) else None
    if place is None:
        return Message("{subject} is not {relation} {object}", **said)
    now = {"there": local_name(place.relation), "place": place.place}
    return Message("{subject} is not {relation} {object}: it is {there} {place}", **said, **now)


@dataclass(frozen=True, slots=True)
class Nothing(Atom):
    """No element at all has the relation to this one (an empty gripper, an empty compartment)."""

    relation: str
    object: str

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Looks for one that has."""
        object_ = binding[self.object]
        there = view.subjects(self.relation, object_)
        said = {"relation": local_name(self.relation), "object": object_}
        if not there:
            return Verdict(True, Message("nothing {relation} {object}", **said))
        return Verdict(False, Message("{things} {relation} {object}", things=", ".join(there), **said))


@dataclass(frozen=True, slots=True)
class Has(Atom):
    """An element (or its class) has a value for a property."""

    property: str
    subject: str

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Looks it up."""
        subject = binding[self.subject]
        holds = view.value(subject, self.property) is not None
        said = {"thing": subject, "property": local_name(self.property)}
        return Verdict(
            holds,
            Message("{thing} has a {property}", **said) if holds else Message("{thing} has no {property}", **said),
        )


@dataclass(frozen=True, slots=True)
class NumberChange(Atom):
    """Base of :class:`Increase` and :class:`Decrease`: how a skill changes a number, as far as it is known before.

    It is an effect, no state: it stands in postconditions, and can be asked for neither by a precondition nor by a
    goal. Where the number is missing, or the amount, nothing can be changed, and the postcondition does not hold.

    Attributes:
        property: CURIE of the property.
        subject: Variable.
        by: By how much; or the CURIE of the property of :attr:`object` that says so.
        object: Variable; the subject itself if left out.

    Raises:
        DescriptionError: The amount is neither a property nor a number above zero.
    """

    sign: ClassVar[int]

    property: str
    subject: str
    by: float | str
    object: str = ""

    def __post_init__(self) -> None:
        number = isinstance(self.by, int | float) and not isinstance(self.by, bool)
        if not isinstance(self.by, str) and not (number and 0.0 < self.by < math.inf):
            word = type(self).__name__.lower()
            raise DescriptionError(f"{word} {self.property} by {self.by!r}: give a number above 0, or a property")
        object.__setattr__(self, "object", self.object or self.subject)  # the class is frozen

    def after(self, view: WorldView, subject: str, object_: str) -> float | None:
        """Returns the number of an element after the change; None where it has none, or there is no amount.

        It is rounded to nine decimals: ten times 0.1 are 1.
        """
        before = number_of(view, subject, self.property)
        by = number_of(view, object_, self.by) if isinstance(self.by, str) else self.by
        if before is None or by is None:
            return None
        after = round(before + self.sign * by, 9)
        return int(after) if isinstance(before, int) and after == int(after) else after

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Looks for the number: that it was changed cannot be seen from one state of the world."""
        asked = [(binding[variable], name) for variable, name in self.counted]
        missing = next(((e, name) for e, name in asked if number_of(view, e, name) is None), None)
        element, name = missing or asked[0]
        said = {"thing": element, "property": local_name(name)}
        if missing:
            return Verdict(False, Message("{thing} has no number for its {property}", **said))
        return Verdict(True, Message("{thing} has a number for its {property}", **said))

    @builtins.property  # the class has a field of that name
    def counted(self) -> tuple[tuple[str, str], ...]:
        """The variables, each with the property that must be there before."""
        return ((self.subject, self.property), *(((self.object, self.by),) if isinstance(self.by, str) else ()))


@dataclass(frozen=True, slots=True)
class Increase(NumberChange):
    """A number of an element grows: the charge of a battery by 30."""

    sign: ClassVar[int] = 1


@dataclass(frozen=True, slots=True)
class Decrease(NumberChange):
    """A number of an element falls: the charge of a battery by 25."""

    sign: ClassVar[int] = -1


def number_of(view: WorldView, element: str, property_: str) -> int | float | None:
    """Returns the number that an element has for a property (its own, taught, or of its class), or None."""
    value = view.value(element, property_)
    return value if isinstance(value, int | float) and not isinstance(value, bool) else None


@dataclass(frozen=True, slots=True)
class Computed(Atom):
    """A relation that is worked out from what the two elements are (sizes, poses); no skill can change it.

    Attributes:
        relation: CURIE of the computed relation.
        subject, object: Variables.
        function: Works it out: ``function(view, subject id, object id)`` gives a verdict; left out, the reasoner of
            the view that computes the relation does.
    """

    relation: str
    subject: str
    object: str
    function: Callable[[WorldView, str, str], Verdict] | None = None

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Works it out.

        Raises:
            UnknownName: No reasoner computes the relation.
        """
        subject, object_ = binding[self.subject], binding[self.object]
        if self.function is not None:
            return self.function(view, subject, object_)
        answer = view.reasoners.answer(view, subject, self.relation, object_)
        return Verdict(answer.holds, answer.reason)

    def pairs(self, view: WorldView, subjects: Sequence[str], objects: Sequence[str]) -> Iterator[tuple[str, str]]:
        """Yields between which elements it holds: quicker than asking for each pair, where a reasoner works it out.

        Raises:
            UnknownName: No reasoner computes the relation.
        """
        if self.function is not None:
            yield from (pair for pair in product(subjects, objects) if self.function(view, *pair))
            return
        for below in view.reasoners.narrowest(view.ontology, self.relation):
            yield from view.reasoners.pairs(view, below, subjects, objects)


@dataclass(frozen=True, slots=True)
class Not:
    """The pattern does not hold."""

    pattern: Pattern

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Turns the answer round."""
        inner = self.pattern.evaluate(view, binding)
        if not inner.parts:
            return Verdict(not inner.holds, inner.text)
        return Verdict(
            not inner.holds, Message("not: {text}", text=inner.text), (inner,)
        )  # what decides the inner one decides this

    def rename(self, names: Mapping[str, str]) -> Not:
        """Returns the same pattern with other variable names."""
        return Not(self.pattern.rename(names))


@dataclass(frozen=True, slots=True)
class _Joined:
    patterns: tuple[Pattern, ...]

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Evaluates each."""
        parts = tuple(pattern.evaluate(view, binding) for pattern in self.patterns)
        if isinstance(self, AllOf):
            return Verdict(all(parts), ALL_OF_THESE, parts)
        return Verdict(any(parts), ANY_OF_THESE, parts)

    def rename(self, names: Mapping[str, str]) -> Self:
        """Returns the same pattern with other variable names."""
        return replace(self, patterns=tuple(pattern.rename(names) for pattern in self.patterns))


@dataclass(frozen=True, slots=True)
class AllOf(_Joined):
    """All patterns hold."""


@dataclass(frozen=True, slots=True)
class AnyOf(_Joined):
    """At least one of the patterns holds."""


@dataclass(frozen=True, slots=True)
class Exists:
    """There is an element of a class for which the pattern holds."""

    variable: str
    class_: str
    pattern: Pattern

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Tries the elements of the class in the order of their ids."""
        for candidate in self._candidates(view, binding):
            verdict = self.pattern.evaluate(view, {**binding, self.variable: candidate})
            if verdict:
                text = Message("{thing} is the {kind}", thing=candidate, kind=local_name(self.class_))
                return Verdict(True, text, (verdict,))
        bound = ", ".join(value for key, value in sorted(binding.items()) if key != self.variable)
        text = Message("no {kind} makes it true for {things}", kind=local_name(self.class_), things=bound)
        return Verdict(False, text, vague=True)

    def _candidates(self, view: WorldView, binding: Binding) -> Sequence[str]:
        """The elements of the class; only those that are related as they must be, where the pattern begins so."""
        parts = self.pattern.patterns if isinstance(self.pattern, AllOf) else (self.pattern,)
        for part in parts:
            if isinstance(part, Related) and part.subject == self.variable != part.object and part.object in binding:
                near = view.subjects(part.relation, binding[part.object])
            elif isinstance(part, Related) and part.object == self.variable != part.subject and part.subject in binding:
                near = view.objects(binding[part.subject], part.relation)
            else:
                continue
            return view.instances_among(self.class_, near)
        return view.instances(self.class_)

    def rename(self, names: Mapping[str, str]) -> Exists:
        """Returns the same pattern with other names of its free variables."""
        free = {old: new for old, new in names.items() if old != self.variable}
        variable, inner = self.variable, self.pattern
        while variable in free.values():  # a new name must not fall under this quantifier
            variable += "'"
        if variable != self.variable:
            inner = inner.rename({self.variable: variable})
        return Exists(variable, self.class_, inner.rename(free))


@dataclass(frozen=True, slots=True)
class IsA(Atom):
    """An element is of a class, or of one below it."""

    subject: str
    class_: str

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Looks it up."""
        subject = binding[self.subject]
        type_ = view.element(subject).type
        holds = view.ontology.is_a(type_, self.class_)
        said = {"thing": subject, "kind": local_name(type_)}
        if holds:
            return Verdict(True, Message("{thing} is a {kind}", **said))
        return Verdict(False, Message("{thing} is a {kind}, not a {wanted}", wanted=local_name(self.class_), **said))


@dataclass(frozen=True, slots=True)
class ClassRelated(Atom):
    """The ontology says of the first one's class that its things are related to things like the second one.

    It says so by a restriction on the class or one above it: ``someValuesFrom`` or ``allValuesFrom`` a class of which
    the second one is, or ``hasValue`` the second one itself. Whether the two are related in the scene is not asked.
    """

    relation: str
    subject: str
    object: str

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Looks for what the classes say."""
        subject, object_ = binding[self.subject], binding[self.object]
        type_ = view.element(subject).type
        below = view.ontology.sub_relations(self.relation)
        said = [filler for filler in view.ontology.fillers(type_) if filler.relation in below]
        words = {"kind": local_name(type_), "relation": local_name(self.relation), "object": object_}
        for filler in said:
            if _meets(view, object_, filler):
                meant = local_name(filler.of)
                return Verdict(True, Message("a {kind} {relation} a {meant}, as {object} is one", meant=meant, **words))
        known = ", ".join(local_name(filler.of) for filler in said) or Message("nothing that is said")
        words |= {"known": known, "other": local_name(view.element(object_).type)}
        return Verdict(False, Message("a {kind} {relation} {known}, and {object} is a {other}", **words))


def _meets(view: WorldView, element: str, filler: Filler) -> bool:
    if not filler.is_class:
        return element == filler.of
    if filler.of not in view.ontology.classes:  # owl:Thing: anything will do; what OWL alone knows, nothing
        return filler.of == "owl:Thing"
    return view.ontology.is_a(view.element(element).type, filler.of)


Classes = Mapping[str, str]
"""Class of the element that a variable stands for, by variable."""


def leaves(pattern: Pattern, classes: Classes = MappingProxyType({})) -> Iterator[tuple[Pattern, Classes]]:
    """Yields what a pattern is made of, also the quantifiers, each with the classes of its variables."""
    match pattern:
        case Not(inner):
            yield from leaves(inner, classes)
        case AllOf(patterns) | AnyOf(patterns):
            for part in patterns:
                yield from leaves(part, classes)
        case Exists(variable, class_, inner):
            yield pattern, classes
            yield from leaves(inner, {**classes, variable: class_})
        case _:
            yield pattern, classes
