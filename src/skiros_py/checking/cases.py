"""Finds a test case for a skill: a world in which its preconditions hold, and parameters for it.

First the given worlds are used unchanged; then one is reached by running other skills; finally, one is generated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.checking.making import make_up, sample_values
from skiros_py.checking.rig import Rig
from skiros_py.errors import SkirosError, WorldError
from skiros_py.skills.conditions import Assign, Condition, Not, Nothing, Relate, Related, Unrelate, write_effects
from skiros_py.skills.inference import Inferred, Missing, infer
from skiros_py.skills.lint.patterns import leaves
from skiros_py.skills.lint.rules.reach import brought_about
from skiros_py.skills.parameters import Kind
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.terms import Family
from skiros_py.world.world import World

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


@dataclass(frozen=True, slots=True)
class NoCase:
    """There is no such case.

    Attributes:
        reason: What was missing.
    """

    reason: str


def find_case(
    skill: Skill,
    grounds: Sequence[Ground],
    skills: Sequence[Skill],
    rig_in: Callable[[Ground], Rig],
    *,
    may_make_up: bool = True,
) -> Case | NoCase:
    """Finds a case in which a skill can start and has an effect that the world allows; else one in which it can start.

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
            try:
                rig = rig_in(ground)
            except SkirosError as error:
                reasons.append(f"{ground.name}: {error}")
                continue
            found = way(skill, rig, ground, skills)
            if isinstance(found, NoCase):
                reasons.append(f"{ground.name}: {found.reason}")
            elif _has_work(skill.description, found):
                return found
            else:
                idle = idle or found
    return idle or NoCase("; ".join(dict.fromkeys(reasons)) or "there is no scene to try it in")


def _has_work(description: SkillDescription, case: Case) -> bool:
    posts = [condition.bind(case.arguments) for condition in description.post]
    world = case.rig.world
    with case.rig.watched():
        return not all(condition.evaluate(world) for condition in posts) and _is_allowed(posts, world)


class _TakenBackError(Exception):
    """Rolls back a transaction that only tests whether a change is allowed."""


def _is_allowed(posts: Sequence[Condition], world: World) -> bool:
    """Returns whether the world allows the postconditions: a robot cannot stand on its own deck."""
    try:
        with world.transaction("contract test", "tries effects") as tx:
            for condition in posts:
                write_effects(tx, world.ontology, brought_about(condition))
            if tx.problems():
                return False
            raise _TakenBackError
    except _TakenBackError:
        return True
    except WorldError:
        return False


def _as_it_is(skill: Skill, rig: Rig, ground: Ground, _skills: Sequence[Skill]) -> Case | NoCase:
    idle: Case | None = None
    reason = f"no subsystem can do {skill.description.name}"
    for agent, given in _beginnings(skill.description, rig, _MOST_TARGETS):
        found = _inferred(skill.description, given, rig, agent)
        if isinstance(found, Missing):
            reason = str(found)
            continue
        reason = _unmet(skill, rig, found.values)
        if not reason:
            case = Case(rig, agent, found.values, ground.name)
            if _has_work(skill.description, case):
                return case
            idle = idle or case
    return idle or NoCase(reason)


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


def _after_other_skills(skill: Skill, rig: Rig, ground: Ground, skills: Sequence[Skill]) -> Case | NoCase:
    changing = [c for c in skill.description.needs if _is_changed(c, skills)]
    if not changing:
        return NoCase("no other skill can bring it about")
    steady = _needing(skill.description, [c for c in skill.description.needs if c not in changing])
    reason = "no other skills lead there"
    for agent, given in _beginnings(steady, rig, _MOST_TARGETS // 10):
        found = _inferred(steady, given, rig, agent)
        if isinstance(found, Missing):
            reason = str(found)
            continue
        goal = [condition.bind(found.values) for condition in changing]
        simple = [condition for condition in goal if not isinstance(condition.pattern, Not | Nothing)]
        if any(rig.reach(aim) for aim in (goal, simple) if aim) and not _unmet(skill, rig, found.values):
            return Case(rig, agent, found.values, f"{ground.name}, after other skills")
    return NoCase(reason)


def _is_changed(condition: Condition, skills: Sequence[Skill]) -> bool:
    """Returns whether a skill changes anything that a condition reads."""
    words = set()
    for effect in (e for s in skills for c in s.description.post for e in brought_about(c)):
        match effect:
            case Relate(word) | Unrelate(word) | Assign(word):
                words.add(word)
    return any(_word(leaf) in words for leaf, _ in leaves(condition.pattern))


def _word(leaf: object) -> str:
    return leaf.relation if isinstance(leaf, Related | Nothing) else getattr(leaf, "property", "")


def _needing(description: SkillDescription, needs: Sequence[Condition]) -> SkillDescription:
    """Returns a skill's description with other preconditions."""
    params = tuple(replace(param, where=()) for param in description.params)
    return replace(description, params=params, pre=tuple(needs))


def _made_up(skill: Skill, rig: Rig, ground: Ground, _skills: Sequence[Skill]) -> Case | NoCase:
    reason = f"no subsystem can do {skill.description.name}"
    structural = [c for c in skill.description.needs if _is_structural(c, rig.world)]
    bare = _needing(skill.description, structural)
    for agent in rig.agents(skill.description.name):
        found = _inferred(bare, sample_values(skill.description), rig, agent)
        kept = {key: value for key, value in found.values.items() if value is not None and _is_kept(key, bare)}
        try:
            values = make_up(skill.description, rig.world, kept)
        except SkirosError as error:
            return NoCase(f"cannot be made up: {error}")
        reason = _unmet(skill, rig, values)
        if not reason:
            return Case(rig, agent, values, f"{ground.name}, made up")
    return NoCase(reason)


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


_WAYS: tuple[Callable[[Skill, Rig, Ground, Sequence[Skill]], Case | NoCase], ...] = (
    _as_it_is,
    _after_other_skills,
    _made_up,
)
"""In order of trial."""
