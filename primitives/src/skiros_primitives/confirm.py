"""Asks the user to confirm something."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.asking import AskingPrimitive
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.questions import QuestionKind


class Confirm(AskingPrimitive):
    """Asks the user a yes-or-no question; "no" is a failure."""

    name: ClassVar[str] = "confirm"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        question: str = param("text", "What is asked, such as 'Is the door closed?'.")
        patience: float | None = param(
            "number", "Longest wait for the answer; left out: for ever.", kind=Kind.OPTIONAL, default=None, unit="s"
        )

    def execute(self) -> Execution[Outcome]:
        """Asks."""
        answer = yield from self.ask(QuestionKind.CONFIRM, self.params.question, ("yes", "no"))
        if isinstance(answer, Failure):
            return answer
        return Success("yes") if answer == "yes" else Failure(f"a person said no: {self.params.question}")
