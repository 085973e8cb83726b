"""Builds the planning task from the available skills, the world model and the goal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from skiros_py.planning.domain.actions import actions_of
from skiros_py.planning.domain.classes import common_class, primary_line, with_class_predicates
from skiros_py.planning.domain.complements import complement_facts, with_complements
from skiros_py.planning.domain.emptiness import maintain_emptiness
from skiros_py.planning.domain.goals import CompiledGoal, compile_goal
from skiros_py.planning.domain.literals import CAN, Asked, asked_literals
from skiros_py.planning.domain.model import Action, Atom, Domain, Problem
from skiros_py.planning.domain.needs import needs_of
from skiros_py.planning.domain.variants import possible_variants
from skiros_py.planning.problem.facts import Facts, living, supported
from skiros_py.planning.problem.lifted import Lifted
from skiros_py.planning.problem.relevance import Relevant, relevant
from skiros_py.planning.problem.stock import superfluous
from skiros_py.skills.conditions import Condition, Not
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class Capability:
    """An available skill, and the ids of the subsystems whose skill managers provide it."""

    skill: SkillDescription
    agents: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PlanningTask:
    """Everything a planner, a validator and an explanation need.

    Attributes:
        domain, problem: The parts written as PDDL.
        goal: Each condition with the atoms that stand for it.
        capabilities: The available skills.
        asked: The literals evaluated for the facts, by predicate, over the variables "1" and "2".
        complete: True if it has a plan whenever one exists; False if candidates were left out.
    """

    domain: Domain
    problem: Problem
    goal: tuple[tuple[Condition, tuple[Atom, ...]], ...]
    capabilities: tuple[Capability, ...]
    asked: Mapping[str, Asked | Not] = field(default_factory=dict)
    complete: bool = True

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """The goal."""
        return tuple(condition for condition, _ in self.goal)


def build_task(
    view: WorldView,
    capabilities: Sequence[Capability],
    goal: Sequence[Condition],
    *,
    width: int | None = None,
    whole: bool = False,
) -> PlanningTask:
    """Translates world, skills and goal, leaving out what the goal cannot need.

    Args:
        view: The world.
        capabilities: The available skills.
        goal: The conditions that must all hold.
        width: How many candidates are tried where there is a choice: a quick guess. None gives the complete problem:
            only if that has no plan, there is none.
        whole: True to keep every skill, and every element that fits some parameter, needed or not: for inspection.

    Raises:
        PlanningError: Something cannot be expressed in PDDL; the message names it.
    """
    return _Building(view, capabilities, goal).task(width, whole=whole)


class _Building:
    """One task being built."""

    def __init__(self, view: WorldView, capabilities: Sequence[Capability], goal: Sequence[Condition]) -> None:
        self._view = view
        self._ontology = view.ontology
        self._capabilities = tuple(capabilities)
        self._agents = {CAN + c.skill.name: c.agents for c in capabilities}
        self._goal = tuple(goal)
        self._named = {a for c in goal for a in c.arguments if view.has(a)}
        needed = (c.pattern for skill in self._skills for c in needs_of(skill))
        self._asked = asked_literals((*needed, *(c.closed_pattern(self._ontology) for c in goal)), self._ontology)

    @property
    def _skills(self) -> list[SkillDescription]:
        return [capability.skill for capability in self._capabilities]

    def task(self, width: int | None, *, whole: bool) -> PlanningTask:
        """Returns the task."""
        compiled = self._compiled()
        atoms = tuple(atom for own in compiled.atoms for atom in own)
        if whole:
            found = _everything(self._view, compiled.actions)
        else:
            found = relevant(self._view, compiled.actions, atoms, self._agents, self._asked, width)
        objects = {name: self._view.element(name).type for name in sorted(found.elements | self._named)}
        actions = with_class_predicates(found.actions, objects, self._ontology)
        actions, predicates, init = self._stated(actions, atoms, objects, compiled.init)
        if width is None and not whole:
            objects, init = self._merged(objects, init, actions, atoms)
        types = _types(objects, actions, predicates, self._ontology)
        return PlanningTask(
            Domain(types, predicates, actions),
            Problem(objects, frozenset(init), atoms),
            tuple(zip(self._goal, compiled.atoms, strict=True)),
            self._capabilities,
            self._asked,
            width is None,
        )

    def _compiled(self) -> CompiledGoal:
        """Returns the goal and all actions there are."""
        skills = (action for skill in self._skills for action in actions_of(skill, self._ontology, self._asked))
        possible = (action for action in skills if all(self._view.has(c.name) for c in action.constants))
        variants = possible_variants(living(possible, self._view), self._view)
        compiled = compile_goal(self._goal, maintain_emptiness(variants, self._ontology), self._view)
        atoms = (atom for own in compiled.atoms for atom in own)
        return replace(compiled, actions=with_complements(compiled.actions, atoms, self._ontology))

    def _stated(
        self, actions: Sequence[Action], goal: Sequence[Atom], objects: Mapping[str, str], given: Iterable[Atom]
    ) -> tuple[tuple[Action, ...], dict[str, tuple[str, ...]], set[Atom]]:
        """Returns the possible actions, their predicates and the initial facts."""
        facts = Facts(self._view, objects, self._asked, self._who_asks)
        able = {Atom(can, (agent,)) for can, agents in self._agents.items() for agent in agents}
        known = {atom for atom in (*given, *able) if all(argument in objects for argument in atom.arguments)}
        predicates = _predicates(actions, goal, objects, self._ontology)
        start = known | facts.of(predicates) | self._denied(actions, goal, objects)
        possible = supported(actions, start, objects, self._ontology)
        predicates = _predicates(possible, goal, objects, self._ontology)
        init = {atom for atom in known if atom.predicate in predicates}
        return possible, predicates, init | facts.of(predicates) | self._denied(possible, goal, objects)

    def _denied(self, actions: Iterable[Action], goal: Iterable[Atom], objects: Mapping[str, str]) -> frozenset[Atom]:
        said: list[tuple[Atom, Mapping[str, str]]] = [(a, action.types) for action in actions for a in action.pre]
        said += [(atom, {}) for atom in goal]
        stored = [(atom, types) for atom, types in said if atom.predicate not in self._asked]
        return complement_facts(stored, objects, self._view)

    def _who_asks(self, predicate: str) -> str:
        words = (*(c for s in self._skills for c in needs_of(s)), *self._goal)
        asking = (c for c in words if predicate in asked_literals((c.pattern,), self._ontology))
        return ", ".join(dict.fromkeys(map(str, asking)))

    def _merged(
        self, objects: Mapping[str, str], init: Iterable[Atom], actions: Sequence[Action], goal: Iterable[Atom]
    ) -> tuple[dict[str, str], set[Atom]]:
        """Removes superfluous interchangeable elements."""
        said = (*(atom for action in actions for atom in action.atoms), *goal)
        spoken = {argument for atom in said for argument in atom.arguments}
        lifted = Lifted(actions, self._ontology, self._asked)
        gone = superfluous(objects, init, actions, lifted, spoken | self._named)
        left = {name: type_ for name, type_ in objects.items() if name not in gone}
        return left, {atom for atom in init if gone.isdisjoint(atom.arguments)}


def _everything(view: WorldView, actions: Sequence[Action]) -> Relevant:
    """Takes all actions, and every element that fits some parameter."""
    classes = dict.fromkeys(v.type for action in actions for v in action.variables if v.type)
    constants = {c.name for action in actions for c in action.constants}
    return Relevant(tuple(actions), frozenset(constants.union(*(view.instances(class_) for class_ in classes))))


def _predicates(
    actions: Sequence[Action], goal: Sequence[Atom], objects: Mapping[str, str], ontology: Ontology
) -> dict[str, tuple[str, ...]]:
    """Returns argument types of every predicate in use: the nearest common class of its uses."""
    found: dict[str, tuple[str, ...]] = {}

    def meet(atom: Atom, types: Mapping[str, str]) -> None:
        new = tuple(types.get(argument, objects.get(argument, "")) for argument in atom.arguments)
        old = found.get(atom.predicate, new)
        found[atom.predicate] = tuple(common_class(a, b, ontology) for a, b in zip(old, new, strict=True))

    for action in actions:
        types = action.types | {name: objects[name] for name in action.types if name in objects}
        for atom in action.atoms:
            meet(atom, types)
    for atom in goal:
        meet(atom, objects)
    return found


def _types(
    objects: Mapping[str, str],
    actions: Sequence[Action],
    predicates: Mapping[str, tuple[str, ...]],
    ontology: Ontology,
) -> dict[str, str]:
    """Returns the class tree over the classes in use, along primary parents."""
    asked = {v.type for a in actions for v in a.variables} | {t for types in predicates.values() for t in types}
    used = (asked | set(objects.values())) - {"", "object"}
    return {c: next((a for a in primary_line(ontology, c) if a in used), "object") for c in sorted(used)}
