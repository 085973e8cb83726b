"""How often somebody may do something."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from skiros_py.server.access.rates import Rates


class _Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_as_many_permits_as_a_bucket_holds_are_given_and_no_more() -> None:
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


def test_one_caller_takes_nothing_from_another() -> None:
    rates = Rates(1, 60.0, clock=_Clock())
    rates.take("a")

    assert rates.take("b")


def test_no_more_is_kept_however_many_come() -> None:
    rates = Rates(1, 60.0, people=10, clock=_Clock())
    for number in range(1000):
        rates.take(str(number))

    assert len(rates._buckets) == 10


@given(st.lists(st.floats(0, 10), min_size=1, max_size=200), st.integers(1, 20))
def test_never_more_are_given_than_the_bucket_and_what_came_back(pauses: list[float], most: int) -> None:
    clock = _Clock()
    rates = Rates(most, 10.0, clock=clock)
    given_ = 0
    for pause in pauses:
        clock.now += pause
        given_ += rates.take("a")

    assert given_ <= most + clock.now * most / 10.0 + 1e-6
