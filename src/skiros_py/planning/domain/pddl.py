"""Writes a planning task as standard PDDL, deterministic and readable; ``:strips :typing`` is mostly enough for it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from functools import lru_cache
from types import MappingProxyType

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.literals import BY_CLASS, HAS, IS, NOT, NOTHING, VALUE, compared
from skiros_py.planning.domain.model import Action, Atom, Domain, Grounding, NoneSuch, Problem, Variable
from skiros_py.planning.domain.numbers import NUMBER, change_of, number_compared, numbers_in, numbers_of
from skiros_py.skills.conditions.condition import Comparison, Constant
from skiros_py.world.names import local_name

_LOGIC = frozenset({"and", "or", "not", "exists", "forall", "when", "imply", "either"})
_STRUCTURE = frozenset({"object", "define", "domain", "problem"})
_NUMBERS = frozenset({"number", "total-cost", "total-time", "increase", "decrease", "assign", "minimize", "maximize"})
RESERVED = _LOGIC | _STRUCTURE | _NUMBERS
"""Words of PDDL itself; variables may use these words."""
LEARNED_COST = "learned-cost"
"""How the functions begin that say what was learned: ``(learned-cost-pick arm_1 box_a ball_1)``."""


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
        """Returns the PDDL name of a name; if two names map to the same PDDL name, the later one gets a number.

        Args:
            name: The name.
            word: The text that its PDDL name is made from; the name itself if omitted.
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
        """PDDL names by name, of those requested so far; a read-only view."""
        return MappingProxyType(self._to)

    def back(self, pddl_name: str) -> str:
        """Returns the name that a PDDL name stands for.

        Raises:
            KeyError: It is unknown.
        """
        return self._from[pddl_name.lower()]

    def gives(self, pddl_name: str) -> bool:
        """Returns True if a name has this PDDL name."""
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

    def line(self, step: Grounding) -> str:
        """Returns an applied action as planners write it: "(drive base_1 box_a)"."""
        name = next(word for word, action in self.actions.items() if action.name == step.action.name)
        return f"({' '.join([name, *(self.objects.pddl(step.binding[v.name]) for v in step.action.parameters)])})"

    def grounding(self, words: Sequence[str]) -> Grounding:
        """Reads an applied action: its name and objects, in PDDL names.

        Raises:
            PlanningError: The task has no such action or object, or the action takes another number of objects.
        """
        name, *objects = words
        try:
            action = self.actions[name.lower()]
            elements = [self.objects.back(object_) for object_ in objects]
        except KeyError as error:
            raise PlanningError(f"the planner answered with {error}, which is not in the task") from error
        if len(elements) != len(action.parameters):
            takes = f"{name} takes {len(action.parameters)} objects"
            raise PlanningError(f"the planner answered with ({' '.join(words)}), but {takes}")
        return Grounding(action, {v.name: element for v, element in zip(action.parameters, elements, strict=True)})


class PddlWriter:
    """Writes one task. One name space for objects, types, predicates and actions: some parsers require it.

    Args:
        domain: Types, predicates and actions.
        problem: Objects, initial facts and goal.
        name: Name of the problem (made a PDDL name).

    Attributes:
        metric: What a plan has to minimize; empty if nothing.
    """

    metric = ""

    def __init__(self, domain: Domain, problem: Problem, name: str) -> None:
        self.domain = domain
        self.problem = problem
        self.objects = NameMap(sorted(problem.objects))
        self.types = NameMap(sorted(domain.types), avoid=(self.objects,))
        self.predicates = NameMap(avoid=(self.objects, self.types))
        self._numbers = numbers_of(domain.actions)
        self._declared = [predicate for predicate in sorted(domain.predicates) if self.number(predicate) is None]
        for predicate in self._declared:
            self.predicates.pddl(predicate, _predicate_words(predicate))
        actions = (action.name for action in domain.actions)
        self.actions = NameMap(actions, avoid=(self.objects, self.types, self.predicates))
        self.other_names = NameMap(avoid=(self.objects, self.types, self.predicates, self.actions))
        self._title = NameMap().pddl(name)
        named = {argument for action in domain.actions for atom in action.atoms for argument in atom.arguments}
        self._constants = sorted(named & set(problem.objects))

    def texts(self) -> PddlTexts:
        """Writes domain and problem."""
        actions = {self.actions.pddl(action.name): action for action in self.domain.actions}
        return PddlTexts(self._domain_text(), self._problem_text(), self.objects, actions, self.requirements())

    # ------------------------------------------------------------ overridden for temporal and cost tasks

    def requirements(self) -> tuple[str, ...]:
        """Returns the requirements used; ``not`` over a conjunction or ``exists`` needs the two further ones."""
        quantified = (":disjunctive-preconditions", ":existential-preconditions")
        compared = [found for name in self.domain.predicates if (found := self.number(name)) is not None]
        return (
            ":strips",
            ":typing",
            *((":negative-preconditions",) if any(comparison.op == "!=" for _, comparison in compared) else ()),
            *(quantified if any(action.none for action in self.domain.actions) else ()),
            *((":numeric-fluents",) if self._numbers else ()),
        )

    def predicate_lines(self) -> list[str]:
        """Returns the declarations of the predicates."""
        return [self._predicate(name, self.domain.predicates[name]) for name in self._declared]

    def functions(self) -> list[str]:
        """Returns the declarations of functions."""
        found = []
        for name in sorted(self._numbers):
            about = self.domain.predicates.items()
            types = {ends for p, ends in about if p == HAS + name or ((n := self.number(p)) and n[0] == name)}
            (type_,) = types.pop() if len(types) == 1 else ("object",)
            found.append(f"({self.other_names.pddl(name)} {self.typed([Variable('?x1', type_)], NameMap())}) - number")
        return found

    def init(self) -> list[str]:
        """Returns the initial facts, and what numbers are at the start."""
        facts = self.facts(atom for atom in self.problem.init if not atom.predicate.startswith(NUMBER))
        numbers = sorted((of, value) for of, value in numbers_in(self.problem.init).items() if of[0] in self._numbers)
        told = [f"(= {self._function(*of, NameMap())} {_digits(value)})" for of, value in numbers]
        return [*sorted(map(self._ground, facts)), *told]

    def action(self, action: Action) -> str:
        """Writes an action."""
        names = variable_names(action)
        return "\n".join(
            [
                f"  (:action {self.actions.pddl(action.name)}",
                f"    :parameters ({self.typed(action.parameters, names)})",
                f"    :precondition {block(self.needs(action, names))}",
                f"    :effect {block(self.effects(action, names))})",
            ]
        )

    def effects(self, action: Action, names: NameMap) -> list[str]:
        """Returns the effects of an action, adds first."""
        deleted = (f"(not {self.atom(atom, names)})" for atom in self.facts(real_deletes(action)))
        changes = (text for _, text in self.changes(action, names))
        return [*(self.atom(atom, names) for atom in self.facts(action.add)), *deleted, *changes]

    # ------------------------------------------------------------ parts

    def needs(self, action: Action, names: NameMap) -> list[str]:
        """Returns the preconditions of an action."""
        return [*(self.atom(atom, names) for atom in action.pre), *(self.none(none, names) for none in action.none)]

    def number(self, predicate: str) -> tuple[str, Comparison] | None:
        """Returns how a predicate compares the value of a function; None if it is a predicate in PDDL, too."""
        found = number_compared(predicate) if self._numbers else None
        return None if found is None or found[0] not in self._numbers else found

    def facts(self, atoms: Iterable[Atom]) -> list[Atom]:
        """Returns the atoms that are no comparisons of a function."""
        return [atom for atom in atoms if self.number(atom.predicate) is None]

    def changes(self, action: Action, names: NameMap) -> list[tuple[str, str]]:
        """Returns the numeric effects of an action, each with its first word."""
        told = [(change_of(atom), atom.arguments) for atom in action.changes]
        found = []
        for (word, property_, by), arguments in told:
            if property_ in self._numbers:
                amount = self._function(by, arguments[-1], names) if isinstance(by, str) else _digits(by)
                found.append((word, f"({word} {self._function(property_, arguments[0], names)} {amount})"))
        return found

    def applied(self, function: str, arguments: Sequence[str], variables: NameMap | None = None) -> str:
        """Returns a function, by its PDDL name, of variables or elements."""
        names = NameMap() if variables is None else variables
        return f"({' '.join([function, *(self._argument(argument, names) for argument in arguments)])})"

    def columns(self, arguments: Sequence[str]) -> str:
        """Returns the arguments in the declaration of a function of any objects."""
        return f"{' '.join(f'?x{number}' for number, _ in enumerate(arguments, start=1))} - object"

    def _function(self, property_: str, argument: str, variables: NameMap) -> str:
        return f"({self.other_names.pddl(property_)} {self._argument(argument, variables)})"

    def _argument(self, argument: str, variables: NameMap) -> str:
        return f"?{variables.pddl(argument)}" if argument.startswith("?") else self.objects.pddl(argument)

    def atom(self, atom: Atom, variables: NameMap) -> str:
        """Returns an atom over variables and elements."""
        number = self.number(atom.predicate)
        if number is not None:
            property_, comparison = number
            op = "=" if comparison.op == "!=" else comparison.op
            text = f"({op} {self._function(property_, atom.arguments[0], variables)} {_digits(comparison.value)})"
            return text if op == comparison.op else f"(not {text})"
        arguments = [self._argument(argument, variables) for argument in atom.arguments]
        return f"({' '.join([self.predicates.pddl(atom.predicate), *arguments])})"

    def none(self, none: NoneSuch, variables: NameMap) -> str:
        """Returns the condition that no such things exist."""
        atoms = [self.atom(atom, variables) for atom in none.atoms]
        inner = atoms[0] if len(atoms) == 1 else f"(and {' '.join(atoms)})"
        return f"(not (exists ({self.typed(none.variables, variables)}) {inner}))"

    def typed(self, variables: Iterable[Variable], names: NameMap) -> str:
        """Returns variables with their types."""
        return " ".join(f"?{names.pddl(v.name)} - {self._type(v.type)}" for v in variables)

    def _ground(self, atom: Atom) -> str:
        """Returns an atom over elements; all names are mapped already."""
        names = map(self.objects.known.__getitem__, atom.arguments)
        return f"({' '.join([self.predicates.known[atom.predicate], *names])})"

    def _type(self, class_: str) -> str:
        return "object" if class_ in ("", "object") else self.types.pddl(class_)

    def _object(self, element: str) -> str:
        return f"{self.objects.pddl(element)} - {self._type(self.problem.objects[element])}"

    def _predicate(self, name: str, types: tuple[str, ...]) -> str:
        variables = [Variable(f"?x{i + 1}", type_) for i, type_ in enumerate(types)]
        return f"({' '.join(filter(None, [self.predicates.pddl(name), self.typed(variables, NameMap())]))})"

    def _domain_text(self) -> str:
        types = [f"{self._type(t)} - {self._type(self.domain.types[t])}" for t in sorted(self.domain.types)]
        constants = map(self._object, self._constants)  # elements that goals name, and defaults of skills
        lines = [
            f"(define (domain {self._title})",
            f"  (:requirements {' '.join(self.requirements())})",
            *_section("types", types),
            *(_section("constants", constants) if self._constants else ()),
            *_section("predicates", self.predicate_lines()),
            *(_section("functions", self.functions()) if self.functions() else ()),
            *map(self.action, self.domain.actions),
        ]
        return "\n".join([*lines, ")"]) + "\n"

    def _problem_text(self) -> str:
        objects = [self._object(o) for o in sorted(self.problem.objects) if o not in self._constants]
        lines = [
            f"(define (problem {self._title})",
            f"  (:domain {self._title})",
            *_section("objects", objects),
            *_section("init", self.init()),
            f"  (:goal {block((self.atom(atom, NameMap()) for atom in self.problem.goal), indent=4)})",
            *([f"  (:metric {self.metric})"] if self.metric else ()),
        ]
        return "\n".join([*lines, ")"]) + "\n"


def write_pddl(domain: Domain, problem: Problem, *, name: str) -> PddlTexts:
    """Writes a classical task; see :class:`PddlWriter`."""
    return PddlWriter(domain, problem, name).texts()


def variable_names(action: Action) -> NameMap:
    """Returns the PDDL names of an action's variables, without question marks."""
    return NameMap((v.name for v in action.variables), reserved=frozenset())


def real_deletes(action: Action) -> list[Atom]:
    """Returns what an action deletes and does not add."""
    return [atom for atom in action.delete if atom not in action.add]


def block(lines: Iterable[str], indent: int = 6) -> str:
    """Returns a conjunction, one part per line."""
    return "(and" + "".join(f"\n{' ' * indent}{line}" for line in lines) + ")"


def _digits(value: Constant) -> str:
    """Returns a number without an exponent: some parsers know none."""
    return f"{Decimal(repr(value)):f}"


def _section(keyword: str, lines: Iterable[str]) -> list[str]:
    return [f"  (:{keyword}", *(f"    {line}" for line in lines), "  )"]


def _predicate_words(name: str) -> str:
    """Returns the text that a predicate's PDDL name is made from, without namespace prefixes."""
    if name.startswith(NOT):
        return f"not_{local_name(_predicate_words(name.removeprefix(NOT)))}"
    if name.startswith(VALUE):
        property_, comparison = compared(name)
        return re.sub(r"\W+", "_", f"{local_name(property_)} {comparison}").strip("_")
    for prefix in (HAS, IS, NOTHING, BY_CLASS):
        if name.startswith(prefix):
            return f"{prefix.strip()}_{local_name(name)}"
    return name
