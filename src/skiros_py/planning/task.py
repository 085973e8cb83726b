"""Builds the planning task: skills that are there, the world as believed, the goal that is wanted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

from skiros_py.errors import PlanningError, SkirosError
from skiros_py.interruptions import Interruption
from skiros_py.planning.actions import actions_of, maintain_emptiness
from skiros_py.planning.classes import IS, common_class, primary_line, with_class_predicates
from skiros_py.planning.goals import compile_goal
from skiros_py.planning.literals import CAN, NOTHING, Asked, asked_literals
from skiros_py.planning.model import Action, Atom, Domain, Problem
from skiros_py.planning.needs import needs_of
from skiros_py.skills.conditions import Computed, Condition, Not
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView

__all__ = ["Capability", "PlanningTask", "build_task"]


@dataclass(frozen=True, slots=True)
class Capability:
    """A skill that is there, and the ids of the subsystems whose skill managers offer it."""

    skill: SkillDescription
    agents: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PlanningTask:
    """Everything a planner, a validator and an explanation need.

    Attributes:
        domain, problem: What is written as PDDL.
        goal: Each condition with the atoms that stand for it.
        capabilities: The skills that are there.
        asked: By predicate, what was evaluated to find its facts, over the variables "1" and "2".
    """

    domain: Domain
    problem: Problem
    goal: tuple[tuple[Condition, tuple[Atom, ...]], ...]
    capabilities: tuple[Capability, ...]
    asked: Mapping[str, Asked | Not] = field(default_factory=dict)

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """The goal."""
        return tuple(condition for condition, _ in self.goal)


def build_task(view: WorldView, capabilities: Sequence[Capability], goal: Sequence[Condition]) -> PlanningTask:
    """Translates world, skills and goal.

    Raises:
        PlanningError: Something in them cannot be said in typed STRIPS; the message names it.
    """
    ontology = view.ontology
    skills = [c.skill for c in capabilities]
    asked = asked_literals(
        (*(c.pattern for s in skills for c in needs_of(s)), *(c.closed_pattern(ontology) for c in goal))
    )
    possible = (a for s in skills for a in actions_of(s, ontology, asked) if all(view.has(c.name) for c in a.constants))
    actions = maintain_emptiness(possible, ontology)
    compiled = compile_goal(goal, actions, view)
    atoms = tuple(atom for own in compiled.atoms for atom in own)
    constants = [c.name for action in actions for c in action.constants]
    objects = _objects(view, compiled.actions, [*constants, *(a for c in goal for a in c.arguments)])
    typed = with_class_predicates(compiled.actions, objects, ontology)

    def facts_of(name: str, types: tuple[str, ...]) -> Iterable[Atom]:
        try:
            return _facts(view, name, types, objects, asked)
        except (SkirosError, KeyboardInterrupt, Interruption):
            raise
        except BaseException as error:
            words = (*(c for s in skills for c in needs_of(s)), *goal)
            who = ", ".join(dict.fromkeys(str(c) for c in words if name in asked_literals((c.pattern,))))
            raise PlanningError(f"{who or name} cannot be worked out: {type(error).__name__}: {error}") from error

    def predicates_and_facts(actions: Sequence[Action]) -> tuple[dict[str, tuple[str, ...]], set[Atom]]:
        predicates = _predicates(actions, atoms, objects, ontology)
        facts = {atom for name, types in predicates.items() for atom in facts_of(name, types)}
        able = {Atom(CAN + c.skill.name, (agent,)) for c in capabilities for agent in c.agents}
        return predicates, facts | {atom for atom in able if atom.predicate in predicates} | compiled.init

    typed = _supported(typed, predicates_and_facts(typed)[1])
    predicates, init = predicates_and_facts(typed)
    domain = Domain(_types(objects, typed, predicates, ontology), predicates, typed)
    problem = Problem(objects, frozenset(init), atoms)
    by_condition = tuple(zip(goal, compiled.atoms, strict=True))
    return PlanningTask(domain, problem, by_condition, tuple(capabilities), asked)


def _supported(actions: Sequence[Action], init: set[Atom]) -> tuple[Action, ...]:
    """Leaves out variants that nothing in this scene can ever make possible (no kit is carried, ...).

    A skill's last variant stays, so that an explanation can say what it lacks.
    """
    there = {atom.predicate for atom in init} | {atom.predicate for action in actions for atom in action.add}
    good = [a for a in actions if all(atom.predicate in there for atom in a.pre)]
    kept = Counter(action.skill for action in good)
    left = (a for a in actions if a in good or a.skill is None or a.skill not in kept)
    return tuple(replace(a, name=a.skill) if a.skill is not None and kept[a.skill] == 1 else a for a in left)


def _objects(view: WorldView, actions: Iterable[Action], named: Iterable[str]) -> dict[str, str]:
    """Returns every element that some parameter could be, under its most specific class."""
    wanted = dict.fromkeys(v.type for action in actions for v in action.parameters if v.type)
    ids = {i for class_ in wanted for i in view.instances(class_)} | {n for n in named if view.has(n)}
    return {i: view.element(i).type for i in sorted(ids)}


def _predicates(
    actions: Sequence[Action], goal: Sequence[Atom], objects: Mapping[str, str], ontology: Ontology
) -> dict[str, tuple[str, ...]]:
    """Returns argument types of every predicate in use: the nearest common class of what it is used with."""
    found: dict[str, tuple[str, ...]] = {}

    def meet(atom: Atom, types: Mapping[str, str]) -> None:
        new = tuple(types.get(argument, "") for argument in atom.arguments)
        old = found.get(atom.predicate, new)
        found[atom.predicate] = tuple(common_class(a, b, ontology) for a, b in zip(old, new, strict=True))

    for action in actions:
        types = action.types | dict(objects)
        for atom in (*action.pre, *action.add, *action.delete):
            meet(atom, types)
    for atom in goal:
        meet(atom, objects)
    return found


def _facts(
    view: WorldView,
    name: str,
    types: tuple[str, ...],
    objects: Mapping[str, str],
    asked: Mapping[str, Asked | Not],
) -> Iterable[Atom]:
    fitting = [_fitting(objects, type_, view.ontology) for type_ in types]
    if name in asked:
        return [Atom(name, ids) for ids in _holding(view, asked[name], fitting)]
    if name.startswith(NOTHING):
        relation = name.removeprefix(NOTHING)
        return [Atom(name, (place,)) for place in fitting[0] if not view.subjects(relation, place)]
    if name.startswith(IS):
        return [Atom(name, (o,)) for o in fitting[0] if view.ontology.is_a(objects[o], name.removeprefix(IS))]
    if name not in view.ontology.relations:
        return []
    targets = set(fitting[1])
    return [Atom(name, (s, o)) for s in fitting[0] for o in view.objects(s, name) if o in targets]


def _fitting(objects: Mapping[str, str], class_: str, ontology: Ontology) -> list[str]:
    if class_ in ("", "object"):
        return list(objects)
    below = {type_ for type_ in set(objects.values()) if ontology.is_a(type_, class_)}
    return [o for o, type_ in objects.items() if type_ in below]


def _holding(view: WorldView, literal: Asked | Not, fitting: Sequence[Sequence[str]]) -> Iterable[tuple[str, ...]]:
    """Returns what a literal holds of, among what fits its arguments."""
    if isinstance(literal, Computed):
        return literal.pairs(view, fitting[0], fitting[1])
    tuples = product(*fitting)
    if isinstance(literal, Not) and isinstance(literal.pattern, Computed):
        there = set(literal.pattern.pairs(view, fitting[0], fitting[1]))
        return (ids for ids in tuples if ids not in there)
    return (ids for ids in tuples if literal.evaluate(view, dict(zip(("1", "2"), ids, strict=False))))


def _types(
    objects: Mapping[str, str],
    actions: Sequence[Action],
    predicates: Mapping[str, tuple[str, ...]],
    ontology: Ontology,
) -> dict[str, str]:
    """Returns the class tree over the classes in use, along primary parents."""
    asked = {v.type for a in actions for v in a.parameters} | {t for types in predicates.values() for t in types}
    used = (asked | set(objects.values())) - {"", "object"}
    return {c: next((a for a in primary_line(ontology, c) if a in used), "object") for c in sorted(used)}
