"""Contract tests: a run of a skill must have its declared effects and no others, on a fake and in physics."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from skiros_py.catalogue import Catalogue
from skiros_py.checking.cases import Case, Ground, Rig, fake_rig, find_case
from skiros_py.execution.module_faults import words
from skiros_py.interruptions import CycleOverrun, by_user
from skiros_py.skills.conditions import Condition, Not, Nothing
from skiros_py.skills.conditions.effects import Assign, Effect, Relate, Unrelate, brought_about
from skiros_py.skills.conditions.pattern import NumberChange, number_of
from skiros_py.skills.lint.checking import EFFECT_MISSING, NEVER_TRIED, UNDECLARED_CHANGE
from skiros_py.skills.lint.rule import Finding, Rule, Spot, title
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.station.judgement import judge
from skiros_py.station.session import Options, Session
from skiros_py.station.worlds import open_world
from skiros_py.system import default_simulation
from skiros_py.world.change import Edit, ElementEdit, PlacementEdit, PropertyEdit, RelationEdit
from skiros_py.world.element import Placement
from skiros_py.world.index import Index
from skiros_py.world.scene.files import describe, diff
from skiros_py.world.view import pieces
from skiros_py.world.vocabulary import MISSED_LOOKS, MISSING, POSE, POSE_FRAME

_OF_MOVED = frozenset({POSE, MISSING, MISSED_LOOKS})
"""Properties for the location of an element, which change when it is moved."""


def undeclared(before: Index, after: Index, posts: Sequence[Condition]) -> Iterator[str]:
    """Yields a line for each change between two states that no postcondition declares.

    Implied changes are not reported: a moved element leaves its old place, its pose and the poses of its parts change,
    and the previous object of a functional relation is removed.

    Args:
        before: The world before the run.
        after: The world after it.
        posts: The postconditions, over elements.
    """
    declared = _Declared(after, posts)
    for edit in diff(before, after):
        is_new_or_gone = not isinstance(edit, ElementEdit) and any(
            not (before.has(name) and after.has(name)) for name in edit.marks()
        )
        if not is_new_or_gone and not declared.covers(edit):
            yield from describe([edit])


class _Declared:
    def __init__(self, world: Index, posts: Sequence[Condition]) -> None:
        self._ontology = world.ontology
        self._effects = [effect for condition in posts for effect in brought_about(condition)]
        moved = {
            world.ontology.placed(effect.subject, effect.relation, effect.object)[0]
            for effect in self._effects
            if isinstance(effect, Relate) and world.ontology.is_placement(effect.relation)
        }
        self._moved = moved | {part for name in moved if world.has(name) for part in pieces(world, name)}
        self._emptied = {(p.relation, p.object) for p in (c.pattern for c in posts) if isinstance(p, Nothing)}
        filled = [c.pattern.pattern for c in posts if isinstance(c.pattern, Not)]
        self._filled = {(p.relation, p.object) for p in filled if isinstance(p, Nothing)}

    def covers(self, edit: Edit) -> bool:
        """Returns whether an edit is implied or declared."""
        match edit:
            case PlacementEdit(element, old, new):
                return element in self._moved or _is_at(old, self._emptied) or _is_at(new, self._filled)
            case RelationEdit(subject, relation, object_):
                of_moved = relation == POSE_FRAME and subject in self._moved
                return of_moved or any(self._is_said(e, subject, relation, object_, edit.new) for e in self._effects)
            case PropertyEdit(element, property_):
                if element in self._moved and property_ in _OF_MOVED:
                    return True
                valued = [(e.subject, e.property) for e in self._effects if isinstance(e, Assign | NumberChange)]
                return (element, property_) in valued
            case _:
                return False

    def _is_said(self, effect: Effect, subject: str, relation: str, object_: str, holds: bool) -> bool:
        match effect:
            case Relate(said, start, end) if holds:
                return (start, end) == (subject, object_) and relation in self._ontology.sub_relations(said)
            case Relate(said, start, end) if said == relation:  # replaces the previous object
                declared = self._ontology.relation(said)
                return (declared.functional and start == subject) or (declared.inverse_functional and end == object_)
            case Unrelate(said, start, end) if not holds:
                return (start, end) == (subject, object_) and relation in self._ontology.sub_relations(said)
            case _:
                return False


def _is_at(placement: Placement | None, places: Collection[tuple[str, str]]) -> bool:
    return placement is not None and (placement.relation, placement.place) in places


@dataclass(frozen=True, slots=True)
class Contract:
    """The result of the contract test of one implementation of a skill.

    Attributes:
        skill: The implementation.
        findings: Missing effects, undeclared changes, or the reason why it could not be tried.
        where: The world in which it ran; empty if it did not.
        arguments: Its parameters.
        outcome: Its outcome; None if it was never tried.
    """

    skill: Skill
    findings: tuple[Finding, ...]
    where: str = ""
    arguments: Mapping[str, Any] | None = None
    outcome: Outcome | None = None


def is_testable(skill: Skill) -> bool:
    """Returns whether a skill can be run by a contract test: only those for fakes."""
    return skill.driver == "fake"


def check_contract(
    skill: Skill,
    grounds: Sequence[Ground],
    skills: Sequence[Skill] = (),
    primitives: Mapping[str, type[Primitive[Any]]] | None = None,
    spot: Spot | None = None,
    *,
    overrun: float | None = None,
) -> Contract:
    """Runs a skill where its preconditions hold, and compares the changes of the world with its declarations.

    Args:
        skill: The implementation; one for the fake driver.
        grounds: Worlds to try it in, in that order.
        skills: Other skills that it may call, or that may prepare its start.
        primitives: Primitives that any of them calls, by name.
        spot: Its location in the source.
        overrun: Wall time for which an author's code may block the cycle [s]; None for the watchdog's own limit.
    """
    all_ = [*(s for s in skills if s.description.name != skill.description.name and is_testable(s)), skill]

    def rig_in(stack: ExitStack, ground: Ground) -> Rig:
        return stack.enter_context(fake_rig(ground.open(), all_, primitives or {}, overrun))

    def faults(case: Case, before: Index, _outcome: Outcome) -> Iterator[tuple[Rule, str]]:
        posts = [condition.bind(case.arguments) for condition in skill.description.post]
        for line in undeclared(before, case.rig.world.snapshot(), posts):
            yield UNDECLARED_CHANGE, f"no postcondition declares {line}"
        for change in (effect for post in posts for effect in brought_about(post) if isinstance(effect, NumberChange)):
            old, new = (number_of(view, change.subject, change.property) for view in (before, case.rig.world))
            if old is not None and new is not None and (new - old) * change.sign <= 0.0:
                yield EFFECT_MISSING, f"{change.property} of {change.subject} was {old:g} and is {new:g}"

    return _contract(skill, spot, partial(find_case, skill, grounds, all_), rig_in, faults)


def _contract(
    skill: Skill,
    spot: Spot | None,
    find: Callable[[Callable[[Ground], Rig]], Case | str],
    rig_in: Callable[[ExitStack, Ground], Rig],
    faults: Callable[[Case, Index, Outcome], Iterator[tuple[Rule, str]]],
) -> Contract:
    """Finds a case for a skill, runs it, and reports missing effects and further faults.

    Exceptions from an author's conditions and primitives become findings.
    """

    def finding(rule: Rule, text: str) -> Finding:
        return Finding(rule.name, rule.severity, title(skill), text, spot)

    try:
        with ExitStack() as stack:
            case = find(partial(rig_in, stack))
            if isinstance(case, str):
                return Contract(skill, (finding(NEVER_TRIED, f"no world was found in which it can start: {case}"),))
            before = case.rig.world.snapshot()
            outcome = case.rig.run(case.agent, skill.description.name, case.arguments)
            with case.rig.watched():
                missing = ((EFFECT_MISSING, text) for text in _missing_effects(skill, case, outcome))
                texts = [(rule, f"{text} ({case.where})") for rule, text in (*missing, *faults(case, before, outcome))]
            findings = tuple(finding(rule, text) for rule, text in texts)
            return Contract(skill, findings, case.where, case.arguments, outcome)
    except BaseException as error:  # an author's code: it must not end the other trials
        if by_user(error):
            raise
        why = f"a condition {error}" if isinstance(error, CycleOverrun) else words(error)
        return Contract(skill, (finding(EFFECT_MISSING, f"it could not be tried: {why}"),))


def _missing_effects(skill: Skill, case: Case, outcome: Outcome) -> Iterator[str]:
    """Yields the postconditions that do not hold after a run, with the reasons."""
    ended = f"; it failed: {outcome.reason}" if isinstance(outcome, Failure) else ""
    for condition in skill.description.post:
        verdict = condition.bind(case.arguments).evaluate(case.rig.world)
        if not verdict:
            why = "; ".join(line.strip() for line in verdict.lines()[1:])
            yield f"{condition.bind(case.arguments)} did not happen: {why}{ended}"


def is_simulable(skill: Skill) -> bool:
    """Returns whether a skill can be run in the simulation: only those for every robot."""
    return skill.driver in (None, default_simulation())


def check_simulated(skill: Skill, scene: str, catalogue: Catalogue, spot: Spot | None = None) -> Contract:
    """Runs a skill in physics, in a reachable state, and compares its effects with the ground truth.

    Other changes of the world are ignored, because a robot with cameras updates its beliefs wherever it goes.

    Args:
        skill: The implementation.
        scene: Name or path of the scene.
        catalogue: Everything installed.
        spot: Its location in the source.
    """
    others = {key: one for key, one in catalogue.skills.items() if one.description.name != skill.description.name}
    own = next((key for key, one in catalogue.skills.items() if one == skill), skill.description.name)
    alone = replace(catalogue, skills={**others, own: skill})
    simulable = [one for one in alone.skills.values() if is_simulable(one)]
    sessions: list[Session] = []

    def rig_in(stack: ExitStack, _ground: Ground) -> Rig:
        sessions.append(stack.enter_context(Session(scene, Options(), catalogue=alone)))
        return Rig(sessions[-1].runtime)

    def find(rigs: Callable[[Ground], Rig]) -> Case | str:
        found = find_case(skill, [Ground(scene, lambda: open_world(scene))], simulable, rigs, may_make_up=False)
        return replace(found, where=f"{found.where}, simulated") if isinstance(found, Case) else found

    def untrue(case: Case, _before: Index, outcome: Outcome) -> Iterator[tuple[Rule, str]]:
        """Yields the postconditions that the robot believes but that do not hold in the simulator."""
        session = next(one for one in sessions if one.world is case.rig.world)
        posts = [condition.bind(case.arguments) for condition in skill.description.post]
        for condition, truth in zip(posts, judge(session.simulation, session.spec, session.world, posts), strict=True):
            if truth is False and condition.evaluate(session.world):
                yield EFFECT_MISSING, f"{condition} is believed, and is not so: it ended with {outcome}"

    return _contract(skill, spot, find, rig_in, untrue)
