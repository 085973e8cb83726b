"""Branches that run at the same time need devices of their own, or devices that can be shared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

from skiros_py.ports.device_kinds import load_device_kinds
from skiros_py.skills.behaviour import P
from skiros_py.skills.lint.rule import Known, Place, Subject, rule
from skiros_py.skills.lint.rules.words import own_params
from skiros_py.skills.parameters import Access, Kind
from skiros_py.skills.skill import SkillDescription


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


@rule("same-device", "Two parallel branches claim one device exclusively.", Place)
def same_device(place: Place, known: Known) -> Iterator[str]:
    """Yields devices that two children of a node take, which run at the same time."""
    if not place.node.uses().concurrent:
        return
    children = place.node.named_children().values()
    branches = [
        {one for inner in replace(place, node=child).below() for one in _taken(inner, known)} for child in children
    ]
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
    return known.ontology.overlap(one.class_, other.class_)


def _taken(place: Place, known: Known) -> Iterator[_Device]:
    """Yields what the modules take that a node calls; primitives that watch take nothing."""
    calls = place.node.uses().calls
    for call in (c for c in calls if c.module not in known.primitives or not known.primitives[c.module].watches):
        taken = known.takes(call.module)
        for param in known.params(call.module) or ():
            if not param.is_element or not (param.key in taken or param.kind is Kind.HARDWARE):
                continue
            shared = param.access is Access.SHARED
            if param.access is Access.READ:
                continue
            if param.key in call.arguments:
                value = call.arguments[param.key]
                key = value.key if isinstance(value, P) else ""
                yield _Device(place.classes.get(key, param.element_class), key or str(value), shared)
            elif param.kind.is_required:  # a run fills in the subsystem itself where it is of that class: it is nearest
                own = place.description
                is_agent = own is not None and known.ontology.overlap(own.agent_class, param.element_class)
                yield _Device(param.element_class, own.agent if own is not None and is_agent else "", shared)


@rule("no-mix-rule", "A shared device whose kind cannot merge commands.", SkillDescription, type, disables=True)
def no_mix_rule(subject: Subject, known: Known) -> Iterator[str]:
    """Yields parameters by which devices are shared that cannot be: no kind of their class has a mix rule."""
    shared = [param for param in own_params(subject) if param.access is Access.SHARED and param.is_element]
    kinds = load_device_kinds()[0].by_name.values() if shared else ()
    for param in shared:
        fitting = [kind for kind in kinds if known.ontology.overlap(param.element_class, kind.device_class)]
        if fitting and not any(kind.mixes() for kind in fitting):
            names = " and ".join(f"'{kind.kind}'" for kind in fitting)
            yield f"parameter {param.key} shares a device, but kind {names} has no mix rule"
