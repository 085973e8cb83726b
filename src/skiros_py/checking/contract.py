"""Contract tests: what a skill declares must happen when it runs, and nothing else."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from skiros_py.checking.cases import Case, Ground, NoCase, find_case
from skiros_py.checking.difference import undeclared
from skiros_py.skills.lint import EFFECT_MISSING, NEVER_TRIED, UNDECLARED_CHANGE, Finding, Rule, Spot, title
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.world.index import Index

__all__ = ["Contract", "check_contract", "is_testable"]


@dataclass(frozen=True, slots=True)
class Contract:
    """What came of the contract test of one implementation of a skill.

    Attributes:
        skill: The implementation.
        findings: Effects that did not happen, changes that are not declared, or that it could not be tried.
        where: The world in which it ran; empty where it did not.
        arguments: Its parameters.
        outcome: How it ended; None where it was never tried.
    """

    skill: Skill
    findings: tuple[Finding, ...]
    where: str = ""
    arguments: Mapping[str, Any] | None = None
    outcome: Outcome | None = None


def is_testable(skill: Skill) -> bool:
    """Tells whether a skill can be run by a contract test: those for fakes are."""
    return skill.driver == "fake"


def check_contract(
    skill: Skill,
    grounds: Sequence[Ground],
    skills: Sequence[Skill] = (),
    primitives: Mapping[str, type[Primitive[Any]]] | None = None,
    spot: Spot | None = None,
) -> Contract:
    """Runs a skill where its preconditions hold, and compares the world before and after with what it declares.

    Args:
        skill: The implementation; one for the fake driver.
        grounds: Worlds to try it in, in that order.
        skills: Others that it may call, or that may prepare its start.
        primitives: Primitives that any of them calls, by name.
        spot: Where it is written.
    """
    try:
        return _tried(skill, grounds, skills, primitives or {}, spot)
    except Exception as error:  # noqa: BLE001 - an author's conditions and primitives run here: whatever they raise
        broke = f"it could not be tried: {type(error).__name__}: {error}"
        return Contract(skill, (_finding(EFFECT_MISSING, skill, broke, spot),))


def _tried(
    skill: Skill,
    grounds: Sequence[Ground],
    skills: Sequence[Skill],
    primitives: Mapping[str, type[Primitive[Any]]],
    spot: Spot | None,
) -> Contract:
    others = [s for s in skills if s.description.name != skill.description.name and is_testable(s)]
    case = find_case(skill, grounds, [*others, skill], primitives)
    if isinstance(case, NoCase):
        reason = f"no world was found in which it can start: {case.reason}"
        return Contract(skill, (_finding(NEVER_TRIED, skill, reason, spot),))
    before = case.rig.world.snapshot()
    outcome = case.rig.run(case.agent, skill.description.name, case.arguments)
    findings = tuple(
        _finding(rule, skill, f"{text} ({case.where})", spot) for rule, text in _faults(skill, case, before, outcome)
    )
    return Contract(skill, findings, case.where, case.arguments, outcome)


def _faults(skill: Skill, case: Case, before: Index, outcome: Outcome) -> Iterator[tuple[Rule, str]]:
    world = case.rig.world
    ended = f"; it failed: {outcome.reason}" if isinstance(outcome, Failure) else ""
    posts = [condition.bind(case.arguments) for condition in skill.description.post]
    for condition in posts:
        verdict = condition.evaluate(world)
        if not verdict:
            why = "; ".join(line.strip() for line in verdict.lines()[1:])
            yield EFFECT_MISSING, f"{condition} did not happen: {why}{ended}"
    for line in undeclared(before, world.snapshot(), posts):
        yield UNDECLARED_CHANGE, f"no postcondition declares {line}"


def _finding(rule: Rule, skill: Skill, text: str, spot: Spot | None) -> Finding:
    return Finding(rule.name, rule.severity, title(skill), text, spot)
