"""Contract tests: a run of a skill must have its declared effects, and no others."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from skiros_py.checking.cases import Case, Ground, NoCase, find_case
from skiros_py.checking.difference import undeclared
from skiros_py.checking.rig import Rig, fake_rig
from skiros_py.execution.contained import words
from skiros_py.execution.pulse import CycleOverrun
from skiros_py.skills.lint import EFFECT_MISSING, NEVER_TRIED, UNDECLARED_CHANGE, Finding, Rule, Spot, title
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.world.index import Index


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
    others = [s for s in skills if s.description.name != skill.description.name and is_testable(s)]

    def tried() -> Contract:
        with ExitStack() as rigs:

            def rig_in(ground: Ground) -> Rig:
                return rigs.enter_context(fake_rig(ground.open(), [*others, skill], primitives or {}, overrun))

            return _tried(skill, find_case(skill, grounds, [*others, skill], rig_in), spot)

    return contained_contract(skill, spot, tried)


def contained_contract(skill: Skill, spot: Spot | None, trial: Callable[[], Contract]) -> Contract:
    """Runs a trial; exceptions from an author's conditions and primitives become findings."""
    try:
        return trial()
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001 - an author's code: it must not end the other trials
        why = f"a condition {error}" if isinstance(error, CycleOverrun) else words(error)
        return Contract(skill, (finding(EFFECT_MISSING, skill, f"it could not be tried: {why}", spot),))


def never_tried(skill: Skill, reason: str, spot: Spot | None) -> Contract:
    """Returns the result for a skill that cannot start in any world."""
    text = f"no world was found in which it can start: {reason}"
    return Contract(skill, (finding(NEVER_TRIED, skill, text, spot),))


def missing_effects(skill: Skill, case: Case, outcome: Outcome) -> Iterator[str]:
    """Yields the postconditions that do not hold after a run, with the reasons."""
    ended = f"; it failed: {outcome.reason}" if isinstance(outcome, Failure) else ""
    for condition in skill.description.post:
        verdict = condition.bind(case.arguments).evaluate(case.rig.world)
        if not verdict:
            why = "; ".join(line.strip() for line in verdict.lines()[1:])
            yield f"{condition.bind(case.arguments)} did not happen: {why}{ended}"


def finding(rule: Rule, skill: Skill, text: str, spot: Spot | None) -> Finding:
    """Returns a finding of a trial of a skill."""
    return Finding(rule.name, rule.severity, title(skill), text, spot)


def _tried(skill: Skill, case: Case | NoCase, spot: Spot | None) -> Contract:
    if isinstance(case, NoCase):
        return never_tried(skill, case.reason, spot)
    before = case.rig.world.snapshot()
    outcome = case.rig.run(case.agent, skill.description.name, case.arguments)
    with case.rig.watched():
        faults = list(_faults(skill, case, before, outcome))
    findings = tuple(finding(rule, skill, f"{text} ({case.where})", spot) for rule, text in faults)
    return Contract(skill, findings, case.where, case.arguments, outcome)


def _faults(skill: Skill, case: Case, before: Index, outcome: Outcome) -> Iterator[tuple[Rule, str]]:
    yield from ((EFFECT_MISSING, text) for text in missing_effects(skill, case, outcome))
    posts = [condition.bind(case.arguments) for condition in skill.description.post]
    for line in undeclared(before, case.rig.world.snapshot(), posts):
        yield UNDECLARED_CHANGE, f"no postcondition declares {line}"
