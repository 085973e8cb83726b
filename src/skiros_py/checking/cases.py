"""Finds a test case for a skill: a world in which it can start, and robots in that world.

First the given worlds are used unchanged; then one is reached by running other skills; finally, one is generated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.errors import PlanningError, SkirosError, UsageError, WorldError
from skiros_py.execution.runtime import Runtime, RuntimeOptions
from skiros_py.interruptions import CycleStep
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.process import ThreadHost
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.conditions import Condition, Has, Not, Nothing, Related
from skiros_py.skills.conditions.effects import Assign, Relate, Unrelate, brought_about, write_effects
from skiros_py.skills.conditions.pattern import NumberChange, leaves
from skiros_py.skills.inference.inferring import Inferred, Missing, infer
from skiros_py.skills.inference.search import conjuncts
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.parameters import Kind
from skiros_py.skills.parameters.values import SAMPLES, sample_of_range
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.world.element import Placement
from skiros_py.world.ids import Ids
from skiros_py.world.terms import Family
from skiros_py.world.transaction import Transaction
from skiros_py.world.vocabulary import FLOOR, ON, ROBOT, SPATIAL_THING
from skiros_py.world.world import World

_LONGEST = 600.0
"""A skill that runs longer than this is cancelled [s, simulated]."""


class Rig:
    """Runs skills and goals on the robots of a cell, supervised by its watchdog.

    Args:
        runtime: The runtime.
    """

    def __init__(self, runtime: Runtime) -> None:
        self.world = runtime.world
        self._runtime = runtime
        self._cycle = runtime.cycle
        self._managers = runtime.managers
        self._looking = CycleStep("a contract test", interruptible=True)
        questions = runtime.questions
        questions.subscribe(lambda question: questions.answer(question.id, question.options[0], by="the contract test"))

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Lets the watchdog supervise code outside the control cycle: conditions of an author.

        Raises:
            CycleOverrun: They blocked the cycle for too long.
        """
        outer = self._cycle.activity.enter(self._looking)
        try:
            yield
        finally:
            self._cycle.activity.leave(outer)

    def agents(self, skill: str) -> tuple[str, ...]:
        """Returns the subsystems that offer a skill."""
        return tuple(agent for agent, manager in sorted(self._managers.items()) if skill in manager.descriptions)

    def run(self, agent: str, skill: str, arguments: Mapping[str, Any]) -> Outcome:
        """Runs a skill to its end, or until it takes too long."""
        running = self._managers[agent].start(skill, arguments)
        deadline = self._runtime.context.now + _LONGEST
        in_time = self._runtime.finish(running, leave=lambda: self._runtime.context.now > deadline)
        if not in_time and not self._cycle.halted:
            running.stop()
            self._cycle.step()
            return Failure(f"it did not end within {_LONGEST:.0f} s")
        return running.result

    def reach(self, goal: Sequence[Condition]) -> bool:
        """Plans for a goal and executes the plan; returns whether the goal then holds."""
        with closing(FastDownward()) as planner, closing(ThreadHost(self.world, planner)) as planning:
            tasks = TaskManager(self._runtime, planning, "case")
            try:
                task = tasks.begin(goal)
                self._runtime.finish(task)
                task.result  # noqa: B018 - raises what broke it
            except (PlanningError, UsageError):
                return False
        with self.watched():
            return all(condition.evaluate(self.world) for condition in goal)


@contextmanager
def fake_rig(
    world: World,
    skills: Sequence[Skill],
    primitives: Mapping[str, type[Primitive[Any]]],
    overrun: float | None = None,
) -> Iterator[Rig]:
    """Sets up fake robots in a world.

    Args:
        world: The world.
        skills: Implementations; only those for fakes are used.
        primitives: Primitives that they call, by name.
        overrun: Wall time for which an author's code may block the cycle [s]; None for the watchdog's own limit.
    """
    spec = read_cell(world, world.instances(ROBOT), simulated=False)
    options = RuntimeOptions(overrun=overrun)
    with closing(FakeCell(spec)) as cell, Runtime(world, spec, cell, skills, primitives, options) as runtime:
        yield Rig(runtime)


def make_up(description: SkillDescription, world: World, given: Mapping[str, Any]) -> dict[str, Any]:
    """Adds an element for each element parameter not given, and makes the preconditions hold as far as possible.

    Returns:
        Value by key of every parameter.

    Raises:
        WorldError: The world does not allow it.
    """
    values: dict[str, Any] = {param.key: param.default for param in description.params} | dict(given)
    with world.transaction("contract test", f"prepares where {description.name} can start") as tx:
        for param in description.params:
            if param.is_element and values[param.key] is None and param.kind.is_required:
                stands = world.ontology.is_a(param.element_class, SPATIAL_THING)
                stands = stands and not _is_piece(param.key, description, world)
                place = Placement(ON, world.instances(FLOOR)[0]) if stands else None
                values[param.key] = tx.add(param.element_class, placement=place)
        for condition in description.needs:
            bound = condition.bind(values)
            write_effects(tx, world.ontology, brought_about(bound))
            for part in conjuncts(bound.pattern):
                if isinstance(part, Has):
                    _give(tx, part, world)
    return values


def _is_piece(key: str, description: SkillDescription, world: World) -> bool:
    """Returns whether a precondition makes it a piece of another element, so that it has no place of its own."""
    return any(
        isinstance(p, Related) and p.object == key and world.ontology.family(p.relation) is Family.STRUCTURE
        for p in (condition.pattern for condition in description.needs)
    )


def _give(tx: Transaction, wanted: Has, world: World) -> None:
    """Sets a required property of an element, unless it or its class has one."""
    value = sample_of_range(world.ontology.properties[wanted.property].range)
    if tx.view.value(wanted.subject, wanted.property) is None and value is not None:
        tx.set(wanted.subject, wanted.property, value)


# ---------------------------------------------------------------- default values


def sample_values(description: SkillDescription) -> dict[str, Any]:
    """Returns a value for each parameter that must be given and cannot be inferred."""
    return {
        param.key: SAMPLES[param.type_name] if param.length == 1 else (SAMPLES[param.type_name],) * max(1, param.length)
        for param in description.params
        if param.kind is Kind.ONLINE and not param.is_element and param.type in SAMPLES
    }


_MOST_TARGETS = 30
"""Maximum number of elements tried as the target of a skill; in plans, which take longer, a tenth of that."""


@dataclass(frozen=True, slots=True)
class Ground:
    """A world from which trials may start.

    Attributes:
        name: Its name ("kitting").
        open: Creates a fresh copy for each trial.
    """

    name: str
    open: Callable[[], World]


@dataclass(frozen=True, slots=True)
class Case:
    """A state in which a skill can start.

    Attributes:
        rig: The robots, in the required world.
        agent: The subsystem that executes it.
        arguments: Value by key of every parameter.
        where: The world and how it was reached, for people ("kitting", "kitting, after other skills").
    """

    rig: Rig
    agent: str
    arguments: Mapping[str, Any]
    where: str


def find_case(
    skill: Skill,
    grounds: Sequence[Ground],
    skills: Sequence[Skill],
    rig_in: Callable[[Ground], Rig],
    *,
    may_make_up: bool = True,
) -> Case | str:
    """Finds a case in which a skill can start and has an effect that the world allows; else one in which it can start.

    Where there is none, it returns what was missing.

    Args:
        skill: The implementation.
        grounds: Worlds to try it in, in that order.
        skills: Skills that may achieve its preconditions, and the skill itself.
        rig_in: Sets up robots.
        may_make_up: Whether a world may be generated if there is none; impossible with simulated bodies.

    Raises:
        CycleOverrun: A condition blocks the cycle for too long.
    """
    reasons: list[str] = []
    idle: Case | None = None
    for way in _WAYS if may_make_up else _WAYS[:-1]:
        for ground in grounds:
            reason = f"no subsystem can do {skill.description.name}"
            try:
                rig = rig_in(ground)
            except SkirosError as error:
                reasons.append(f"{ground.name}: {error}")
                continue
            for found in way(skill, rig, ground, skills):
                if isinstance(found, str):
                    reason = found
                elif _has_work(skill.description, found):
                    return found
                else:
                    idle, reason = idle or found, ""
            if reason:
                reasons.append(f"{ground.name}: {reason}")
    return idle or "; ".join(dict.fromkeys(reasons)) or "there is no scene to try it in"


def _has_work(description: SkillDescription, case: Case) -> bool:
    posts = [condition.bind(case.arguments) for condition in description.post]
    world = case.rig.world
    with case.rig.watched():
        return not all(condition.evaluate(world) for condition in posts) and _is_allowed(posts, world)


def _is_allowed(posts: Sequence[Condition], world: World) -> bool:
    """Returns whether the world allows the postconditions: a robot cannot stand on its own deck."""
    tried = Transaction(world.snapshot(), Ids())
    try:
        for condition in posts:
            write_effects(tried, world.ontology, brought_about(condition))
    except WorldError:
        return False
    return not tried.problems()


def _as_it_is(skill: Skill, rig: Rig, ground: Ground, _skills: Sequence[Skill]) -> Iterator[Case | str]:
    for agent, given in _beginnings(skill.description, rig, _MOST_TARGETS):
        found = _inferred(skill.description, given, rig, agent)
        if isinstance(found, Missing):
            yield str(found)
        else:
            yield _unmet(skill, rig, found.values) or Case(rig, agent, found.values, ground.name)


def _beginnings(description: SkillDescription, rig: Rig, most: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yields agents with values that cannot be inferred, without a target and with each."""
    values = sample_values(description)
    target = description.param(description.target)
    targets = rig.world.instances(target.element_class)[:most] if target.is_element else ()
    for agent in rig.agents(description.name):
        yield agent, values
        if description.target != description.agent:
            yield from ((agent, {**values, description.target: one}) for one in targets)


def _inferred(description: SkillDescription, given: Mapping[str, Any], rig: Rig, agent: str) -> Inferred | Missing:
    with rig.watched():
        return infer(description, given, rig.world, agent)


def _unmet(skill: Skill, rig: Rig, values: Mapping[str, Any]) -> str:
    """Returns the first condition that does not hold, with the reason; empty if the skill can start."""
    for condition in (*skill.description.needs, *skill.when, *skill.description.hold):
        with rig.watched():
            verdict = condition.evaluate(rig.world, values)
        if not verdict:
            return "; ".join(line.strip() for line in verdict.lines())
    return ""


def _after_other_skills(skill: Skill, rig: Rig, ground: Ground, skills: Sequence[Skill]) -> Iterator[Case | str]:
    changing = [c for c in skill.description.needs if _is_changed(c, skills)]
    yield "no other skills lead there" if changing else "no other skill can bring it about"
    if not changing:
        return
    steady = [c for c in skill.description.needs if c not in changing]
    for agent, given in _beginnings(_needing(skill.description, steady), rig, _MOST_TARGETS // 10):
        kept, found = steady, _inferred(_needing(skill.description, steady), given, rig, agent)
        for condition in changing:  # as much of what is needed as holds already
            nearer = _inferred(_needing(skill.description, [*kept, condition]), given, rig, agent)
            if not isinstance(nearer, Missing):
                kept, found = [*kept, condition], nearer
        if isinstance(found, Missing):
            yield str(found)
            continue
        goal = [condition.bind(found.values) for condition in changing]
        simple = [condition for condition in goal if not isinstance(condition.pattern, Not | Nothing)]
        if any(rig.reach(aim) for aim in (goal, simple) if aim) and not _unmet(skill, rig, found.values):
            yield Case(rig, agent, found.values, f"{ground.name}, after other skills")
            return


def _is_changed(condition: Condition, skills: Sequence[Skill]) -> bool:
    """Returns whether a skill changes anything that a condition reads."""
    words = set()
    for effect in (e for s in skills for c in s.description.post for e in brought_about(c)):
        match effect:
            case Relate(word) | Unrelate(word) | Assign(word) | NumberChange(word):
                words.add(word)
    return any(_word(leaf) in words for leaf, _ in leaves(condition.pattern))


def _word(leaf: object) -> str:
    return leaf.relation if isinstance(leaf, Related | Nothing) else getattr(leaf, "property", "")


def _needing(description: SkillDescription, needs: Sequence[Condition]) -> SkillDescription:
    """Returns a skill's description with other preconditions."""
    params = tuple(replace(param, where=()) for param in description.params)
    return replace(description, params=params, pre=tuple(needs))


def _made_up(skill: Skill, rig: Rig, ground: Ground, _skills: Sequence[Skill]) -> Iterator[Case | str]:
    structural = [c for c in skill.description.needs if _is_structural(c, rig.world)]
    bare = _needing(skill.description, structural)
    for agent in rig.agents(skill.description.name):
        found = _inferred(bare, sample_values(skill.description), rig, agent)
        kept = {key: value for key, value in found.values.items() if value is not None and _is_kept(key, bare)}
        try:
            values = make_up(skill.description, rig.world, kept)
        except SkirosError as error:
            yield f"cannot be made up: {error}"
            return
        if reason := _unmet(skill, rig, values):
            yield reason
        else:
            yield Case(rig, agent, values, f"{ground.name}, made up")
            return


def _is_kept(key: str, description: SkillDescription) -> bool:
    """Returns whether a value is kept when a world is generated: the robot's parts, and values other than elements."""
    param = description.param(key)
    return param.kind in (Kind.HARDWARE, Kind.PLANNING) or key == description.agent or not param.is_element


def _is_structural(condition: Condition, world: World) -> bool:
    return all(
        isinstance(leaf, Related)
        and leaf.relation in world.ontology.relations
        and world.ontology.family(leaf.relation) is Family.STRUCTURE
        for leaf, _ in leaves(condition.pattern)
    )


_WAYS = (_as_it_is, _after_other_skills, _made_up)
"""In order of trial; each yields cases, or reasons why there is none."""
