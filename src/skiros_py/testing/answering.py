"""Answers the questions of a run in a test."""

from __future__ import annotations

from collections.abc import Mapping

from skiros_py.skills.questions import Question, Questions


class Answers:
    """The questions of a run, and those without an answer.

    Attributes:
        asked: Every question so far.
        unanswered: Questions that match no given answer; they stay open.
    """

    def __init__(self, questions: Questions, given: Mapping[str, str]) -> None:
        self.asked: list[Question] = []
        self.unanswered: list[Question] = []
        self._questions = questions
        self._given = given
        questions.subscribe(self._hear)

    def _hear(self, question: Question) -> None:
        self.asked.append(question)
        fitting = [answer for words, answer in self._given.items() if words in question.text]
        if fitting:
            self._questions.answer(question.id, fitting[0], by="test")
        else:
            self.unanswered.append(question)


def answers(questions: Questions, given: Mapping[str, str]) -> Answers:
    """Answers the questions of a run to a person, from now on.

    >>> asked = answers(bench.questions, {"refill": "done", "Is the door open": "yes"})

    Args:
        questions: Of a bench or a session.
        given: Answer by words contained in the question; the first match is used.

    Returns:
        The questions so far.
    """
    return Answers(questions, given)
