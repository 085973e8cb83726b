"""How much may be under way at the same time."""

from __future__ import annotations

from contextlib import ExitStack

import pytest

from skiros_py.server.access.load import Load
from skiros_py.server.problems import Problem


def test_those_who_were_let_in_are_counted_until_they_are_done() -> None:
    load = Load(2)
    with load.known():
        with load.known(), pytest.raises(Problem, match="too many"), load.known():
            pytest.fail("is a third one")
        with load.known():
            pass


def test_strangers_take_no_places_of_those_who_were_let_in() -> None:
    load = Load(1)
    with ExitStack() as stack:
        for number in range(50):
            stack.enter_context(load.stranger(f"192.0.2.{number}"))
        with pytest.raises(Problem) as caught:
            stack.enter_context(load.stranger("198.51.100.1"))
        with load.known():
            pass

    assert (caught.value.status, caught.value.headers["Retry-After"]) == (503, "1")


def test_one_network_takes_no_places_of_another() -> None:
    load = Load(1)
    with ExitStack() as stack:
        for number in range(10):
            stack.enter_context(load.stranger(f"2001:db8::{number:x}"))
        with pytest.raises(Problem):
            stack.enter_context(load.stranger("2001:db8::abcd"))
        with load.stranger("192.0.2.1"):
            pass
    with load.stranger("2001:db8::abcd"):
        pass
