"""Causes with the findings behind them, in the operator's words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from skiros_py.planning.domain.literals import BY_CLASS, CAN, HAS, IS, NOT, NOTHING, VALUE, compared
from skiros_py.planning.domain.matching import is_variable
from skiros_py.planning.domain.model import Atom
from skiros_py.planning.plan import Cause, CauseKind
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology

_SHOWN = 4
"""How many things of one kind are named at most."""


class Wording:
    """Words atoms in natural language."""

    def __init__(self, ontology: Ontology) -> None:
        self._ontology = ontology

    def atom(self, atom: Atom, types: Mapping[str, str]) -> str:
        """Words an atom.

        Args:
            atom: The atom, perhaps with variables left.
            types: Classes of the variables.
        """
        predicate = atom.predicate
        names = [some(local_name(types.get(a, "")) or "thing") if is_variable(a) else a for a in atom.arguments]
        if predicate.startswith(CAN):
            return f"{names[0]} has the skill '{predicate.removeprefix(CAN)}'"
        if predicate.startswith(HAS):
            return f"{names[0]} has a {self.term(predicate.removeprefix(HAS))}"
        if predicate.startswith(NOTHING):
            return f"nothing {self.term(predicate.removeprefix(NOTHING))} {names[0]}"
        if predicate.startswith(NOT):
            return f"it is not true that {self.atom(Atom(predicate.removeprefix(NOT), atom.arguments), types)}"
        if predicate.startswith(IS):
            return f"{names[0]} is {some(local_name(predicate.removeprefix(IS)))}"
        if predicate.startswith(BY_CLASS):
            relation = self.term(predicate.removeprefix(BY_CLASS))
            return f"what is like {names[0]} {relation} what is like {names[1]}"
        if predicate.startswith(VALUE):
            property_, comparison = compared(predicate)
            return f"the {self.term(property_)} of {names[0]} is {comparison}"
        term = self.term(predicate)
        verb = term.removesuffix(" a") if len(names) > 1 else term  # "has a": the name has its article
        return f"{names[0]} {verb} {' '.join(names[1:])}".strip()

    def none(self, atom: Atom, types: Mapping[str, str]) -> str:
        """Words that a relation with variables holds for none: "compressor_1 fits in no Compartment"."""
        names: list[str] = []
        for argument in atom.arguments:
            word = "any" if any(name.startswith("no ") for name in names) else "no"
            names.append(f"{word} {local_name(types.get(argument, 'thing'))}" if is_variable(argument) else argument)
        return f"{names[0]} {self.term(atom.predicate)} {' '.join(names[1:])}"

    def term(self, term: str) -> str:
        """Returns the display name of a relation or property."""
        if term in self._ontology.relations:
            label = self._ontology.relations[term].label
            return f"is {label}" if self._ontology.is_placement(term) else label
        return self._ontology.properties[term].label if term in self._ontology.properties else local_name(term)


def some(noun: str) -> str:
    """Returns a noun with its article."""
    return f"{'an' if noun[:1].lower() in 'aeiou' else 'a'} {noun}"


def listed(names: Iterable[str], word: str = "and") -> str:
    """Returns names as a readable list; if there are very many, only the first."""
    all_ = list(names)
    shown = all_ if len(all_) <= _SHOWN else [*all_[:_SHOWN], f"{len(all_) - _SHOWN} more"]
    return " ".join(filter(None, [", ".join(shown[:-1]), word if len(shown) > 1 else "", *shown[-1:]]))


@dataclass(frozen=True, slots=True)
class Shortage:
    """More is required than there is.

    Attributes:
        wanted: How many different ones are required.
        there: The existing things or places.
        things: The things that need the places and could be removed; empty if things are short.
    """

    wanted: int
    there: tuple[str, ...]
    things: tuple[str, ...] = ()

    @property
    def excess(self) -> int:
        """How many more are required than there are."""
        return self.wanted - len(self.there)


@dataclass(frozen=True, slots=True)
class Found:
    """A cause with the findings behind it.

    Attributes:
        cause: The cause.
        reason: What never holds; None for conditions that exclude each other.
        shortage: What is short; None if the cause is not a shortage.
    """

    cause: Cause
    reason: Reason | None = None
    shortage: Shortage | None = None


@dataclass(frozen=True, slots=True)
class Reason:
    """The reason why a fact never becomes true.

    Attributes:
        kind: The kind of cause.
        text: The chain of reasons in words.
        core: The last link alone: the actual state that prevents the required one.
        skill: The skill that would provide the missing fact; None if there is none.
        precondition: The unreachable precondition of that skill, in words.
        elements: The elements and classes involved.
        missing: The fact that never holds, perhaps with variables left; None if it is not one fact.
        types: Classes of the variables of that fact.
    """

    kind: CauseKind
    text: str
    skill: str | None = None
    precondition: str = ""
    elements: tuple[str, ...] = ()
    missing: Atom | None = None
    types: Mapping[str, str] = field(default_factory=dict)
    core: str = ""
