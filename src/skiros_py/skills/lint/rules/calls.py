"""A body calls modules that are there, with parameters that they have; recursion must be able to end."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Iterator

from skiros_py.skills.behaviour import Behaviour, Call, calls_of, walk
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.lint.rule import Known, Problem, Rule, Severity, Source, Subject
from skiros_py.skills.lint.rules.words import own_params
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.references import variables
from skiros_py.skills.skill import Skill, SkillDescription


def _calls(subject: Subject, known: Known) -> Iterator[Problem]:
    for call in _calls_of(subject):
        yield from map(Problem, wrong_call(call, known))


def wrong_call(call: Call, known: Known) -> Iterator[str]:
    """Yields what is wrong with a call: the module that is not there, or parameters that it has not."""
    if call.module in known.primitives:
        yield from _unknown(f"primitive '{call.module}'", call.inputs, known.params(call.module) or ())
    elif known.implementations(call.module):
        yield from _unknown(f"skill '{call.module}'", call.inputs, known.params(call.module) or ())
    else:
        names = sorted({*known.primitives, *(s.description.name for s in known.skills)})
        yield f"there is no primitive or skill '{call.module}'; there is {', '.join(names) or 'none'}"


def _gaps(subject: Subject, known: Known) -> Iterator[Problem]:
    for call in _calls_of(subject):
        kind = "primitive" if call.module in known.primitives else "skill"
        for param in known.params(call.module) or ():
            if param.kind.is_required and param.key not in call.arguments and not _is_filled_in(param, kind):
                yield Problem(f"{kind} '{call.module}' needs {param.key}")


def _calls_of(subject: Subject) -> Iterator[Call]:
    if isinstance(subject, Skill):
        yield from calls_of(*subject.nodes)


def _is_filled_in(param: Param, kind: str) -> bool:
    """Tells whether a run finds it: what it can of a skill, and of a primitive what belongs to the robot."""
    return param.is_inferred and (kind == "skill" or param.kind in (Kind.HARDWARE, Kind.PLANNING))


def _unknown(module: str, given: Iterable[str], params: Iterable[Param]) -> Iterator[str]:
    by_key = {param.key: param for param in params}
    for key in given:
        if key not in by_key:
            yield f"{module} has no parameter {key}{_nearest(key, by_key)}"
        elif by_key[key].kind is Kind.CONFIG:
            yield f"{module} has {key} fixed when it is loaded: it cannot be given at a call"


def _nearest(name: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=0.7)
    return f"; did you mean {near[0]}?" if near else ""


def _strays(subject: Subject, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    match subject:
        case Skill():
            yield from map(Problem, _in_body(subject))
        case SkillDescription() | Source():
            pass
        case ConditionType():
            roles = [role.name for role in subject.roles]
            yield from (Problem(f"its pattern asks for {v}, which is no role") for v in _open(subject, roles))
        case _:
            keys = [param.key for param in own_params(subject)]
            for key in (key for key in subject.takes if key not in keys):
                yield Problem(f"it takes {key}, which is no parameter of it{_nearest(key, keys)}")


def _open(type_: ConditionType, roles: list[str]) -> Iterator[str]:
    return (name for name in variables(type_.pattern) if name not in roles)


def _in_body(skill: Skill) -> Iterator[str]:
    """Yields what is asserted in vain; other references were looked at when the skill was made."""
    posts = [condition.key for condition in skill.description.post]
    asserted = (node.uses().pretends or () for root in skill.nodes for node in walk(root))
    for key in (key for keys in asserted for key in keys if key not in posts):
        yield f"it asserts '{key}', which is no postcondition; there is {', '.join(posts)}"


UNKNOWN_MODULE = Rule(
    "unknown-module", Severity.ERROR, "A body calls what is not there, or with parameters it has not.", _calls, True
)
MISSING_ARGUMENT = Rule(
    "missing-argument", Severity.ERROR, "A call leaves out an argument that cannot be inferred.", _gaps, disables=True
)
MISSING_PARAMETER = Rule(
    "missing-parameter", Severity.ERROR, "Something refers to a parameter that is not there.", _strays, True
)


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
