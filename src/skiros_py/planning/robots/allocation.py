"""Allocates the parts of a goal to robots before planning, so that all robots get a fair share of the effort.

A planner that minimizes plan length gives everything to one robot, since parallel work does not shorten the plan. So
the parts of the goal are allocated by estimated time, and static facts state which robot may handle which thing. The
resulting task is more constrained than the original: if it has no plan, the original still has to be tried.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf

from skiros_py.planning.domain.actions import is_placement, moved_and_place
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.planning.plan import Step
from skiros_py.planning.problem.reachability import Relaxation
from skiros_py.planning.problem.task import PlanningTask, extended
from skiros_py.world.ontology import Ontology
from skiros_py.world.vocabulary import ROBOT


def moved_by(action: Action, ontology: Ontology) -> tuple[tuple[str, str], ...]:
    """Returns the things an action moves, each with its new place, as the action's variables."""
    return tuple(moved_and_place(atom, ontology) for atom in action.add if is_placement(atom, ontology))


class Handling:
    """What the actions of a task handle.

    Attributes:
        variables: The variables of handled things, by action name; without actions that handle nothing.
        agents: The variable of the acting agent, by action name.
    """

    def __init__(self, task: PlanningTask) -> None:
        self._ontology = task.view.ontology
        self._objects = task.problem.objects
        self.variables: dict[str, tuple[str, ...]] = {}
        self.agents: dict[str, str] = {}
        self._moved: set[str] = set()
        self._done_to: set[str] = set()
        self._keys: dict[str, tuple[str, ...]] = {}
        for action in task.domain.actions:
            moved = tuple(thing for thing, _ in moved_by(action, self._ontology))
            types = action.types
            if action.skill is None or any(self.is_one_of(types[v], [ROBOT]) for v in moved):
                continue
            skill = task.skills[action.skill]
            self.agents[action.name] = f"?{skill.agent}"
            self.variables[action.name] = tuple(dict.fromkeys((*moved, f"?{skill.target}")))
            self._keys[action.skill] = tuple(v.lstrip("?") for v in self.variables[action.name])
            self._moved |= {types[v] for v in moved}
            self._done_to.add(types[f"?{skill.target}"])
        self._done_to -= self._moved

    def things(self, named: Iterable[str]) -> frozenset[str]:
        """Returns the given elements that some action moves; if there are none, those that some action acts on."""
        known = {name: self._objects[name] for name in named if name in self._objects}
        return self.moved(known) or frozenset(
            name for name, class_ in known.items() if self.is_one_of(class_, self._done_to)
        )

    def of(self, step: Step) -> tuple[str, ...]:
        """Returns what a step moves, and what it acts on; nothing if it only moves its robot."""
        return tuple(step.arguments[key] for key in self._keys.get(step.skill, ()) if key in step.arguments)

    def moved(self, named: Iterable[str]) -> frozenset[str]:
        """Returns the given elements that some action moves."""
        known = {name: self._objects[name] for name in named if name in self._objects}
        return frozenset(name for name, class_ in known.items() if self.is_moved(class_))

    def is_moved(self, class_: str) -> bool:
        """Returns whether some action moves things of a class."""
        return self.is_one_of(class_, self._moved)

    def is_one_of(self, class_: str, classes: Iterable[str]) -> bool:
        """Returns whether a class is one of the given classes or a subclass of one."""
        return any(c in ("", "object") or (class_ != "object" and self._ontology.is_a(class_, c)) for c in classes)


ASSIGNED = "assigned"
"""Predicate stating that an agent may handle a thing."""

_SAME = 1e-6
"""Estimates that differ by less count as equal [s]."""


@dataclass(slots=True, eq=False)
class Share:
    """The part of a goal allocated to one robot.

    Attributes:
        robot: Its id.
        agents: Its subsystems that have skills.
        cost: The estimated time to each fact if only it acts [s].
        parts: Indices of the conditions of the goal.
        things: The elements that only it may handle.
        effort: The estimated time for its parts [s].
    """

    robot: str
    agents: frozenset[str]
    cost: Mapping[Atom, float]
    parts: list[int] = field(default_factory=list)
    things: set[str] = field(default_factory=set)
    effort: float = 0.0


def deal(task: PlanningTask) -> PlanningTask:
    """Returns the task in which each robot handles only what was allocated to it; unchanged if nothing was allocated.

    A single-robot task is returned unchanged.
    """
    if len(task.teams) < 2:
        return task
    dealt = Dealing(task)
    owners = dict.fromkeys(dealt.surplus, frozenset[str]())
    owners |= {thing: share.agents for share in dealt.shares for thing in share.things}
    return _narrowed(task, owners) if owners else task


# ------------------------------------------------------------ deal out


@dataclass(frozen=True, slots=True)
class Group:
    """Goal conditions about the same things, which therefore belong to one robot.

    Attributes:
        parts: Their indices.
        things: The things they are about; empty for an open choice such as "any starter in the kit".
        kind: The accepted class, if the choice is open.
        named: All elements that they name.
    """

    parts: tuple[int, ...]
    things: frozenset[str]
    kind: str = ""
    named: frozenset[str] = frozenset()


class Dealing:
    """Allocates the parts of the goal, the longest first, each to the robot that would finish all its parts soonest.

    Parts that only one robot can do go to that robot; parts that no robot can do alone are not restricted.

    Attributes:
        shares: Each robot's share.
        surplus: Unallocated things of an open kind: others are used instead.
    """

    def __init__(self, task: PlanningTask) -> None:
        self._task = task
        self._ontology = task.view.ontology
        self._handling = Handling(task)
        groups = [g for g in goal_groups(task) if g.things or g.kind]
        sketch = self._sketched(groups)
        self.shares = [
            Share(robot, agents, Relaxation(sketch, agents, timed=True).cost) for robot, agents in task.teams.items()
        ]
        wanted = {group: [self._effort(group, share.cost) for share in self.shares] for group in groups}
        least = [effort for efforts in wanted.values() if (effort := min(efforts)) < inf]
        self._fair = sum(least) / len(self.shares)
        open_kinds: set[str] = set()
        for group in sorted(groups, key=lambda g: (not g.things, -min(wanted[g]), g.parts)):
            if 0.0 < min(wanted[group]) < inf and self._give(group, wanted[group]) and group.kind:
                open_kinds.add(group.kind)
        self.surplus = frozenset(thing for kind in open_kinds for thing in self._free(kind))

    def _give(self, group: Group, wanted: Sequence[float]) -> bool:
        """Allocates a group; returns whether there are things for it.

        A robot that visits a place anyway also gets the other parts there, up to a fair share: two would block each
        other.
        """
        places = self._places(group.things)

        def order(number: int) -> tuple[bool, float, int]:
            share = self.shares[number]
            load = share.effort + wanted[number]
            goes = bool(places & self._places(share.things)) and load <= self._fair + _SAME
            return not goes, load, number

        number = min(range(len(wanted)), key=order)
        share = self.shares[number]
        things = group.things or self._nearest(group.kind, share)
        share.effort += wanted[number]
        share.parts = sorted((*share.parts, *group.parts))
        share.things |= things
        return bool(things)

    def _places(self, things: Collection[str]) -> set[str]:
        """Where some things are."""
        facts = (atom for atom in self._task.problem.init if is_placement(atom, self._ontology))
        placed = (moved_and_place(atom, self._ontology) for atom in facts)
        return {place for thing, place in placed if thing in things}

    def _sketched(self, groups: Sequence[Group]) -> PlanningTask:
        """The task without details that make estimates slow but hardly better.

        These are movable things not in the goal, and facts between things of different goal parts, such as that a part
        would fit into the compartment of another.
        """
        speakers: dict[str, list[int]] = {}
        for number, group in enumerate(groups):
            for element in group.named:
                speakers.setdefault(element, []).append(number)
        own = {element: numbers[0] for element, numbers in speakers.items() if len(numbers) == 1}
        unwanted = self._unwanted(speakers, [group.kind for group in groups if group.kind])
        asked = self._task.asked.keys()
        init = frozenset(
            atom
            for atom in self._task.problem.init
            if unwanted.isdisjoint(atom.arguments)
            and (atom.predicate not in asked or len({own[a] for a in atom.arguments if a in own}) < 2)
        )
        return replace(self._task, problem=replace(self._task.problem, init=init))

    def _unwanted(self, named: Collection[str], kinds: Collection[str]) -> set[str]:
        """Movable things that the goal does not mention."""
        objects = self._task.problem.objects.items()
        movable = {o: class_ for o, class_ in objects if o not in named and self._handling.is_moved(class_)}
        return {o for o, class_ in movable.items() if not self._handling.is_one_of(class_, kinds)}

    def _effort(self, group: Group, cost: Mapping[Atom, float]) -> float:
        atoms = {atom for part in group.parts for atom in self._task.goal[part][1]}
        return sum(cost.get(atom, inf) for atom in atoms)

    def _free(self, kind: str) -> list[str]:
        taken = set[str]().union(*(share.things for share in self.shares))
        objects = self._task.problem.objects.items()
        return [o for o, class_ in objects if o not in taken and self._handling.is_one_of(class_, [kind])]

    def _nearest(self, kind: str, share: Share) -> frozenset[str]:
        """The free thing of a kind that a robot can finish soonest, if there is any."""
        free = set(self._free(kind))
        touched = ((cost, a) for atom, cost in share.cost.items() if cost > 0.0 for a in atom.arguments)
        nearest = min(((cost, thing) for cost, thing in touched if thing in free), default=None)
        return frozenset([nearest[1]]) if nearest else frozenset()


def goal_groups(task: PlanningTask) -> list[Group]:
    """Returns the conditions of the goal, those about the same things together."""
    handling = Handling(task)
    return _merged(_group(task, handling, part) for part in range(len(task.goal)))


def _group(task: PlanningTask, handling: Handling, part: int) -> Group:
    condition, atoms = task.goal[part]
    named = {*condition.arguments, *(argument for atom in atoms for argument in atom.arguments)}
    things = handling.things(named)
    if things:
        return Group((part,), things, named=frozenset(named))
    actions = (a for a in task.domain.actions if a.skill is None and not set(a.add).isdisjoint(atoms))
    kinds = (v.type for action in actions for v in action.parameters if handling.is_moved(v.type))
    return Group((part,), frozenset(), next(kinds, ""), frozenset(named))


def _merged(groups: Iterable[Group]) -> list[Group]:
    """Joins groups that have things in common."""
    found: list[Group] = []
    for group in groups:
        same = [other for other in found if other.things & group.things]
        parts = sorted({*group.parts, *(part for other in same for part in other.parts)})
        things = group.things.union(*(other.things for other in same))
        named = group.named.union(*(other.named for other in same))
        joined = Group(tuple(parts), things, group.kind, named)
        found = [other for other in found if other not in same] + [joined]
    return found


# ------------------------------------------------------------ permissions as static facts


def _narrowed(task: PlanningTask, owners: Mapping[str, frozenset[str]]) -> PlanningTask:
    """Restricts the handling of owned things to their owners."""
    handling = Handling(task)
    objects = task.problem.objects
    kinds = {objects[thing] for thing in owners}
    asking: dict[str, tuple[Atom, ...]] = {}
    for action in task.domain.actions:
        types = action.types
        variables = [v for v in handling.variables.get(action.name, ()) if _may_be(types[v], kinds, handling)]
        asking[action.name] = tuple(Atom(ASSIGNED, (handling.agents[action.name], v)) for v in variables)
    actions = tuple(replace(a, pre=(*a.pre, *asking[a.name])) if asking[a.name] else a for a in task.domain.actions)
    handled = {a.types[atom.arguments[1]] for a in actions for atom in asking[a.name]}
    able = {a.types[handling.agents[a.name]] for a in actions if asking[a.name]}
    agents = sorted(agent for agent in task.robots if agent in objects and handling.is_one_of(objects[agent], able))
    things = [o for o, class_ in objects.items() if handling.is_one_of(class_, handled)]
    facts = {Atom(ASSIGNED, (a, o)) for a in agents for o in things if o not in owners or a in owners[o]}
    return extended(task, actions, facts)


def _may_be(class_: str, kinds: Iterable[str], handling: Handling) -> bool:
    return any(handling.is_one_of(kind, [class_]) for kind in kinds)
