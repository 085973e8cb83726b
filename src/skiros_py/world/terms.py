"""The declarations of an ontology: classes, relations and properties, as plain values."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from graphlib import CycleError, TopologicalSorter
from types import MappingProxyType
from typing import Literal, Self, TypeVar


class Kind(StrEnum):
    """The kinds of terms; the value is the display name."""

    CLASS = "class"
    RELATION = "relation"
    PROPERTY = "property"
    ANNOTATION = "annotation property"
    DATATYPE = "data type"


DECLARES: Mapping[str, Kind] = MappingProxyType(
    {
        "owl:Class": Kind.CLASS,
        "rdfs:Class": Kind.CLASS,
        "owl:ObjectProperty": Kind.RELATION,
        # These can be of object properties only, and older tools write nothing else.
        "owl:InverseFunctionalProperty": Kind.RELATION,
        "owl:TransitiveProperty": Kind.RELATION,
        "owl:SymmetricProperty": Kind.RELATION,
        "owl:AsymmetricProperty": Kind.RELATION,
        "owl:ReflexiveProperty": Kind.RELATION,
        "owl:IrreflexiveProperty": Kind.RELATION,
        "owl:DatatypeProperty": Kind.PROPERTY,
        "owl:AnnotationProperty": Kind.ANNOTATION,
        "owl:OntologyProperty": Kind.ANNOTATION,
        "rdf:Property": Kind.ANNOTATION,
        "rdfs:Datatype": Kind.DATATYPE,
    }
)
"""The kind of term that a type (CURIE) declares."""


# ---------------------------------------------------------------- declared terms


_T = TypeVar("_T", bound=Hashable)

PlaceEnd = Literal["subject", "object"]

End = tuple[tuple[str, ...], ...]
"""The classes allowed at one end of a relation: at least one of each group; empty allows anything."""


class Family(StrEnum):
    """The purpose of a relation; given in the ontology by its superproperty."""

    PLACEMENT = "placement"
    """Where a thing is: one place across the whole family."""
    STRUCTURE = "structure"
    """The parts of a thing: a part has one owner."""
    COMPUTED = "computed"
    """Computed on demand, never stored."""
    PLAIN = "plain"
    """Any other."""


@dataclass(frozen=True, slots=True)
class Cardinality:
    """How many things an individual of a class has by one relation or property.

    Attributes:
        relation: CURIE of the relation or property.
        least: The fewest.
        most: The most, or None for any number.
        of: CURIE of the class (for a property, data type) that is counted, or None for all.
    """

    relation: str
    least: int
    most: int | None
    of: str | None


@dataclass(frozen=True, slots=True)
class Filler:
    """What individuals of a class are related to: "some", "only" or one individual.

    Attributes:
        relation: CURIE of the relation.
        of: CURIE of the class, or the individual, that they are related to.
        is_class: Whether that is a class.
    """

    relation: str
    of: str
    is_class: bool


@dataclass(frozen=True, slots=True)
class Term:
    """One class, relation or property.

    Attributes:
        curie: Its name ("kitting:Starter").
        label: Its display name, in English if it has one in English.
        comment: What it means.
        labels, comments: The same in the other languages that it has, by language tag in lower case ("de").
    """

    curie: str
    label: str
    comment: str
    labels: Mapping[str, str] = field(default_factory=dict, kw_only=True, hash=False)
    comments: Mapping[str, str] = field(default_factory=dict, kw_only=True, hash=False)

    def in_language(self, language: str) -> Self:
        """Returns the term with label and comment in a language; what it lacks there stays as it is.

        Args:
            language: Language tag; of a regional one ("de-CH"), the language itself ("de") is the next best.
        """
        tags = (language.lower(), language.lower().partition("-")[0])
        label, comment = (
            next((texts[tag] for tag in tags if tag in texts), default)
            for texts, default in ((self.labels, self.label), (self.comments, self.comment))
        )
        return replace(self, label=label, comment=comment)


@dataclass(frozen=True, slots=True)
class Class(Term):
    """One class.

    Attributes:
        parents: Its direct superclasses, the primary one first.
        equivalents: Other classes of the same individuals, sorted.
        cardinalities: What it says itself of numbers; see :meth:`~skiros_py.world.ontology.Ontology.cardinalities`.
        fillers: What it says itself of what its things are related to; see
            :meth:`~skiros_py.world.ontology.Ontology.fillers`.
    """

    parents: tuple[str, ...]
    equivalents: tuple[str, ...] = ()
    cardinalities: tuple[Cardinality, ...] = ()
    fillers: tuple[Filler, ...] = ()

    @property
    def primary_parent(self) -> str | None:
        """The superclass whose line is followed first, or None at the top."""
        return self.parents[0] if self.parents else None


@dataclass(frozen=True, slots=True)
class Relation(Term):
    """One relation between elements.

    Attributes:
        parents: Its direct super-relations, sorted.
        domains, ranges: The classes required of subject and object.
        family: Its purpose.
        place_end: For a placement, the end that is the place; None for the others.
        functional: True when a subject has at most one object; a new object replaces the old one.
        inverse: The inverse relation, or None.
        inverse_functional: True when an object has at most one subject.
        symmetric, transitive: As OWL means them; computed by reasoners only.
    """

    parents: tuple[str, ...]
    domains: End
    ranges: End
    family: Family
    place_end: PlaceEnd | None
    functional: bool
    inverse: str | None = None
    inverse_functional: bool = False
    symmetric: bool = False
    transitive: bool = False

    @property
    def domain(self) -> str | None:
        """The one class that the subject must be of, or None if there is none or it is not that simple."""
        return _only(self.domains)

    @property
    def range(self) -> str | None:
        """The one class that the object must be of, or None if there is none or it is not that simple."""
        return _only(self.ranges)


@dataclass(frozen=True, slots=True)
class Property(Term):
    """One property of elements.

    Attributes:
        domains: The classes that may have it.
        range: CURIE of its data type, one of :data:`~skiros_py.world.literals.DATATYPES`.
        unit: Unit of its values (``sk:unit``), such as "kg"; empty if it has none.
    """

    domains: End
    range: str
    unit: str = ""

    @property
    def domain(self) -> str | None:
        """The one class that may have it, or None if there is none or it is not that simple."""
        return _only(self.domains)


def _only(end: End) -> str | None:
    return end[0][0] if len(end) == 1 and len(end[0]) == 1 else None


# ---------------------------------------------------------------- hierarchies


MOST_ABOVE = 500
"""Maximum number of terms above another: longer chains are not made by hand, and cost quadratic time."""


def reached(start: Iterable[_T], onward: Callable[[_T], Iterable[_T]]) -> tuple[_T, ...]:
    """Returns the start and all that is reached from it, depth first, each once."""
    found: dict[_T, None] = {}
    waiting = list(start)[::-1]
    while waiting:
        current = waiting.pop()
        if current not in found:
            found[current] = None
            waiting.extend(reversed(tuple(onward(current))))
    return tuple(found)


def closure(above: Mapping[str, Sequence[str]], name: str) -> tuple[str, ...]:
    """Returns a name and all above it, depth first, each once."""
    return reached([name], lambda current: above.get(current, ()))


def cycle(above: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Returns names each of which is below the next, the last being the first again; nothing if there is none."""
    try:
        TopologicalSorter(above).prepare()
    except CycleError as error:
        return tuple(reversed(error.args[1]))
    return ()


def too_deep(above: Mapping[str, Sequence[str]]) -> str | None:
    """Returns the first name with more than :data:`MOST_ABOVE` above it, or None if there is none."""
    return next((name for name in above if len(closure(above, name)) > MOST_ABOVE + 1), None)


def inverse(lines: Mapping[str, Sequence[str]]) -> dict[str, tuple[str, ...]]:
    """Returns for each name itself and all below it, sorted after the first, given each with all above it."""
    below: dict[str, list[str]] = {name: [name] for name in lines}
    for name in sorted(lines):
        for above in lines[name][1:]:
            below[above].append(name)
    return {name: tuple(names) for name, names in below.items()}
