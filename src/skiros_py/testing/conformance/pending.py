"""What every answer that is on its way must do."""

# ruff: noqa: D102 - the names of tests say what they claim

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from typing import Any, TypeVar

import pytest

from skiros_py.ports.values import Pending

T = TypeVar("T")

_PATIENCE = 60.0
"""Longest wall time for which an answer is waited for [s]."""


class PendingContract(ABC):
    """Claims about a :class:`~skiros_py.ports.values.Pending`, such as the answer of a device of one's own."""

    @abstractmethod
    def make(self) -> Pending[Any]:
        """Asks for something that will be answered; each test asks once."""

    @pytest.fixture
    def pending(self) -> Pending[Any]:
        """A request of its own for each test."""
        return self.make()

    def test_the_answer_comes_and_stays_the_same(self, pending: Pending[Any]) -> None:
        check_pending(pending)

    def test_the_latency_is_declared_from_the_start_and_does_not_change(self, pending: Pending[Any]) -> None:
        before = pending.latency
        pending.result()

        assert before >= 0.0
        assert pending.latency == before

    def test_the_answer_may_be_taken_in_another_thread(self, pending: Pending[Any]) -> None:
        answers: list[Any] = []
        thread = threading.Thread(target=lambda: answers.append(pending.result()))
        thread.start()
        thread.join(_PATIENCE)

        assert len(answers) == 1

    def test_asking_whether_it_is_there_does_not_wait(self, pending: Pending[Any]) -> None:
        began = time.monotonic()
        pending.done()

        assert time.monotonic() - began < 0.5


def check_pending(pending: Pending[T]) -> T:
    """Waits for an answer without blocking, then takes it twice."""
    deadline = time.monotonic() + _PATIENCE
    while not pending.done() and time.monotonic() < deadline:
        time.sleep(0.005)
    assert pending.done(), f"no answer within {_PATIENCE:.0f} s"
    answer = pending.result()
    assert pending.result() is answer, "the answer is another one when it is taken again"
    return answer
