"""Allocates the parts of a goal to robots before planning, so that all robots get a fair share of the work.

A planner that minimizes plan length gives everything to one robot, since parallel work does not shorten the plan. So
the parts of the goal are allocated by estimated time, and static facts state which robot may handle which thing. The
resulting task is more constrained than the original: if it has no plan, the original still has to be tried.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from skiros_py.planning.domain.model import Atom
from skiros_py.planning.domain.placing import moved_and_place
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.robots.effort import efforts
from skiros_py.planning.robots.handling import Handling, columns
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import HAS_A, ROBOT

ASSIGNED = "assigned"
"""Predicate stating that an agent may handle a thing."""

_SAME = 1e-6
"""Estimates that differ by less count as equal [s]."""


@dataclass(frozen=True, slots=True)
class Share:
    """The part of a goal allocated to one robot.

    Attributes:
        robot: Its id.
        agents: Its subsystems that have skills.
        parts: Indices of the conditions of the goal.
        things: The elements that only it may handle.
        effort: The estimated time [s].
    """

    robot: str
    agents: frozenset[str]
    parts: tuple[int, ...]
    things: frozenset[str]
    effort: float


def deal(view: WorldView, task: PlanningTask) -> PlanningTask:
    """Returns the task in which each robot handles only what was allocated to it; unchanged if nothing was allocated.

    Args:
        view: The world.
        task: Any task; a single-robot task is returned unchanged.
    """
    robots = teams(view, task)
    if len(robots) < 2:
        return task
    dealt = _Dealing(view, task, robots)
    dealt.run()
    owners = dict.fromkeys(dealt.surplus, frozenset[str]())
    owners |= {thing: share.agents for share in dealt.shares for thing in share.things}
    return _narrowed(view, task, owners) if owners else task


def shares(view: WorldView, task: PlanningTask) -> tuple[Share, ...]:
    """Allocates the parts of the goal, the longest first, each to the robot that would finish all its parts soonest.

    Parts that only one robot can do go to that robot; parts that no robot can do alone are not restricted.
    """
    robots = teams(view, task)
    if len(robots) < 2:
        return ()
    dealt = _Dealing(view, task, robots)
    dealt.run()
    return dealt.shares


def teams(view: WorldView, task: PlanningTask) -> dict[str, frozenset[str]]:
    """Returns the subsystems that have skills, by robot (by their own id if they belong to none)."""
    found: dict[str, set[str]] = {}
    for agent in sorted({agent for c in task.capabilities for agent in c.agents}):
        wholes = _wholes(view, agent)
        robot = next((w for w in wholes if view.ontology.is_a(view.element(w).type, ROBOT)), agent)
        found.setdefault(robot, set()).add(agent)
    return {robot: frozenset(agents) for robot, agents in sorted(found.items())}


def _wholes(view: WorldView, element: str) -> Iterator[str]:
    yield element
    for whole in view.subjects(HAS_A, element):
        yield from _wholes(view, whole)


# ------------------------------------------------------------ deal out


@dataclass(frozen=True, slots=True)
class _Group:
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


class _Dealing:
    """The allocation of one goal's parts to robots.

    Attributes:
        surplus: Unallocated things of an open kind: others are used instead.
    """

    def __init__(self, view: WorldView, task: PlanningTask, robots: Mapping[str, frozenset[str]]) -> None:
        self.surplus: frozenset[str] = frozenset()
        self._task = task
        self._robots = robots
        self._ontology = view.ontology
        self._handling = Handling(task, view.ontology)
        alone = [self._group(part) for part in range(len(self._task.goal))]
        self._groups = [group for group in _merged(alone) if group.things or group.kind]
        self._sketch = self._sketched()
        self._costs: list[Mapping[Atom, float]] = []
        self._loads = [0.0] * len(robots)
        self._fair = 0.0
        self._parts: list[list[int]] = [[] for _ in robots]
        self._things: list[set[str]] = [set() for _ in robots]

    @property
    def shares(self) -> tuple[Share, ...]:
        """Each robot's share."""
        each = zip(self._robots.items(), self._parts, self._things, self._loads, strict=True)
        return tuple(Share(r, a, tuple(sorted(p)), frozenset(t), load) for (r, a), p, t, load in each)

    def run(self) -> None:
        """Allocates all parts."""
        for agents in self._robots.values():
            self._costs.append(efforts(self._sketch, self._ontology, agents))
        wanted = {group: [self._effort(group, cost) for cost in self._costs] for group in self._groups}
        self._fair = sum(least for efforts in wanted.values() if (least := min(efforts)) < float("inf"))
        self._fair /= len(self._robots)
        open_kinds: set[str] = set()
        for group in sorted(self._groups, key=lambda g: (not g.things, -min(wanted[g]), g.parts)):
            if 0.0 < min(wanted[group]) < float("inf") and self._give(group, wanted[group]) and group.kind:
                open_kinds.add(group.kind)
        self.surplus = frozenset(thing for kind in open_kinds for thing in self._free(kind))

    def _give(self, group: _Group, wanted: Sequence[float]) -> bool:
        places = self._places(group.things)
        loads = [load + effort for load, effort in zip(self._loads, wanted, strict=True)]
        # A robot that visits a place anyway also gets the other parts there, up to a fair share: two would block each
        # other.
        there = [bool(places & self._places(things)) for things in self._things]
        goes = [is_there and load <= self._fair + _SAME for is_there, load in zip(there, loads, strict=True)]
        robot = min(range(len(wanted)), key=lambda r: (not goes[r], loads[r], r))
        things = group.things or self._nearest(group.kind, robot)
        self._loads[robot] += wanted[robot]
        self._parts[robot] += group.parts
        self._things[robot] |= things
        return bool(things)

    def _places(self, things: Collection[str]) -> set[str]:
        """Where some things are."""
        facts = (atom for atom in self._task.problem.init if atom.predicate in self._ontology.relations)
        placed = (moved_and_place(a, self._ontology) for a in facts if self._ontology.is_placement(a.predicate))
        return {place for thing, place in placed if thing in things}

    def _group(self, part: int) -> _Group:
        condition, atoms = self._task.goal[part]
        named = {*condition.arguments, *(argument for atom in atoms for argument in atom.arguments)}
        things = self._handling.things(named)
        if things:
            return _Group((part,), things, named=frozenset(named))
        actions = (a for a in self._task.domain.actions if a.skill is None and not set(a.add).isdisjoint(atoms))
        kinds = (v.type for action in actions for v in action.parameters if self._handling.is_moved(v.type))
        return _Group((part,), frozenset(), next(kinds, ""), frozenset(named))

    def _sketched(self) -> PlanningTask:
        """The task without details that make estimates slow but hardly better.

        These are movable things not in the goal, and facts between things of different goal parts, such as that a part
        would fit into the compartment of another.
        """
        speakers: dict[str, list[int]] = {}
        for number, group in enumerate(self._groups):
            for element in group.named:
                speakers.setdefault(element, []).append(number)
        own = {element: numbers[0] for element, numbers in speakers.items() if len(numbers) == 1}
        unwanted = self._unwanted(speakers)
        asked = self._task.asked.keys()
        init = frozenset(
            atom
            for atom in self._task.problem.init
            if unwanted.isdisjoint(atom.arguments)
            and (atom.predicate not in asked or len({own[a] for a in atom.arguments if a in own}) < 2)
        )
        return replace(self._task, problem=replace(self._task.problem, init=init))

    def _unwanted(self, named: Collection[str]) -> set[str]:
        """Movable things that the goal does not mention."""
        kinds = [group.kind for group in self._groups if group.kind]
        objects = self._task.problem.objects.items()
        movable = {o: class_ for o, class_ in objects if o not in named and self._handling.is_moved(class_)}
        return {o for o, class_ in movable.items() if not self._handling.is_one_of(class_, kinds)}

    def _effort(self, group: _Group, cost: Mapping[Atom, float]) -> float:
        atoms = {atom for part in group.parts for atom in self._task.goal[part][1]}
        return sum(cost.get(atom, float("inf")) for atom in atoms)

    def _free(self, kind: str) -> list[str]:
        taken = set[str]().union(*self._things)
        objects = self._task.problem.objects.items()
        return [o for o, class_ in objects if o not in taken and self._handling.is_one_of(class_, [kind])]

    def _nearest(self, kind: str, robot: int) -> frozenset[str]:
        """The free thing of a kind that a robot can finish soonest, if there is any."""
        free = set(self._free(kind))
        touched = ((cost, a) for atom, cost in self._costs[robot].items() if cost > 0.0 for a in atom.arguments)
        nearest = min(((cost, thing) for cost, thing in touched if thing in free), default=None)
        return frozenset([nearest[1]]) if nearest else frozenset()


def _merged(groups: Iterable[_Group]) -> list[_Group]:
    """Joins groups that have things in common."""
    found: list[_Group] = []
    for group in groups:
        same = [other for other in found if other.things & group.things]
        parts = sorted({*group.parts, *(part for other in same for part in other.parts)})
        things = group.things.union(*(other.things for other in same))
        named = group.named.union(*(other.named for other in same))
        joined = _Group(tuple(parts), things, group.kind, named)
        found = [other for other in found if other not in same] + [joined]
    return found


# ------------------------------------------------------------ permissions as static facts


def _narrowed(view: WorldView, task: PlanningTask, owners: Mapping[str, frozenset[str]]) -> PlanningTask:
    """Restricts the handling of owned things to their owners."""
    handling = Handling(task, view.ontology)
    kinds = {task.problem.objects[thing] for thing in owners}
    asking: dict[str, tuple[Atom, ...]] = {}
    for action in task.domain.actions:
        types = action.types
        variables = [v for v in handling.variables.get(action.name, ()) if _may_be(types[v], kinds, handling)]
        asking[action.name] = tuple(Atom(ASSIGNED, (handling.agents[action.name], v)) for v in variables)
    actions = tuple(replace(a, pre=(*a.pre, *asking[a.name])) if asking[a.name] else a for a in task.domain.actions)
    handled = {a.types[atom.arguments[1]] for a in actions for atom in asking[a.name]}
    able = {handling.agents[a.name]: a.types[handling.agents[a.name]] for a in actions if asking[a.name]}
    known = sorted({agent for c in task.capabilities for agent in c.agents if agent in task.problem.objects})
    agents = [a for a in known if handling.is_one_of(task.problem.objects[a], able.values())]
    things = [o for o, class_ in task.problem.objects.items() if handling.is_one_of(class_, handled)]
    facts = {Atom(ASSIGNED, (a, o)) for a in agents for o in things if o not in owners or a in owners[o]}
    predicates = {**task.domain.predicates, ASSIGNED: columns(ASSIGNED, actions, task, view.ontology)}
    domain = replace(task.domain, predicates=predicates, actions=actions)
    return replace(task, domain=domain, problem=replace(task.problem, init=task.problem.init | facts))


def _may_be(class_: str, kinds: Iterable[str], handling: Handling) -> bool:
    return any(handling.is_one_of(kind, [class_]) for kind in kinds)
