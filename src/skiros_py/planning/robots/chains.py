"""Finds the independent chains of steps that a goal for several robots consists of, and who can do each of them.

The planner plans a chain for one part of the goal. Its steps, with variables for elements, are a macro-operator: what
they require of facts that no one changes, and of the thing itself, tells which robots can do the same for which other
parts of the goal. So the planner is asked once for each kind of chain, not for all of them together.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count, islice

from skiros_py.planning.domain.matching import FactIndex, solutions
from skiros_py.planning.domain.model import Atom, Grounding
from skiros_py.planning.domain.numbers import numbers_in
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.plan_validation import grounded
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import replay
from skiros_py.planning.robots.allocation import Group, Handling, goal_groups
from skiros_py.planning.robots.docking import Docking, docking_nearer
from skiros_py.planning.robots.scheduling import Operation, Scheduler, Way, makespan
from skiros_py.skills.conditions import Condition

_MOST_WAYS = 200
"""How many ways of one robot to do a chain are considered: with different things, at different docking places."""
_MOST_KINDS = 12
"""A goal with more kinds of chains is planned as a whole."""

PlanPart = Callable[[Sequence[Condition]], Plan | None]
"""Plans some conditions of the goal, as if no robot stood in the way of another; None if there is no plan."""


def shared_out(task: PlanningTask, plan_part: PlanPart, reached: Mapping[str, int], tries: int) -> Plan | None:
    """Returns a plan for all robots; None if the goal is not made of independent chains.

    Args:
        task: The task.
        plan_part: Asks the planner.
        reached: The highest sequence number that each robot has visited in this task.
        tries: How often the first schedule is changed in order to improve it.
    """
    if numbers_in(task.problem.init):  # chains that use up one number are not independent
        return None
    groups = [group for group in goal_groups(task) if not _holds(task, group)]
    if len(task.teams) < 2 or not groups or not all(group.things for group in groups):
        return None
    finder = _Finder(task)
    chains: list[list[Way]] = []
    for number, group in enumerate(groups):
        conditions = [task.goal[part][0] for part in group.parts]
        ways = finder.ways(number, conditions)
        if not ways:
            plan = plan_part(conditions) if len(finder.macros) < _MOST_KINDS else None
            ways = finder.ways(number, conditions) if plan and finder.learn(conditions, plan) else []
        if not ways:
            return None
        chains.append(ways)
    found = Scheduler(task, chains).best(tries)
    return None if found is None else _validated(task, docking_nearer(task, found.steps, reached), reached)


def arranged(task: PlanningTask, plan: Plan, reached: Mapping[str, int], tries: int) -> Plan:
    """Returns a plan with what each robot does in the order that ends soonest among those tried.

    Args:
        task: The planned task.
        plan: The steps, validated by replay, and their actions.
        reached: The highest sequence number that each robot has visited in this task.
        tries: How often the first schedule is changed in order to improve it.
    """
    steps = docking_nearer(task, plan.steps, reached)
    plan = plan if steps is plan.steps else Plan(steps, grounded(task, steps))
    chains = [[way] for way in _Finder(task).rounds(plan.steps)]
    if len({way.robot for (way,) in chains}) < 2 or numbers_in(task.problem.init):
        return plan
    found = Scheduler(task, chains).best(tries)
    other = None if found is None else _validated(task, found.steps, reached)
    if found is None or other is None:
        return plan
    return other if 0.0 < found.makespan < makespan(task, plan.steps) else plan


def _validated(task: PlanningTask, steps: tuple[Step, ...], reached: Mapping[str, int]) -> Plan | None:
    if replay(task.view, steps, task.conditions, task.skills, reached=reached) is not None:
        return None
    groundings = grounded(task, steps)
    return Plan(steps, groundings) if groundings else None


def _holds(task: PlanningTask, group: Group) -> bool:
    return all(atom in task.problem.init for part in group.parts for atom in task.goal[part][1])


class _Macro:
    """A chain with variables for its elements.

    Attributes:
        conditions: What it achieves.
        robot: The variable of the robot.
    """

    def __init__(self, conditions: Sequence[Condition], robot: str, plan: Plan, handling: Handling) -> None:
        self.conditions = conditions
        self.robot = f"?{robot}"
        self._steps = plan.steps
        acting = [one for one in plan.groundings if one.action.skill is not None]
        changing = {atom.predicate for one in acting for atom in (*one.action.add, *one.action.delete)}
        # bookkeeping comes last: its classes are those of the goal
        self._types = {f"?{e}": one.action.types[name] for one in plan.groundings for name, e in one.binding.items()}
        self.needs = [
            Atom(atom.predicate, tuple(f"?{a}" for a in atom.arguments))
            for atom in _required(acting)
            if atom.predicate not in changing or handling.moved(atom.arguments)
        ]

    def given(self, conditions: Sequence[Condition]) -> dict[str, str] | None:
        """Returns the elements for its variables in other conditions; None if it is about something else."""
        found: dict[str, str] = {}
        if len(conditions) != len(self.conditions):
            return None
        for own, other in zip(self.conditions, conditions, strict=True):
            if (own.type, own.negated) != (other.type, other.negated):
                return None
            for mine, its in zip(own.arguments, other.arguments, strict=True):
                if found.setdefault(f"?{mine}", its) != its:
                    return None
        return found

    def types(self, given: Mapping[str, str]) -> dict[str, str]:
        """Returns the classes of its variables if the goal is about other classes."""
        return {variable: given.get(f"?{class_}", class_) for variable, class_ in self._types.items()}

    def steps(self, binding: dict[str, str]) -> list[Step]:
        """Returns its steps with elements."""
        return [Step(s.skill, {k: binding.get(f"?{e}", e) for k, e in s.arguments.items()}) for s in self._steps]


def _required(acting: Sequence[Grounding]) -> list[Atom]:
    """Returns the facts that actions need and do not make themselves."""
    made: set[Atom] = set()
    needed: dict[Atom, None] = {}
    for one in acting:
        needed |= dict.fromkeys(sorted(one.of(one.action.pre) - made))
        made |= one.of(one.action.add)
    return list(needed)


class _Finder:
    """The ways to do the chains of a task."""

    def __init__(self, task: PlanningTask) -> None:
        self.macros: list[_Macro] = []
        self._task = task
        self._facts = FactIndex(sorted(task.problem.init))
        self._docking = Docking(task)
        self._handling = Handling(task)
        self._used = Counter[str]()

    def learn(self, conditions: Sequence[Condition], plan: Plan) -> bool:
        """Learns from the plan of a part; returns whether it is a chain of one robot."""
        robots = {self._docking.robot(step) for step in plan.steps}
        if len(robots) != 1 or not plan.groundings:
            return False
        self.macros.append(_Macro(conditions, robots.pop(), plan, self._handling))
        return True

    def ways(self, chain: int, conditions: Sequence[Condition]) -> list[Way]:
        """Returns the ways of all robots to do a part of the goal, if possible with things that no other part uses."""
        found = [way for macro in self.macros for way in self._ways(chain, macro, conditions)]
        if not found:
            return []
        use = {way: sum(self._used[thing] for thing in way.things) for way in found}
        best = min(found, key=lambda way: (use[way], self._docking.distance(way.robot, way.places)))
        self._used.update(best.things)
        return [way for way in found if way.things == best.things]

    def rounds(self, steps: Sequence[Step]) -> Iterator[Way]:
        """Splits a plan into chains: a robot's steps up to the last one for a thing; its moves start the next one."""
        number = count()
        for robot in dict.fromkeys(map(self._docking.robot, steps)):
            own: list[Step] = []
            last, thing = 0, None
            for step in (step for step in steps if self._docking.robot(step) == robot):
                handled = next(iter(self._handling.of(step)), None)
                if handled is not None and thing is not None and handled != thing:
                    yield self._way(next(number), robot, own[:last])
                    own = own[last:]
                own.append(step)
                if handled is not None:
                    thing, last = handled, len(own)
            yield self._way(next(number), robot, own)

    def _ways(self, chain: int, macro: _Macro, conditions: Sequence[Condition]) -> Iterator[Way]:
        given = macro.given(conditions)
        if given is None:
            return
        for robot in self._task.teams:
            start = {**given, macro.robot: robot}
            needs = [need.bind(start) for need in macro.needs]
            found = solutions(needs, self._facts, start, macro.types(given), self._task.fits)
            for binding in islice(found, _MOST_WAYS):
                yield self._way(chain, robot, macro.steps(binding))

    def _way(self, chain: int, robot: str, steps: Sequence[Step]) -> Way:
        legs: list[list[Operation]] = [[]]
        for step in steps:
            place = next((ride.place for ride in self._docking.rides([step])), "")
            legs[-1].append(Operation(step, robot, place))
            if self._handling.of(step):
                legs.append([])
        things = frozenset(thing for step in steps for thing in self._handling.of(step))
        return Way(chain, robot, tuple(tuple(leg) for leg in legs if leg), things)
