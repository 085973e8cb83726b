"""Sequences: documents with steps that people put in order, and that run as tasks without planning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, ClassVar

from skiros_py.behaviours import Behaviour, Do, DocumentKind, PaletteEntry, Review
from skiros_py.behaviours import Sequence as Body
from skiros_py.errors import DescriptionError, DocumentFault, Refused
from skiros_py.messages import Message, joined
from skiros_py.planning.plan import Step
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.plain import Reader
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.sequences import StepCheck, check_steps
from skiros_py.world.view import WorldView

_MOST_STEPS = 100
_LONGEST_TITLE = 200

Skills = Mapping[str, SkillDescription]


class SequenceDocument(DocumentKind):
    """Steps in the order in which they run: ``{"title": …, "steps": [{"skill": "drive", "arguments": {…}}]}``."""

    kind: ClassVar[str] = "sequence"

    def behaviour(self, document: Any, reader: Reader) -> Behaviour | None:  # noqa: ARG002
        """Returns its calls in turn; a sequence without steps is no module."""
        calls = tuple(Do(step.skill, step.arguments) for step in steps_of(document))
        return Body(calls) if calls else None

    def review(
        self,
        document: Any,
        world: WorldView,
        skills: Skills,
        conditions: Mapping[str, ConditionType],  # noqa: ARG002
    ) -> Review:
        """Checks each step in the world that the steps before it leave; unknown names are faults."""
        checks = list(enumerate(check_steps(world, steps_of(document), skills)))
        found = [(check, DocumentFault(_place(number), text)) for number, check in checks for text in check.problems]
        return Review(
            tuple(fault for check, fault in found if not check.is_known),
            tuple(fault for check, fault in found if check.is_known),
            {_place(number): check.agent for number, check in checks},
        )

    def palette(self, reader: Reader) -> Sequence[PaletteEntry]:  # noqa: ARG002
        """Returns the only node: a step."""
        return (PaletteEntry("step", "Runs a skill.", {"skill": "str", "arguments": "Mapping[str, str]"}),)


def steps_of(document: Any) -> tuple[Step, ...]:
    """Returns the steps of a sequence.

    Raises:
        DescriptionError: It is not a sequence; the error has the place.
    """
    if unknown := sorted(document.keys() - {"title", "steps"}):
        raise DescriptionError("a sequence has a title and steps, and nothing else", unknown[0])
    title, steps = document.get("title", ""), document.get("steps", [])
    if not isinstance(title, str) or len(title) > _LONGEST_TITLE:
        raise DescriptionError(f"a text of at most {_LONGEST_TITLE} characters, not {title!r:.100}", "title")
    if not isinstance(steps, list) or len(steps) > _MOST_STEPS:
        raise DescriptionError(f"a list of at most {_MOST_STEPS} steps, not {steps!r:.100}", "steps")
    return tuple(_step(number, data) for number, data in enumerate(steps))


def _step(number: int, data: Any) -> Step:
    match data:
        case {"skill": str(skill)} if skill and data.keys() <= {"skill", "arguments"}:
            arguments = data.get("arguments", {})
            if isinstance(arguments, dict) and all(isinstance(value, str) for value in arguments.values()):
                return Step(skill, MappingProxyType(dict(arguments)))
    raise DescriptionError(f"a step has a skill, and arguments that are texts, not {data!r:.100}", _place(number))


def _place(number: int) -> str:
    return f"steps[{number}]"


def require_works(checks: Sequence[StepCheck]) -> None:
    """Requires that steps can be run.

    Raises:
        Refused: A step cannot work.
    """
    broken = [
        Message("step {number} ({skill}): {problems}", number=n, skill=c.step.skill, problems=joined("; ", c.problems))
        for n, c in enumerate(checks)
        if c.problems
    ]
    if broken:
        text = Message("it cannot work: {why}; change it, or run it anyway", why=joined(" / ", broken))
        raise Refused("CannotWork", text, broken=broken)
