"""Branches that run at the same time need devices of their own, or devices that can be shared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from skiros_py.ports.kinds import load_device_kinds
from skiros_py.skills.behaviour import Behaviour, Call, P
from skiros_py.skills.lint.rule import Classes, Known, Problem, Rule, Severity, Subject, classes_of, walk_scoped
from skiros_py.skills.lint.rules.ranges import overlap
from skiros_py.skills.lint.rules.words import own_params
from skiros_py.skills.parameters import Access, Kind, Param
from skiros_py.skills.skill import Skill, SkillDescription


@dataclass(frozen=True, slots=True)
class _Device:
    """What a call takes.

    Attributes:
        class_: Its class.
        name: What the body says for it; empty where it is left out, so that it is the robot's.
        shared: True when others may command it at the same time.
    """

    class_: str
    name: str = ""
    shared: bool = False

    def __str__(self) -> str:
        return self.name or f"the robot's {self.class_}"


def _taken_twice(subject: Subject, known: Known) -> Iterator[Problem]:
    if not isinstance(subject, Skill):
        return
    own = classes_of(subject.description)
    for node, classes in (found for root in subject.nodes for found in walk_scoped(root, own)):
        yield from map(Problem, taken_twice(node, classes, known, subject.description))


def taken_twice(
    node: Behaviour, classes: Classes, known: Known, description: SkillDescription | None = None
) -> Iterator[str]:
    """Yields what is wrong with a node that runs children at the same time, of which two take one device.

    Args:
        node: The node.
        classes: Classes of the elements that it can refer to.
        known: The modules.
        description: Of the skill that it is part of, whose subsystem is taken where a call names none; or None.
    """
    if node.uses().concurrent:
        children = node.named_children().values()
        branches = [_devices(child, classes, description, known) for child in children]
        for (i, one), (j, other) in combinations(enumerate(branches, start=1), 2):
            both = ((a, b) for a in one for b in other if not (a.shared and b.shared) and _may_be_one(a, b, known))
            for device in sorted({str(a if a.name else b) for a, b in both}):
                yield (
                    f"parallel branches {i} and {j} both take {device} exclusively: one would wait for the other; "
                    "run them in sequence, or let both share it (access=Access.SHARED)"
                )


def _may_be_one(one: _Device, other: _Device, known: Known) -> bool:
    """Tells whether two are one device; of what is left out, robots have one of a class or would have to say which."""
    if one.name and other.name:
        return one.name == other.name
    return overlap(known.ontology, one.class_, other.class_)


def _devices(node: Behaviour, classes: Classes, description: SkillDescription | None, known: Known) -> set[_Device]:
    """Returns what the modules of a branch take."""
    calls = ((call, scope) for below, scope in walk_scoped(node, classes) for call in below.uses().calls)
    return {device for call, scope in calls for device in _taken(call, scope, description, known)}


def _taken(call: Call, classes: Classes, description: SkillDescription | None, known: Known) -> Iterator[_Device]:
    if call.module in known.primitives and known.primitives[call.module].watches:
        return  # a watching primitive takes nothing
    taken = known.takes(call.module)
    for param in known.params(call.module) or ():
        if not param.is_element or not (param.key in taken or param.kind is Kind.HARDWARE):
            continue
        if param.access is Access.READ:
            continue
        if param.key in call.arguments:
            yield _given(call.arguments[param.key], param, classes)
        elif param.kind.is_required:
            yield _left_out(param, description, known)


def _given(value: Any, param: Param, classes: Classes) -> _Device:
    if isinstance(value, P):
        return _Device(classes.get(value.key, param.element_class), value.key, param.access is Access.SHARED)
    return _Device(param.element_class, str(value), param.access is Access.SHARED)


def _left_out(param: Param, description: SkillDescription | None, known: Known) -> _Device:
    """Returns what a run fills in: the subsystem itself where it is of that class, for nothing is nearer."""
    is_agent = description is not None and overlap(known.ontology, description.agent_class, param.element_class)
    return _Device(
        param.element_class, description.agent if description and is_agent else "", param.access is Access.SHARED
    )


def _unmixed(subject: Subject, known: Known) -> Iterator[Problem]:
    """Yields parameters by which devices are shared that cannot be: no kind of their class has a mix rule."""
    shared = [param for param in own_params(subject) if param.access is Access.SHARED and param.is_element]
    kinds = load_device_kinds()[0].by_name.values() if shared else ()
    for param in shared:
        fitting = [kind for kind in kinds if overlap(known.ontology, param.element_class, kind.device_class)]
        if fitting and not any(kind.mixes() for kind in fitting):
            names = " and ".join(f"'{kind.kind}'" for kind in fitting)
            yield Problem(f"parameter {param.key} shares a device, but kind {names} has no mix rule")


SAME_DEVICE = Rule("same-device", Severity.ERROR, "Two parallel branches take one device exclusively.", _taken_twice)
NO_MIX_RULE = Rule(
    "no-mix-rule", Severity.ERROR, "A device is shared whose kind cannot merge commands.", _unmixed, disables=True
)
