"""How often and how much at once a caller, or a stranger's network, may ask."""

from __future__ import annotations

from contextlib import ExitStack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.server.access.limiters import Rates, Slots, network_of
from skiros_py.server.problems import Problem


class _Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_a_bucket_grants_exactly_as_many_permits_as_it_holds() -> None:
    rates = Rates(3, 60.0, clock=_Clock())

    assert [rates.take("a") for _ in range(5)] == [True, True, True, False, False]


def test_permits_come_back_as_time_passes() -> None:
    clock = _Clock()
    rates = Rates(3, 60.0, clock=clock)
    for _ in range(3):
        rates.take("a")
    clock.now += rates.wait("a")

    assert rates.take("a")
    assert not rates.take("a")


def test_permits_of_one_caller_do_not_reduce_those_of_another() -> None:
    rates = Rates(1, 60.0, clock=_Clock())
    rates.take("a")

    assert rates.take("b")


def test_memory_is_bounded_for_any_number_of_callers() -> None:
    rates = Rates(1, 60.0, people=10, clock=_Clock())
    for number in range(1000):
        rates.take(str(number))

    assert len(rates._buckets) == 10


@given(st.lists(st.floats(0, 10), min_size=1, max_size=200), st.integers(1, 20))
def test_never_more_permits_are_granted_than_the_capacity_plus_the_refill(pauses: list[float], most: int) -> None:
    clock = _Clock()
    rates = Rates(most, 10.0, clock=clock)
    given_ = 0
    for pause in pauses:
        clock.now += pause
        given_ += rates.take("a")

    assert given_ <= most + clock.now * most / 10.0 + 1e-6


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("192.0.2.1", "192.0.2.1", True),
        ("192.0.2.1", "192.0.2.2", False),
        ("2001:db8::1", "2001:db8::ffff:2", True),
        ("2001:db8::1", "2001:db8:0:1::1", False),
        ("::ffff:192.0.2.1", "192.0.2.1", True),
        ("::ffff:192.0.2.1", "::ffff:192.0.2.2", False),
        ("fe80::1%eth0", "fe80::2%eth0", True),
        ("testclient", "testclient", True),
        ("", "testclient", False),
    ],
)
def test_addresses_are_grouped_by_the_network_of_their_caller(one: str, other: str, same: bool) -> None:
    assert (network_of(one) == network_of(other)) is same


def test_a_slot_is_released_at_the_end_of_its_block() -> None:
    slots = Slots("requests", 2, 2)
    with slots.take("a"):
        with slots.take("b"), pytest.raises(Problem, match="too many requests"), slots.take("c"):
            pytest.fail("is a third one")
        with slots.take("c"):
            pass
    assert slots.taken == 0


def test_a_caller_without_a_slot_is_asked_to_wait() -> None:
    slots = Slots("requests", 50, 1)
    with ExitStack() as stack:
        for number in range(50):
            stack.enter_context(slots.take(f"192.0.2.{number}"))
        with pytest.raises(Problem) as caught:
            stack.enter_context(slots.take("198.51.100.1"))

    assert (caught.value.status, caught.value.headers["Retry-After"]) == (503, "1")


def test_one_caller_cannot_use_the_slots_of_another() -> None:
    slots = Slots("logins", 50, 10)
    with ExitStack() as stack:
        for number in range(10):
            stack.enter_context(slots.take(network_of(f"2001:db8::{number:x}")))
        with pytest.raises(Problem):
            stack.enter_context(slots.take(network_of("2001:db8::abcd")))
        with slots.take(network_of("192.0.2.1")):
            pass
    with slots.take(network_of("2001:db8::abcd")):
        pass
