"""Common base of the primitives that ask the user."""

from __future__ import annotations

from typing import Any

from skiros_py.skills.outcome import Failure
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.questions import QuestionKind


class AskingPrimitive(Primitive[Any]):
    """Base of the primitives that ask the user; their parameters have a field ``patience`` [s], None for no limit."""

    def start(self) -> Failure | None:
        """Fails at once if no user interface could show the question."""
        if not self.context.questions.heard:
            return Failure(f"{self.name}: nobody listens who could answer; run it where a person watches")
        return None

    def ask(self, kind: QuestionKind, text: str, options: tuple[str, ...]) -> Execution[str | Failure]:
        """Asks a question and waits for the answer, one of the options; a question no longer needed is withdrawn."""
        questions, asked_at = self.context.questions, self.context.now
        asked = questions.ask(kind, text, options, asker=self.name, time=asked_at)
        self.progress(1, text)
        patience = self.params.patience
        try:
            while asked.answer is None and (patience is None or self.context.now < asked_at + patience):
                yield
        finally:
            questions.withdraw(asked)
        if asked.answer is None:
            return Failure(f"nobody answered within {patience:g} s: {text}")
        self.progress(2, f"{asked.by} answered: {asked.answer}")
        return asked.answer
