"""Patterns as conjunctions of literals, with the variables that existentials bring along."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

from skiros_py.errors import PlanningError
from skiros_py.planning.model import Atom, Variable
from skiros_py.skills.conditions import AllOf, AnyOf, Computed, Exists, Has, Not, Nothing, Pattern, Related
from skiros_py.world.ontology import Ontology

__all__ = ["CAN", "HAS", "NOTHING", "Conjunction", "atom_of", "expand"]

CAN = "can_"
HAS = "has "
NOTHING = "nothing "


@dataclass(frozen=True, slots=True)
class Conjunction:
    """Positive atoms that hold together, over the pattern's variables and these further ones."""

    atoms: tuple[Atom, ...] = ()
    variables: tuple[Variable, ...] = ()


def atom_of(pattern: Related | Nothing | Has | Computed) -> Atom:
    """Returns the atom of a pattern that is one literal; its arguments are the pattern's variables."""
    match pattern:
        case Related(relation, subject, object_) | Computed(relation, subject, object_, _):
            return Atom(relation, (subject, object_))
        case Nothing(relation, object_):
            return Atom(NOTHING + relation, (object_,))
        case Has(property_, subject):
            return Atom(HAS + property_, (subject,))


def expand(pattern: Pattern, where: str, ontology: Ontology, fresh: Iterator[int]) -> tuple[Conjunction, ...]:
    """Returns the pattern as a disjunction of conjunctions of positive literals.

    Args:
        pattern: Any pattern; existentials become variables.
        where: For the message of a refusal ("precondition X of skill 'y'").
        ontology: Gives the class of what a relation relates.
        fresh: Numbers that keep the variables of different existentials apart.

    Raises:
        PlanningError: It has a part that typed STRIPS cannot say; the message names it.
    """
    match pattern:
        case Related(relation, _, _) if len(ontology.sub_relations(relation)) > 1:
            narrower = ", ".join(r for r in ontology.sub_relations(relation) if r != relation)
            raise PlanningError(f"{where}: {relation} is too general to be planned with; name one of {narrower}")
        case Related() | Nothing() | Has() | Computed():
            return (Conjunction((atom_of(pattern),)),)
        case Not(Nothing(relation, object_)):
            other = f"{object_} holder #{next(fresh)}"
            class_ = ontology.relations[relation].domain or ""
            return (Conjunction((Atom(relation, (other, object_)),), (Variable(other, class_),)),)
        case Not(Not(inner)):
            return expand(inner, where, ontology, fresh)
        case AllOf(patterns):
            combinations = product(*(expand(p, where, ontology, fresh) for p in patterns))
            return tuple(_join(combination) for combination in combinations)
        case AnyOf(patterns):
            return tuple(conjunction for p in patterns for conjunction in expand(p, where, ontology, fresh))
        case Exists(variable, class_, inner):
            name = f"{variable} #{next(fresh)}"
            extra = (Variable(name, class_),)
            inner_ways = expand(inner.rename({variable: name}), where, ontology, fresh)
            return tuple(Conjunction(c.atoms, extra + c.variables) for c in inner_ways)
        case _:
            advice = "that something is not so cannot be planned for; say what should be so instead"
            raise PlanningError(f"{where}: {advice}")


def _join(parts: tuple[Conjunction, ...]) -> Conjunction:
    atoms = tuple(atom for part in parts for atom in part.atoms)
    variables = tuple(variable for part in parts for variable in part.variables)
    return Conjunction(tuple(dict.fromkeys(atoms)), tuple(dict.fromkeys(variables)))
