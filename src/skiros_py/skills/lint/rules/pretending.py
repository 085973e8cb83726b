"""Only fakes pretend: elsewhere the primitive that sensed an effect writes it."""

from __future__ import annotations

from collections.abc import Iterator

from skiros_py.skills.behaviour import walk
from skiros_py.skills.lint.rule import Problem, Rule, Severity
from skiros_py.skills.lint.subject import Known, Subject
from skiros_py.skills.skill import Skill


def _pretended(subject: Subject, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    if not isinstance(subject, Skill) or subject.driver == "fake":
        return
    if any(node.uses().pretends is not None for root in subject.nodes for node in walk(root)):
        said = "every driver" if subject.driver is None else f"driver '{subject.driver}'"
        yield Problem(
            f"it is for {said} and asserts effects without sensing them: only skills for driver 'fake' may; let the "
            "primitive that senses an effect call self.assert_effects(…)"
        )


PRETENDS = Rule(
    "pretends", Severity.ERROR, "A skill for a real robot asserts effects without sensing them.", _pretended, True
)
