"""A planning task as data: typed STRIPS, in the world model's own names; and an account of it for skill authors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from skiros_py.skills.skill import SkillDescription


@dataclass(frozen=True, slots=True, order=True)
class Atom:
    """A predicate applied to variables ("?Robot") or to element ids."""

    predicate: str
    arguments: tuple[str, ...] = ()

    def bind(self, binding: Mapping[str, str]) -> Atom:
        """Replaces variables by what they are bound to."""
        return Atom(self.predicate, tuple(binding.get(argument, argument) for argument in self.arguments))


@dataclass(frozen=True, slots=True)
class Variable:
    """A typed action parameter; ``name`` starts with '?', where it is no element."""

    name: str
    type: str


@dataclass(frozen=True, slots=True)
class NoneSuch:
    """The precondition that no such things exist: no values of the variables make all the atoms true together."""

    variables: tuple[Variable, ...]
    atoms: tuple[Atom, ...]

    def bind(self, binding: Mapping[str, str]) -> NoneSuch:
        """Replaces the variables of the action, not its own."""
        return NoneSuch(self.variables, tuple(atom.bind(binding) for atom in self.atoms))


@dataclass(frozen=True, slots=True)
class Estimate:
    """What to expect of a skill.

    Attributes:
        seconds: Expected time until it succeeds, with the failed attempts before [s].
        chance: The probability that an attempt succeeds.
    """

    seconds: float
    chance: float


class ActionCosts(Protocol):
    """What was learned about the costs of an action."""

    @property
    def about(self) -> tuple[str, ...]:
        """The variables that they may depend on."""

    def __call__(self, binding: Mapping[str, str]) -> Estimate | None:
        """Estimates the costs for elements; None if the duration is unknown."""


@dataclass(frozen=True, slots=True)
class Action:
    """An action: STRIPS, plus :attr:`none` if a skill author's condition requires it.

    Attributes:
        name: Unique name; a skill's variants are numbered ("place/2").
        skill: The skill it stands for, or None for bookkeeping of the goal.
        parameters: Typed variables; the skill's own come first, in their order.
        pre, add, delete: Positive atoms over the parameters; deletes happen before adds.
        notes: What was added to the author's skill, and why.
        constants: Elements that the skill always refers to, with their classes; its atoms name them.
        none: Things that must not exist; empty if typed STRIPS suffices.
        duration: How long it takes [s]; None if unknown, and for bookkeeping.
        changes: What it does to numbers (:func:`~skiros_py.planning.domain.numbers.change_atom`). What they may make
            true is among :attr:`add`, as far as a number can get: an over-approximation, which is never written.
        costs: What was learned about it, for the elements it is applied to; None if nothing.
    """

    name: str
    skill: str | None
    parameters: tuple[Variable, ...]
    pre: tuple[Atom, ...]
    add: tuple[Atom, ...]
    delete: tuple[Atom, ...]
    notes: tuple[str, ...] = ()
    constants: tuple[Variable, ...] = ()
    none: tuple[NoneSuch, ...] = ()
    duration: float | None = None
    changes: tuple[Atom, ...] = ()
    costs: ActionCosts | None = field(default=None, compare=False, repr=False)

    def seconds(self, binding: Mapping[str, str]) -> float | None:
        """Returns how long it is expected to take with these elements [s]; None if unknown."""
        estimate = None if self.costs is None else self.costs(binding)
        return self.duration if estimate is None else estimate.seconds

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Its parameters, and the variables of :attr:`none`."""
        return (*self.parameters, *(variable for none in self.none for variable in none.variables))

    @property
    def types(self) -> dict[str, str]:
        """Class of each argument of its atoms."""
        return {v.name: v.type for v in (*self.variables, *self.constants)}

    @property
    def atoms(self) -> tuple[Atom, ...]:
        """Every atom it contains."""
        return (*self.pre, *self.add, *self.delete, *(atom for none in self.none for atom in none.atoms))


@dataclass(frozen=True, slots=True)
class Grounding:
    """An action with the elements it is applied to.

    Attributes:
        action: The action.
        binding: Element by variable.
    """

    action: Action
    binding: Mapping[str, str]

    def of(self, atoms: Iterable[Atom]) -> frozenset[Atom]:
        """Returns atoms of the action over these elements."""
        return frozenset(atom.bind(self.binding) for atom in atoms)


@dataclass(frozen=True, slots=True)
class Domain:
    """Types (child to parent; roots have parent "object"), predicates (argument types) and actions."""

    types: Mapping[str, str]
    predicates: Mapping[str, tuple[str, ...]]
    actions: tuple[Action, ...]


@dataclass(frozen=True, slots=True)
class Problem:
    """Objects (id to type), initial facts and goal atoms."""

    objects: Mapping[str, str]
    init: frozenset[Atom]
    goal: tuple[Atom, ...]


@dataclass(frozen=True, slots=True)
class ActionAccount:
    """One action of the domain.

    Attributes:
        name: Its name in the domain.
        parameters: Its parameters, each with its class: "Ball: tiny:Ball".
        notes: What was added to or removed from the author's skill, and why.
    """

    name: str
    parameters: tuple[str, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SkillAccount:
    """One skill, or the bookkeeping of the goal.

    Attributes:
        skill: Its name; empty for the bookkeeping.
        pre, hold, post: The conditions its author wrote.
        actions: The resulting actions; none if the goal cannot need it.
    """

    skill: str
    pre: tuple[str, ...]
    hold: tuple[str, ...]
    post: tuple[str, ...]
    actions: tuple[ActionAccount, ...]


def account_of(skills: Iterable[SkillDescription], actions: Sequence[tuple[str, Action]]) -> tuple[SkillAccount, ...]:
    """Describes the translation skill by skill.

    Args:
        skills: The skills.
        actions: The actions of the domain, each with its name there.
    """
    own: dict[str | None, tuple[ActionAccount, ...]] = {}
    for name, action in actions:
        parameters = tuple(f"{v.name.lstrip('?')}: {v.type or 'anything'}" for v in action.parameters)
        own[action.skill] = (*own.get(action.skill, ()), ActionAccount(name, parameters, action.notes))
    accounts = []
    for skill in skills:
        pre, hold, post = (tuple(map(str, conditions)) for conditions in (skill.pre, skill.hold, skill.post))
        accounts.append(SkillAccount(skill.name, pre, hold, post, own.get(skill.name, ())))
    return (*accounts, *([SkillAccount("", (), (), (), own[None])] if None in own else ()))
