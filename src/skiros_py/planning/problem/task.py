"""Builds the planning task from the available skills, the world model and the goal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

from skiros_py.errors import PlanningError, SkirosError
from skiros_py.interruptions import Interruption
from skiros_py.planning.domain.actions import actions_of, needs_of, possible_variants
from skiros_py.planning.domain.complements import with_complements
from skiros_py.planning.domain.goals import CompiledGoal, compile_goal, maintain_emptiness
from skiros_py.planning.domain.literals import (
    CAN,
    IS,
    NOT,
    NOTHING,
    Asked,
    asked_literals,
    common_class,
    is_stored,
    primary_line,
    with_class_predicates,
)
from skiros_py.planning.domain.matching import FactIndex, Fits, fitting, solutions
from skiros_py.planning.domain.model import Action, Atom, Domain, Problem
from skiros_py.planning.domain.numbers import number_facts, numbers_of
from skiros_py.planning.problem.lifted import Lifted
from skiros_py.planning.problem.relevance import Relevant, relevant
from skiros_py.planning.problem.stock import superfluous
from skiros_py.planning.replay import StepConditions
from skiros_py.skills.conditions import Computed, Condition, Not
from skiros_py.skills.skill import SkillDescription
from skiros_py.skills.surroundings import robot_of
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView


class Facts:
    """The facts about some elements, by predicate.

    Args:
        view: The world.
        objects: The elements, with their classes.
        asked: What is evaluated, by predicate, over the variables "1" and "2".
        who: Names the conditions that use a predicate, for error messages.
    """

    def __init__(
        self,
        view: WorldView,
        objects: Mapping[str, str],
        asked: Mapping[str, Asked | Not],
        who: Callable[[str], str],
    ) -> None:
        self._view = view
        self._objects = objects
        self._asked = asked
        self._who = who
        self._found: dict[tuple[str, tuple[str, ...]], tuple[Atom, ...]] = {}
        self._of_class: dict[str, tuple[str, ...]] = {}

    def of(self, predicates: Mapping[str, tuple[str, ...]]) -> set[Atom]:
        """Returns the facts of predicates with the given argument types.

        Raises:
            PlanningError: A condition's own function failed; the message names the condition.
        """
        positive = ((name, types) for name, types in predicates.items() if not self._is_denied(name))
        return {atom for name, types in positive for atom in self._facts(name, types)}

    def denied(self, actions: Iterable[Action], goal: Iterable[Atom]) -> set[Atom]:
        """Returns which stored relations do not hold, only between things for which it is required."""
        said: list[tuple[Atom, Mapping[str, str]]] = [(a, action.types) for action in actions for a in action.pre]
        said += [(atom, {}) for atom in goal]
        wanted = dict.fromkeys(
            (atom.predicate, tuple(a if a in self._objects else types.get(a, "") for a in atom.arguments))
            for atom, types in said
            if self._is_denied(atom.predicate)
        )
        return {atom for name, ends in wanted for atom in self._facts(name, ends)}

    def _is_denied(self, name: str) -> bool:
        """Returns whether a predicate says that a stored relation does not hold."""
        is_negative = name.startswith(NOT) and name not in self._asked
        return is_negative and is_stored(name.removeprefix(NOT), self._view.ontology)

    def _facts(self, name: str, ends: tuple[str, ...]) -> tuple[Atom, ...]:
        """Returns the facts of a predicate about classes or elements."""
        key = name, ends
        if key not in self._found:
            try:
                self._found[key] = tuple(self._worked_out(name, [self._fitting(end) for end in ends]))
            except (SkirosError, KeyboardInterrupt, Interruption):
                raise
            except BaseException as error:
                said = f"{type(error).__name__}: {error}"
                raise PlanningError(f"{self._who(name) or name} cannot be worked out: {said}") from error
        return self._found[key]

    def _worked_out(self, name: str, fitting: Sequence[Sequence[str]]) -> Iterable[Atom]:
        if name in self._asked:
            return (Atom(name, ids) for ids in self._holding(self._asked[name], fitting))
        if name.startswith(NOTHING):
            relation = name.removeprefix(NOTHING)
            return (Atom(name, (place,)) for place in fitting[0] if not self._view.subjects(relation, place))
        if name.startswith(IS):
            class_, ontology = name.removeprefix(IS), self._view.ontology
            return (Atom(name, (o,)) for o in fitting[0] if ontology.is_a(self._objects[o], class_))
        relation = name.removeprefix(NOT)
        return self._stored(name, relation, fitting) if relation in self._view.ontology.relations else ()

    def _stored(self, name: str, relation: str, fitting: Sequence[Sequence[str]]) -> Iterable[Atom]:
        targets = frozenset(fitting[1])
        for subject in fitting[0]:
            stated = _stated_objects(self._view, subject, relation)
            found = (o for o in stated if o in targets) if name == relation else targets.difference(stated)
            yield from (Atom(name, (subject, object_)) for object_ in found)

    def _holding(self, literal: Asked | Not, fitting: Sequence[Sequence[str]]) -> Iterable[tuple[str, ...]]:
        """Returns the tuples a literal holds for, among fitting arguments."""
        if isinstance(literal, Computed):
            return literal.pairs(self._view, fitting[0], fitting[1])
        tuples = product(*fitting)
        if isinstance(literal, Not) and isinstance(literal.pattern, Computed):
            there = set(literal.pattern.pairs(self._view, fitting[0], fitting[1]))
            return (ids for ids in tuples if ids not in there)
        return (ids for ids in tuples if literal.evaluate(self._view, dict(zip(("1", "2"), ids, strict=False))))

    def _fitting(self, end: str) -> tuple[str, ...]:
        """Returns an element itself, or the elements of a class."""
        if end in self._objects:
            return (end,)
        if end not in self._of_class:
            below = None if end in ("", "object") else frozenset(self._view.ontology.subclasses(end))
            self._of_class[end] = tuple(o for o, type_ in self._objects.items() if below is None or type_ in below)
        return self._of_class[end]


def _stated_objects(view: WorldView, subject: str, relation: str) -> tuple[str, ...]:
    """Returns what a subject is related to by exactly this relation: not by a narrower one, which ends by itself."""
    narrower = view.ontology.sub_relations(relation)[1:]
    found = view.objects(subject, relation)
    if not narrower or not found:
        return found
    below = {other for one in narrower for other in view.objects(subject, one)}
    return tuple(other for other in found if other not in below)


def living(actions: Iterable[Action], view: WorldView) -> tuple[Action, ...]:
    """Removes variants that involve a class without elements (no station, no deck, ...)."""
    drafts = tuple(actions)
    classes = {v.type for action in drafts for v in action.parameters} & view.ontology.classes.keys()
    empty = {class_ for class_ in classes if not view.some_instances(class_, 1)}
    return _or_all(drafts, lambda action: all(v.type not in empty for v in action.parameters))


def supported(
    actions: Sequence[Action], init: Iterable[Atom], objects: Mapping[str, str], ontology: Ontology
) -> tuple[Action, ...]:
    """Removes variants with a precondition that neither holds initially nor is ever achieved (no kit is carried, ...).

    Args:
        actions: All of the task.
        init: What holds at the start.
        objects: The elements, with their classes.
        ontology: Classes.
    """
    added = {atom.predicate for action in actions for atom in action.add}
    facts = FactIndex(init)
    fits = fitting(objects, ontology)

    def may_be(atom: Atom, types: Mapping[str, str]) -> bool:
        return atom.predicate in added or next(solutions([atom], facts, {}, types, fits), None) is not None

    kept = _or_all(actions, lambda action: all(may_be(atom, action.types) for atom in action.pre))
    count = Counter(action.skill for action in kept)
    return tuple(replace(a, name=a.skill) if a.skill is not None and count[a.skill] == 1 else a for a in kept)


def _or_all(actions: Sequence[Action], is_good: Callable[[Action], bool]) -> tuple[Action, ...]:
    """Returns the good ones; for a skill without any, all, so that explanations can name what it lacks."""
    good = {action.name for action in actions if is_good(action)}
    skills = {action.skill for action in actions if action.name in good}
    return tuple(a for a in actions if a.name in good or a.skill is None or a.skill not in skills)


@dataclass(frozen=True, slots=True)
class Capability:
    """An available skill, and the ids of the subsystems whose skill managers provide it."""

    skill: SkillDescription
    agents: tuple[str, ...]


@dataclass(frozen=True)
class PlanningTask:
    """Everything a planner, a validator and an explanation need.

    Attributes:
        domain, problem: The parts written as PDDL.
        goal: Each condition with the atoms that stand for it.
        capabilities: The available skills.
        view: The world it was built from.
        asked: The literals evaluated for the facts, by predicate, over the variables "1" and "2".
        complete: True if it has a plan whenever one exists; False if candidates were left out.
    """

    domain: Domain
    problem: Problem
    goal: tuple[tuple[Condition, tuple[Atom, ...]], ...]
    capabilities: tuple[Capability, ...]
    view: WorldView = field(compare=False, repr=False)
    asked: Mapping[str, Asked | Not] = field(default_factory=dict)
    complete: bool = True

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """The goal."""
        return tuple(condition for condition, _ in self.goal)

    @cached_property
    def fits(self) -> Fits:
        """Returns whether an element of the task is of a class."""
        return fitting(self.problem.objects, self.view.ontology)

    @cached_property
    def teams(self) -> Mapping[str, frozenset[str]]:
        """The subsystems that have skills, by robot (by their own id if they belong to none)."""
        found: dict[str, set[str]] = {}
        for agent in sorted({agent for c in self.capabilities for agent in c.agents}):
            found.setdefault(robot_of(self.view, agent), set()).add(agent)
        return {robot: frozenset(agents) for robot, agents in sorted(found.items())}

    @cached_property
    def robots(self) -> Mapping[str, str]:
        """The robot of each subsystem that has skills."""
        return {agent: robot for robot, agents in self.teams.items() for agent in agents}

    @cached_property
    def skills(self) -> StepConditions:
        """The available skills by name."""
        return StepConditions({c.skill.name: c.skill for c in self.capabilities})


def extended(task: PlanningTask, actions: tuple[Action, ...], facts: Iterable[Atom]) -> PlanningTask:
    """Returns a task with other actions, and with facts of their new predicates as far as their arguments fit."""
    ontology, old = task.view.ontology, task.domain.predicates
    found = _predicates(actions, (), task.problem.objects, ontology)
    new = {
        name: tuple(class_ if class_ in task.domain.types else "object" for class_ in types)
        for name, types in sorted(found.items())
        if name not in old
    }
    further = {f for f in facts if f.predicate in new and all(map(task.fits, f.arguments, new[f.predicate]))}
    domain = replace(task.domain, predicates={**old, **new}, actions=actions)
    return replace(task, domain=domain, problem=replace(task.problem, init=task.problem.init | further))


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
        wanted = (c.closed_pattern(self._ontology) for c in goal)
        self._asked = asked_literals((*needed, *wanted), self._ontology)

    @property
    def _skills(self) -> list[SkillDescription]:
        return [capability.skill for capability in self._capabilities]

    def task(self, width: int | None, *, whole: bool) -> PlanningTask:
        """Returns the task."""
        compiled = self._compiled()
        atoms = tuple(atom for own in compiled.atoms for atom in own)
        if whole:
            possible, elements = _everything(self._view, compiled.actions)
        else:
            possible, elements = relevant(self._view, compiled.actions, atoms, self._agents, self._asked, width)
        objects = {name: self._view.element(name).type for name in sorted(elements | self._named)}
        actions = with_class_predicates(possible, objects, self._ontology)
        actions, predicates, init = self._stated(actions, atoms, objects, compiled.init)
        if width is None and not whole:
            objects, init = self._merged(objects, init, actions, atoms)
        types = _types(objects, actions, predicates, self._ontology)
        return PlanningTask(
            Domain(types, predicates, actions),
            Problem(objects, frozenset(init), atoms),
            tuple(zip(self._goal, compiled.atoms, strict=True)),
            self._capabilities,
            self._view,
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
        start = known | facts.of(predicates) | facts.denied(actions, goal)
        possible = supported(actions, start, objects, self._ontology)
        predicates = _predicates(possible, goal, objects, self._ontology)
        init = {atom for atom in known if atom.predicate in predicates}
        numbers = number_facts(self._view, numbers_of(possible), objects)
        return possible, predicates, init | numbers | facts.of(predicates) | facts.denied(possible, goal)

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
        lifted = Lifted(actions, self._view, self._asked)
        gone = superfluous(objects, init, actions, goal, lifted, spoken | self._named)
        left = {name: type_ for name, type_ in objects.items() if name not in gone}
        return left, {atom for atom in init if gone.isdisjoint(atom.arguments)}


def _everything(view: WorldView, actions: Sequence[Action]) -> Relevant:
    """Takes all actions, and every element that fits some parameter."""
    classes = dict.fromkeys(v.type for action in actions for v in action.variables if v.type)
    constants = {c.name for action in actions for c in action.constants}
    return tuple(actions), frozenset(constants.union(*(view.instances(class_) for class_ in classes)))


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
