"""Writes a planning task as standard PDDL, deterministic and readable: ``:strips :typing`` is enough to read it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType

from skiros_py.planning.domain.literals import BY_CLASS, HAS, IS, NOT, NOTHING, VALUE, compared
from skiros_py.planning.domain.model import Action, Atom, Domain, NoneSuch, Problem, Variable
from skiros_py.world.names import local_name

_LOGIC = frozenset({"and", "or", "not", "exists", "forall", "when", "imply", "either"})
_STRUCTURE = frozenset({"object", "define", "domain", "problem"})
_NUMBERS = frozenset({"number", "total-cost", "total-time", "increase", "decrease", "assign", "minimize", "maximize"})
RESERVED = _LOGIC | _STRUCTURE | _NUMBERS
"""Words of PDDL itself; a variable, with its question mark, may be called like one."""


class NameMap:
    """Gives each name a PDDL name (lower case, letters, digits, '_' and '-'), deterministically, and maps it back.

    Args:
        names: Names that are mapped first, in this order.
        avoid: Maps whose PDDL names are not reused: some parsers require one name space for everything.
        reserved: Words that are never used.
    """

    def __init__(
        self, names: Iterable[str] = (), *, avoid: Sequence[NameMap] = (), reserved: frozenset[str] = RESERVED
    ) -> None:
        self._reserved = reserved
        self._to: dict[str, str] = {}
        self._from: dict[str, str] = {}
        self._avoid = avoid
        for name in names:
            self.pddl(name)

    def pddl(self, name: str, word: str | None = None) -> str:
        """Returns the PDDL name of a name; of two similar names, the first gets the plain one.

        Args:
            name: The name.
            word: What its PDDL name is made from, where that is not the name itself.
        """
        if name not in self._to:
            plain = _plain(word or name)
            candidate, number = plain, 1
            while self._taken(candidate):
                number += 1
                candidate = f"{plain}-{number}"
            self._to[name] = candidate
            self._from[candidate] = name
        return self._to[name]

    @property
    def known(self) -> Mapping[str, str]:
        """PDDL names by name, of those requested so far; a cheap view."""
        return MappingProxyType(self._to)

    def back(self, pddl_name: str) -> str:
        """Returns the name that a PDDL name stands for.

        Raises:
            KeyError: It is unknown.
        """
        return self._from[pddl_name.lower()]

    def gives(self, pddl_name: str) -> bool:
        """Returns True when the PDDL name stands for something."""
        return pddl_name in self._from

    def _taken(self, candidate: str) -> bool:
        return candidate in self._reserved or any(other.gives(candidate) for other in (self, *self._avoid))


@lru_cache(maxsize=10_000)
def _plain(name: str) -> str:
    local = name.partition(" #")[0]  # the suffix that makes variables unique is not part of their name
    local = local.partition(":")[2] or local
    snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", local).lower()
    safe = re.sub(r"[^a-z0-9_-]+", "_", snake).strip("_-")
    return safe if safe[:1].isalpha() else f"x{safe}"


@dataclass(frozen=True, slots=True)
class PddlTexts:
    """A domain, a problem, and the mapping back from PDDL names.

    Attributes:
        domain, problem: The texts.
        objects: PDDL names of the elements.
        actions: Actions by PDDL name.
        requirements: What the texts use, in PDDL's keywords: ":strips", ":typing", ….
    """

    domain: str
    problem: str
    objects: NameMap = field(repr=False)
    actions: Mapping[str, Action] = field(repr=False)
    requirements: tuple[str, ...] = (":strips", ":typing")


class _Writer:
    """One task being written. One name space for objects, types, predicates and actions: some parsers require it."""

    def __init__(self, domain: Domain, problem: Problem) -> None:
        self.domain = domain
        self.problem = problem
        self.objects = NameMap(sorted(problem.objects))
        self.types = NameMap(sorted(domain.types), avoid=(self.objects,))
        self.predicates = NameMap(avoid=(self.objects, self.types))
        for name in sorted(domain.predicates):
            self.predicates.pddl(name, _predicate_words(name))
        actions = (action.name for action in domain.actions)
        self.actions = NameMap(actions, avoid=(self.objects, self.types, self.predicates))
        named = {argument for action in domain.actions for atom in action.atoms for argument in atom.arguments}
        self.constants = sorted(named & set(problem.objects))

    def object(self, element: str) -> str:
        return f"    {self.objects.pddl(element)} - {self.type(self.problem.objects[element])}"

    def atom(self, atom: Atom, variables: NameMap) -> str:
        arguments = [f"?{variables.pddl(a)}" if a.startswith("?") else self.objects.pddl(a) for a in atom.arguments]
        return f"({' '.join([self.predicates.pddl(atom.predicate), *arguments])})"

    def ground(self, atom: Atom) -> str:
        """Returns an atom over elements; each of them has its name by now."""
        names = map(self.objects.known.__getitem__, atom.arguments)
        return f"({' '.join([self.predicates.known[atom.predicate], *names])})"

    def none(self, none: NoneSuch, variables: NameMap) -> str:
        atoms = [self.atom(atom, variables) for atom in none.atoms]
        inner = atoms[0] if len(atoms) == 1 else f"(and {' '.join(atoms)})"
        return f"(not (exists ({self.typed(none.variables, variables)}) {inner}))"

    def type(self, class_: str) -> str:
        return "object" if class_ in ("", "object") else self.types.pddl(class_)

    def typed(self, variables: Iterable[Variable], names: NameMap) -> str:
        return " ".join(f"?{names.pddl(v.name)} - {self.type(v.type)}" for v in variables)


def write_pddl(domain: Domain, problem: Problem, *, name: str) -> PddlTexts:
    """Writes domain and problem.

    Args:
        domain: Types, predicates and actions.
        problem: Objects, initial facts and goal.
        name: Name of the problem (made a PDDL name).
    """
    writer = _Writer(domain, problem)
    actions = {writer.actions.pddl(action.name): action for action in domain.actions}
    title = NameMap().pddl(name)
    requirements = _requirements(domain)
    domain_text = _domain_text(writer, title, requirements)
    return PddlTexts(domain_text, _problem_text(writer, title), writer.objects, actions, requirements)


def _requirements(domain: Domain) -> tuple[str, ...]:
    """Returns the requirements used: negating more than one atom is formally "disjunctive"."""
    quantified = any(action.none for action in domain.actions)
    return (":strips", ":typing", *((":disjunctive-preconditions", ":existential-preconditions") if quantified else ()))


def _block(lines: Iterable[str], indent: str) -> str:
    return "(and" + "".join(f"\n{indent}{line}" for line in lines) + ")"


def _domain_text(writer: _Writer, title: str, requirements: Sequence[str]) -> str:
    domain = writer.domain
    types = [f"    {writer.type(t)} - {writer.type(domain.types[t])}" for t in sorted(domain.types)]
    predicates = [f"    {_predicate(writer, name, types_)}" for name, types_ in sorted(domain.predicates.items())]
    actions = [_action_text(writer, action) for action in domain.actions]
    head = [f"(define (domain {title})", f"  (:requirements {' '.join(requirements)})", "  (:types", *types, "  )"]
    if writer.constants:  # elements that goals name, and defaults of skills
        head += ["  (:constants", *map(writer.object, writer.constants), "  )"]
    return "\n".join([*head, "  (:predicates", *predicates, "  )", *actions, ")"]) + "\n"


def _predicate(writer: _Writer, name: str, types: tuple[str, ...]) -> str:
    variables = [Variable(f"?x{i + 1}", type_) for i, type_ in enumerate(types)]
    return f"({' '.join(filter(None, [writer.predicates.pddl(name), writer.typed(variables, NameMap())]))})"


def _action_text(writer: _Writer, action: Action) -> str:
    indent = " " * 6
    names = NameMap((v.name for v in action.variables), reserved=frozenset())
    needed = [*(writer.atom(atom, names) for atom in action.pre), *(writer.none(none, names) for none in action.none)]
    effects = [writer.atom(atom, names) for atom in action.add]
    effects += [f"(not {writer.atom(atom, names)})" for atom in _real_deletes(action)]
    return "\n".join(
        [
            f"  (:action {writer.actions.pddl(action.name)}",
            f"    :parameters ({writer.typed(action.parameters, names)})",
            f"    :precondition {_block(needed, indent)}",
            f"    :effect {_block(effects, indent)})",
        ]
    )


def _real_deletes(action: Action) -> list[Atom]:
    return [atom for atom in action.delete if atom not in action.add]


def _problem_text(writer: _Writer, title: str) -> str:
    problem = writer.problem
    objects = [writer.object(o) for o in sorted(problem.objects) if o not in writer.constants]
    init = sorted(f"    {writer.ground(atom)}" for atom in problem.init)
    goal = _block((writer.ground(atom) for atom in problem.goal), " " * 4)
    lines = [f"(define (problem {title})", f"  (:domain {title})", "  (:objects", *objects, "  )"]
    return "\n".join([*lines, "  (:init", *init, "  )", f"  (:goal {goal})", ")"]) + "\n"


def _predicate_words(name: str) -> str:
    """Returns what a predicate's PDDL name is made from, without parts that look like a prefix."""
    if name.startswith(NOT):
        return f"not_{local_name(_predicate_words(name.removeprefix(NOT)))}"
    if name.startswith(VALUE):
        property_, comparison = compared(name)
        return re.sub(r"\W+", "_", f"{local_name(property_)} {comparison}").strip("_")
    for prefix in (HAS, IS, NOTHING, BY_CLASS):
        if name.startswith(prefix):
            return f"{prefix.strip()}_{local_name(name)}"
    return name
