"""Steps written by a person: parsed and checked against the world and the skills at one moment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType

from skiros_py.api.tasks import WantedStep
from skiros_py.errors import Refused, SkirosError
from skiros_py.planning.plan import Step
from skiros_py.skills.skill import SkillDescription
from skiros_py.station.session import Session
from skiros_py.tasks.sequences import StepCheck, StepSequence, check_steps
from skiros_py.world.index import Index


@dataclass(frozen=True, slots=True)
class Workbench:
    """The world and the skills at one moment, against which steps are parsed and checked.

    Attributes:
        view: The world.
        skills: The offered skills, by name.
    """

    view: Index
    skills: dict[str, SkillDescription]

    @classmethod
    def of(cls, session: Session) -> Workbench:
        """Returns the workbench of a session; does not block; callable from any thread."""
        return cls(session.world.snapshot(), {c.skill.name: c.skill for c in session.tasks.capabilities})

    def read(self, step: WantedStep) -> Step:
        """Parses a step.

        Raises:
            UsageError: It names a skill, parameter or element that does not exist.
        """
        wanted = Step(step.skill, MappingProxyType(dict(step.arguments)))
        return StepSequence(self.view, self.skills, (wanted,)).steps[0]

    def check(self, steps: Sequence[Step]) -> tuple[StepCheck, ...]:
        """Checks steps in turn; a step with names that no longer exist is reported and skipped."""
        faults = {number: fault for number, step in enumerate(steps) if (fault := self._fault(step))}
        checks = iter(check_steps(self.view, [s for n, s in enumerate(steps) if n not in faults], self.skills))
        return tuple(
            StepCheck(step, (faults[number],)) if number in faults else next(checks)
            for number, step in enumerate(steps)
        )

    def _fault(self, step: Step) -> str:
        try:
            StepSequence(self.view, self.skills, (step,))
        except SkirosError as error:
            return str(error)
        return ""


def require_works(session: Session, steps: Sequence[Step]) -> None:
    """Requires that steps can be run in the present world.

    Raises:
        Refused: A step cannot work.
    """
    checks = Workbench.of(session).check(steps)
    broken = [f"step {n} ({c.step.skill}): {'; '.join(c.problems)}" for n, c in enumerate(checks) if not c.works]
    if broken:
        why = " / ".join(broken)
        raise Refused("CannotWork", f"it cannot work: {why}; mend it, or run it anyway", broken=broken)
