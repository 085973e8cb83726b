"""Asking a person: a robot that cannot go on by itself says what it needs, and waits for the answer."""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import count

from skiros_py.errors import UnknownName, UsageError
from skiros_py.listeners import Listeners


class QuestionKind(enum.Enum):
    """What is asked for."""

    CONFIRM = "confirm"
    """Yes or no."""
    CHOOSE = "choose"
    """One of several."""
    REFILL = "refill"
    """Something to be brought; the answer says when it is done."""


@dataclass(frozen=True, slots=True)
class Question:
    """One question to a person.

    Attributes:
        id: Number of the question within the run.
        kind: What is asked for.
        text: The question, in the operator's words.
        options: The answers that are possible.
        asker: Name of the module that asks.
        time: Run time at which it was asked [s].
    """

    id: int
    kind: QuestionKind
    text: str
    options: tuple[str, ...]
    asker: str
    time: float


class Asked:
    """A question that is open; the answer may come from any thread."""

    def __init__(self, question: Question) -> None:
        self.question = question
        self.answer: str | None = None
        self.by = ""


class Questions:
    """The questions of a run that are open. Answers may be given from any thread; askers look in every cycle."""

    def __init__(self) -> None:
        self._open: dict[int, Asked] = {}
        self._numbers = count(1)
        self._listeners = Listeners[[Question]]("questions")

    @property
    def open(self) -> tuple[Question, ...]:
        """The open questions, oldest first."""
        return tuple(asked.question for asked in list(self._open.values()))

    @property
    def heard(self) -> bool:
        """True when a listener answers: else a question would wait for ever."""
        return bool(self._listeners)

    def subscribe(self, listener: Callable[[Question], None]) -> Callable[[], None]:
        """Calls the listener with each new question; returns how to end that. It must be quick."""
        return self._listeners.add(listener)

    def ask(self, kind: QuestionKind, text: str, options: tuple[str, ...], *, asker: str, time: float) -> Asked:
        """Opens a question and tells who listens."""
        asked = Asked(Question(next(self._numbers), kind, text, options, asker, time))
        self._open[asked.question.id] = asked
        self._listeners.notify(asked.question)
        return asked

    def withdraw(self, asked: Asked) -> None:
        """Closes a question that its asker no longer needs; what is answered or withdrawn already stays so."""
        self._open.pop(asked.question.id, None)

    def answer(self, number: int, answer: str, *, by: str) -> None:
        """Answers a question.

        Args:
            number: Its id.
            answer: One of its options.
            by: Who answers.

        Raises:
            UnknownName: No such question is open.
            UsageError: The answer is none of its options.
        """
        asked = self._open.get(number)
        if asked is None:
            raise UnknownName("question", str(number), [str(n) for n in self._open])
        if answer not in asked.question.options:
            raise UsageError(f"question {number}: answer one of {', '.join(asked.question.options)}, not '{answer}'")
        self._open.pop(number, None)
        asked.by = by
        asked.answer = answer  # last: the asker looks at this one

    def as_json(self) -> tuple[Mapping[str, object], ...]:
        """Returns the open questions as plain data."""
        return tuple(
            {"id": q.id, "kind": q.kind.value, "text": q.text, "options": q.options, "asker": q.asker, "time": q.time}
            for q in self.open
        )
