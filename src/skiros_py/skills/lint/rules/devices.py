"""What runs at the same time needs devices of its own."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

from skiros_py.skills.composition import Do, Node, P, Parallel, walk
from skiros_py.skills.lint.finding import Problem, Severity
from skiros_py.skills.lint.rule import Rule
from skiros_py.skills.lint.subject import Known, Subject
from skiros_py.skills.parameters import Kind
from skiros_py.skills.skill import Skill

__all__ = ["SAME_DEVICE"]


def _shared(subject: Subject, known: Known) -> Iterator[Problem]:
    if not isinstance(subject, Skill):
        return
    for node in (node for root in subject.nodes for node in walk(root)):
        if isinstance(node, Parallel):
            for (i, one), (j, other) in combinations(enumerate(node.children, start=1), 2):
                for device in sorted(_devices(one, known) & _devices(other, known)):
                    yield Problem(f"parallel branches {i} and {j} both take {device}: one waits for the other")


def _devices(node: Node, known: Known) -> set[str]:
    """Returns what the modules of a branch take, as far as the body says it."""
    calls = [below for below in walk(node) if isinstance(below, Do)]
    return {name for call in calls for name in _taken(call, known)}


def _taken(call: Do, known: Known) -> Iterator[str]:
    taken = set(known.takes(call.module))
    taken |= {param.key for param in known.params(call.module) or () if param.kind is Kind.HARDWARE}
    for key, value in call.arguments.items():
        if key in taken:
            yield _name(value)


def _name(value: Any) -> str:
    return value.key if isinstance(value, P) else str(value)


SAME_DEVICE = Rule("same-device", Severity.WARNING, "Two parallel branches take one device.", _shared)
