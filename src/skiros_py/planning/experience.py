"""What robots learned from running skills: how long they take, and how often they succeed; the costs of actions.

Each attempt counts for its skill, robot, place and type of part. The records are elements of learned concepts: they
persist with the world, are journalled, and can be inspected and deleted like all taught data.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from math import prod

from skiros_py.messages import Message
from skiros_py.planning.domain.actions import required_elements
from skiros_py.planning.domain.model import Action, Estimate
from skiros_py.planning.problem.reachability import USUAL
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.skills.skill import SkillDescription
from skiros_py.skills.surroundings import robot_of
from skiros_py.world.element import Element, Value
from skiros_py.world.ontology import Ontology
from skiros_py.world.transaction import Transaction
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import (
    APPLIES_TO,
    AT_PLACE,
    FAILED_TIMES,
    FAILURES,
    LEARNED_DURATION,
    LOCATION,
    MANIPULATABLE,
    OF_ROBOT,
    OF_SKILL,
    PART_TYPE,
    RUN_TIMES,
    SUCCESSES,
)
from skiros_py.world.world import World

KEPT = 15
"""How many recent times are kept per record; their median is robust against single delays."""
FORGETTING = 0.95
"""What earlier attempts count for after a further one: as many as 20 attempts count at most."""
EXPECTED = 0.95
"""Success rate of a skill that was never tried."""
WEIGHT = 2.0
"""How many attempts the more general success rate counts for: of a skill never tried, then of the robot, ..."""
_LEAST = 0.02
"""No success rate is estimated below this: expected times stay finite."""


@dataclass(frozen=True, slots=True)
class Case:
    """What an attempt counts for.

    Attributes:
        skill: Name of the skill.
        robot: Id of the robot; empty for records of earlier versions, which count for all of a class.
        agent_class: Most specific class of the subsystem that runs it.
        place: Id of the place where it is done; empty if it has none.
        kind: Class of the part it is done with; empty if it has none.
    """

    skill: str
    robot: str
    agent_class: str
    place: str = ""
    kind: str = ""


@dataclass(slots=True)
class Tally:
    """Attempts of one or several cases.

    Attributes:
        successes, failures: How many, with forgetting.
        times, failed: Durations of the last successful and failed ones [s].
    """

    successes: float = 0.0
    failures: float = 0.0
    times: tuple[float, ...] = ()
    failed: tuple[float, ...] = ()

    @property
    def usual(self) -> float | None:
        """How long a successful attempt takes [s]; None if unknown."""
        return _median(self.times)

    @property
    def lost(self) -> float | None:
        """How long a failed attempt takes [s]; None if unknown."""
        return _median(self.failed)

    def after(self, seconds: float, *, is_success: bool) -> Tally:
        """Returns the tally after a further attempt."""
        successes, failures = FORGETTING * self.successes, FORGETTING * self.failures
        if is_success:
            return Tally(successes + 1.0, failures, (*self.times, seconds)[-KEPT:], self.failed)
        return Tally(successes, failures + 1.0, self.times, (*self.failed, seconds)[-KEPT:])


@dataclass(eq=False)
class Pool:
    """The records of several cases, as they are stored, read as far as they are needed."""

    said: list[Mapping[str, Value]]

    @cached_property
    def successes(self) -> float:
        """How many attempts succeeded."""
        return sum(_number(one.get(SUCCESSES), one.get(RUN_TIMES)) for one in self.said)

    @cached_property
    def failures(self) -> float:
        """How many failed."""
        return sum(_number(one.get(FAILURES), ()) for one in self.said)

    @cached_property
    def times(self) -> tuple[float, ...]:
        """Durations of the last successful ones [s]."""
        return tuple(chain.from_iterable(_times(one.get(RUN_TIMES)) for one in self.said))

    @cached_property
    def failed(self) -> tuple[float, ...]:
        """Durations of the last failed ones [s]."""
        return tuple(chain.from_iterable(_times(one.get(FAILED_TIMES)) for one in self.said))

    @cached_property
    def usual(self) -> float | None:
        """How long a successful attempt takes [s]; None if unknown."""
        return _median(self.times)

    @cached_property
    def lost(self) -> float | None:
        """How long a failed attempt takes [s]; None if unknown."""
        return _median(self.failed)


def _times(value: Value | None) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else ()


def _number(value: Value | None, times: object) -> float:
    """Returns a count; that of the times in records of earlier versions."""
    if isinstance(value, (int, float)):
        return float(value)
    return float(len(times)) if isinstance(times, tuple) else 0.0


def estimated(tallies: Sequence[Tally | Pool], declared: float | None) -> Estimate | None:
    """Estimates duration and success rate from attempts.

    Args:
        tallies: Attempts, from all that are comparable to the very same case. The success rate of each is the mean of
            a Beta distribution around that of the one before; durations are those of the last that has any.
        declared: The duration as declared by the author [s].

    Returns:
        The estimate; None if there is nothing to estimate a duration from.
    """
    rate = EXPECTED
    for tally in tallies:
        rate = (WEIGHT * rate + tally.successes) / (WEIGHT + tally.successes + tally.failures)
    seconds = next((tally.usual for tally in reversed(tallies) if tally.usual is not None), None)
    lost = next((tally.lost for tally in reversed(tallies) if tally.lost is not None), None)
    seconds = declared if seconds is None else seconds
    if seconds is None:
        seconds = lost
    if seconds is None:
        return None
    rate = max(rate, _LEAST)
    return Estimate(seconds + (1.0 / rate - 1.0) * (seconds if lost is None else lost), rate)


def _median(times: tuple[float, ...]) -> float | None:
    return statistics.median(times) if times else None


class Experience:
    """All records of a world, read once.

    Args:
        view: The world.
    """

    def __init__(self, view: WorldView) -> None:
        self._view = view
        self._records: dict[str, list[Element]] = {}
        for element in records(view):
            self._records.setdefault(str(element.properties.get(OF_SKILL)), []).append(element)
        self._pools: dict[str, dict[tuple[str, ...], Pool]] = {}

    def __contains__(self, skill: str) -> bool:
        """Whether anything is known about a skill."""
        return skill in self._records

    def of(self, case: Case, declared: float | None) -> Estimate | None:
        """Estimates duration and success rate of a case; None if the duration is unknown.

        Args:
            case: The case.
            declared: Duration as declared by the author [s].
        """
        known = self._of_skill(case.skill)
        return estimated([known[level] for level in _levels(case) if level in known], declared)

    def _of_skill(self, skill: str) -> dict[tuple[str, ...], Pool]:
        """Returns the records of a skill by what they count for; they are grouped when first needed."""
        if skill not in self._pools:
            found = self._pools[skill] = {}
            for element in self._records.get(skill, ()):
                said = element.properties
                class_, robot = str(said.get(APPLIES_TO, "")), str(said.get(OF_ROBOT, ""))
                levels: Iterable[tuple[str, ...]] = ((skill, class_),)
                if robot and self._view.has(robot):  # of others, only what they have in common is ever asked for
                    levels = _levels(read_case(element))
                for level in levels:
                    pool = found.get(level)
                    if pool is None:
                        pool = found[level] = Pool([])
                    pool.said.append(said)
        return self._pools[skill]


def _levels(case: Case) -> Iterator[tuple[str, ...]]:
    """Yields what a case counts for, from the most general to the most specific."""
    yield case.skill, case.agent_class
    if case.robot:
        yield case.skill, case.agent_class, case.robot
        if case.place:
            yield case.skill, case.agent_class, case.robot, case.place, ""
        if case.kind:
            yield case.skill, case.agent_class, case.robot, "", case.kind
        if case.place and case.kind:
            yield case.skill, case.agent_class, case.robot, case.place, case.kind


# ---------------------------------------------------------------- records


def records(view: WorldView, **of: str) -> list[Element]:
    """Returns the learned records.

    Args:
        view: The world.
        **of: What they must be of: ``skill``, ``robot``, ``place``, ``kind``; empty for any.
    """
    if LEARNED_DURATION not in view.ontology.classes:
        return []
    found = (view.element(name) for name in view.abstracts(LEARNED_DURATION))
    wanted = [(_FIELDS[name], value) for name, value in of.items() if value]
    return [element for element in found if all(element.properties.get(name) == value for name, value in wanted)]


_FIELDS = {"skill": OF_SKILL, "robot": OF_ROBOT, "agent_class": APPLIES_TO, "place": AT_PLACE, "kind": PART_TYPE}


def read_case(element: Element) -> Case:
    """Returns what a record is of."""
    said = element.properties
    return Case(*(str(said.get(property_, "")) for property_ in _FIELDS.values()))


def read_tally(element: Element) -> Tally:
    """Returns the attempts of a record."""
    pool = Pool([element.properties])
    return Tally(pool.successes, pool.failures, pool.times, pool.failed)


def forget(tx: Transaction, view: WorldView, **of: str) -> int:
    """Deletes learned records; returns how many.

    Args:
        tx: An open transaction of the world.
        view: The world.
        **of: What they must be of, as in :func:`records`; all are deleted if nothing is given.
    """
    gone = records(view, **of)
    for element in gone:
        tx.remove(element.id)
    return len(gone)


def observe(
    world: World,
    skill: SkillDescription,
    agent: str,
    arguments: Mapping[str, str],
    seconds: float,
    *,
    is_success: bool = True,
    known: dict[Case, str] | None = None,
) -> None:
    """Learns from an attempt; ignores those that took no time, or whose agent is gone.

    Args:
        world: Stores what was learned.
        skill: The skill.
        agent: Id of the subsystem that ran it.
        arguments: Element id by parameter key.
        seconds: How long it took [s].
        is_success: Whether it succeeded.
        known: Ids of records that were found before, which is faster than looking for them; it is updated.
    """
    if seconds <= 0.0 or not world.has(agent):
        return
    classes = {key: world.element(name).type for key, name in arguments.items() if world.has(name)}
    place, part = place_and_part(skill, world.ontology)
    case = Case(
        skill.name,
        robot_of(world, agent),
        world.element(agent).type,
        arguments[place] if place in classes else "",
        classes.get(part, ""),
    )
    own = {name: getattr(case, name) for name in _FIELDS}
    ids = {} if known is None else known
    if case in ids and world.has(ids[case]):
        record: Element | None = world.element(ids[case])
    else:
        record = next((e for e in records(world, **own) if read_case(e) == case), None)
    tally = (Tally() if record is None else read_tally(record)).after(seconds, is_success=is_success)
    learned: dict[str, Value] = {SUCCESSES: tally.successes, FAILURES: tally.failures}
    learned |= {RUN_TIMES: tally.times} if tally.times else {}
    learned |= {FAILED_TIMES: tally.failed} if tally.failed else {}
    reason = Message("{skill} failed after {seconds:.2f} s", skill=skill.name, seconds=seconds)
    if is_success:
        reason = Message("{skill} took {seconds:.2f} s", skill=skill.name, seconds=seconds)
    with world.transaction(author="task manager", reason=reason) as tx:
        if record is None:
            said: dict[str, Value] = {_FIELDS[name]: value for name, value in own.items() if value}
            label = " ".join(filter(None, (case.skill, "by", case.robot, case.kind, case.place and f"at {case.place}")))
            ids[case] = tx.add(LEARNED_DURATION, label, None, said | learned, learned=True)
        else:
            ids[case] = record.id
            for name, value in learned.items():
                tx.set(record.id, name, value)


def place_and_part(skill: SkillDescription, ontology: Ontology) -> tuple[str, str]:
    """Returns the keys of the place where a skill is done and of the part it is done with; empty for none.

    The target comes first, then the other parameters in their order.
    """
    found = {LOCATION: "", MANIPULATABLE: ""}
    for param in sorted(required_elements(skill), key=lambda one: one.key != skill.target):
        for class_, key in found.items():
            known = param.element_class in ontology.classes
            if not key and known and param.key != skill.agent and ontology.is_a(param.element_class, class_):
                found[class_] = param.key
    return found[LOCATION], found[MANIPULATABLE]


# ---------------------------------------------------------------- costs of actions


@dataclass(frozen=True, slots=True)
class Costs:
    """What is known about the costs of an action.

    Attributes:
        about: The variables that they depend on: agent, place, part; empty for none.
        of: Estimates the costs for elements.
    """

    about: tuple[str, str, str]
    of: Callable[[str, str, str], Estimate | None] = field(repr=False)

    def __call__(self, binding: Mapping[str, str]) -> Estimate | None:
        """Estimates the costs for the elements of a binding."""
        agent, place, part = (binding.get(variable, "") for variable in self.about)
        return self.of(agent, place, part)

    def __reduce__(self) -> tuple[type[None], tuple[()]]:
        """Costs stay in the process that plans."""
        return type(None), ()


def timed(task: PlanningTask, experience: Experience | None = None) -> PlanningTask:
    """Returns the task with the durations of its actions, and their costs where something was learned.

    Args:
        task: The task.
        experience: What was learned; read from the world of the task if omitted.
    """
    known = Experience(task.view) if experience is None else experience
    skills = {c.skill.name: (_slowest(task.view, known, c.skill, c.agents), _costs(task, known, c.skill))
              for c in task.capabilities}  # fmt: skip
    actions = (
        replace(a, duration=skills[a.skill][0], costs=skills[a.skill][1]) if a.skill in skills else a
        for a in task.domain.actions
    )
    return replace(task, domain=replace(task.domain, actions=tuple(actions)))


def _slowest(view: WorldView, known: Experience, skill: SkillDescription, agents: tuple[str, ...]) -> float | None:
    classes = sorted({view.element(agent).type for agent in agents if view.has(agent)}) if skill.name in known else ()
    found = (known.of(Case(skill.name, "", class_), skill.duration) for class_ in classes)
    return max((one.seconds for one in found if one is not None), default=skill.duration)


def _costs(task: PlanningTask, known: Experience, skill: SkillDescription) -> Costs | None:
    if skill.name not in known:
        return None
    place, part = place_and_part(skill, task.view.ontology)
    objects, found = task.problem.objects, dict[tuple[str, str, str], Estimate | None]()

    def of(agent: str, place: str, part: str) -> Estimate | None:
        key = agent, place, objects.get(part, "")
        if key not in found:
            robot = task.robots.get(agent, agent)
            case = Case(skill.name, robot, objects.get(agent, ""), place, key[2])
            found[key] = known.of(case, skill.duration)
        return found[key]

    return Costs((f"?{skill.agent}", f"?{place}", f"?{part}"), of)


MOST = 2_000
"""Up to so many costs of an action are written for a planner; if there are more, they depend on fewer parameters."""


def cost_table(task: PlanningTask, action: Action) -> tuple[tuple[str, ...], dict[tuple[str, ...], float]] | None:
    """Returns the variables that the costs of an action depend on, and the costs by their elements [s].

    Returns:
        None if nothing was learned, or nothing that differs.
    """
    if action.costs is None:
        return None
    types = {v.name: v.type for v in action.parameters}
    objects = task.problem.objects
    fitting = {v: [o for o in objects if task.fits(o, types[v])] for v in action.costs.about if v in types}
    while prod(map(len, fitting.values())) > MOST:
        fitting.popitem()
    costs: dict[tuple[str, ...], float] = {(): 0.0}
    for names in fitting.values():
        costs = {(*key, name): 0.0 for key in costs for name in names}
    for key in costs:
        estimate = action.costs(dict(zip(fitting, key, strict=True)))
        costs[key] = USUAL if estimate is None else estimate.seconds
    return (tuple(fitting), costs) if len(set(costs.values())) > 1 else None
