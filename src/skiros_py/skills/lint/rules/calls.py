"""A body calls modules that are there, with parameters that they have, and by names that are there."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from dataclasses import MISSING, fields

from skiros_py.skills.composition import AssertEffects, Check, Do, ForEach, Guard, P, walk
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.lint.finding import Problem, Severity
from skiros_py.skills.lint.patterns import classes_of, walk_scoped
from skiros_py.skills.lint.rule import Rule
from skiros_py.skills.lint.rules.words import own_params
from skiros_py.skills.lint.subject import Known, PrimitiveClass, Source, Subject
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.skills.variables import variables

__all__ = ["MISSING_PARAMETER", "UNKNOWN_MODULE"]


def _calls(subject: Subject, known: Known) -> Iterator[Problem]:
    if not isinstance(subject, Skill):
        return
    for call in (node for root in subject.nodes for node in walk(root) if isinstance(node, Do)):
        yield from map(Problem, _in_call(call, known))


def _in_call(call: Do, known: Known) -> Iterator[str]:
    if call.module in known.primitives:
        yield from _in_primitive_call(call, known.primitives[call.module])
        return
    params = known.params(call.module)
    if params is None:
        names = sorted({*known.primitives, *(s.description.name for s in known.skills)})
        yield f"there is no primitive or skill '{call.module}'; there is {', '.join(names) or 'none'}"
        return
    yield from _in_skill_call(call, params)


def _in_primitive_call(call: Do, primitive: PrimitiveClass) -> Iterator[str]:
    own = {field.name: field for field in fields(primitive.Params)}
    for name, field in own.items():
        if field.default is MISSING and field.default_factory is MISSING and name not in call.arguments:
            yield f"primitive '{call.module}' needs {name}"
    yield from _unknown(f"primitive '{call.module}'", call.arguments, own)


def _in_skill_call(call: Do, params: tuple[Param, ...]) -> Iterator[str]:
    """Elements that are left out are inferred when the call's turn comes; values are not."""
    for param in params:
        if param.kind is Kind.ONLINE and not param.is_element and param.key not in call.arguments:
            yield f"skill '{call.module}' needs {param.key}"
    yield from _unknown(f"skill '{call.module}'", call.arguments, [param.key for param in params])


def _unknown(module: str, given: Iterable[str], known: Iterable[str]) -> Iterator[str]:
    keys = list(known)
    for key in given:
        if key not in keys:
            yield f"{module} has no parameter {key}{_nearest(key, keys)}"


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
    keys = {param.key for param in skill.description.params}
    posts = [condition.key for condition in skill.description.post]
    for root in skill.nodes:
        for node, scope in walk_scoped(root, classes_of(skill.description)):
            there = keys | scope.keys()
            match node:
                case Do(module, arguments):
                    asked = [value.key for value in arguments.values() if isinstance(value, P)]
                    yield from _said(f"'{module}' asks for", asked, there)
                case Guard(_, conditions) | Check(conditions):
                    for condition in conditions:
                        yield from _said(f"condition {condition} asks for", condition.arguments, there)
                case ForEach(key, _, _, pattern) if pattern is not None:
                    yield from _said(f"for each {key} asks for", variables(pattern), {*there, key})
                case AssertEffects(_, only):
                    for key in (key for key in only if key not in posts):
                        yield f"it asserts '{key}', which is no postcondition; there is {', '.join(posts)}"
                case _:
                    pass


def _said(what: str, names: Iterable[str], there: set[str]) -> Iterator[str]:
    for name in names:
        if name not in there:
            yield f"{what} {name}, which is no parameter of the skill{_nearest(name, there)}"


UNKNOWN_MODULE = Rule(
    "unknown-module", Severity.ERROR, "A body calls what is not there, or with parameters it has not.", _calls, True
)
MISSING_PARAMETER = Rule(
    "missing-parameter", Severity.ERROR, "Something refers to a parameter that is not there.", _strays, True
)
