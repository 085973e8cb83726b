"""A skill may call itself, as long as it can also do without."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from skiros_py.skills.behaviour import Behaviour, calls_of
from skiros_py.skills.lint.rule import Problem, Rule, Severity
from skiros_py.skills.lint.subject import Known, Subject
from skiros_py.skills.skill import Skill


def _endless(subject: Subject, known: Known) -> Iterator[Problem]:
    """Yields a problem for an implementation none of whose ways to succeed ever ends."""
    if not isinstance(subject, Skill):
        return
    others = [s for s in known.skills if s.driver == subject.driver]
    endless = {s.description.name for s in others} - _ending(others)
    if _ends(subject, endless):
        return
    calls = sorted({call.module for call in calls_of(*subject.nodes) if call.module in endless})
    yield Problem(f"whichever way it succeeds, it calls {' and '.join(calls)}, which in the end calls itself again")


def _ending(skills: Collection[Skill]) -> set[str]:
    """Returns the skills that can succeed without calling themselves, however indirectly."""
    names = {skill.description.name for skill in skills}
    ending: set[str] = set()
    while True:
        more = {s.description.name for s in skills if _ends(s, names - ending)}
        if more <= ending:
            return ending
        ending |= more


def _ends(skill: Skill, open_: Collection[str]) -> bool:
    return all(_can_end(node, open_) for node in skill.nodes)


def _can_end(node: Behaviour, open_: Collection[str]) -> bool:
    uses = node.uses()
    if any(call.module in open_ for call in uses.calls):
        return False
    children = (_can_end(child, open_) for child in node.named_children().values())
    match uses.needs:
        case "any":
            return any(children)
        case "all":
            return all(children)
        case "none":
            return True


RECURSIVE_SKILL = Rule("recursive-skill", Severity.ERROR, "A skill that calls itself without end.", _endless)
