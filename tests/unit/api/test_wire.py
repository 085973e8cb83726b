"""Times on the wire: whoever sends one is held to sensible years, and what is answered is told as it is."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest
from pydantic import TypeAdapter, ValidationError

from skiros_py.api.jobs import JobOrder
from skiros_py.api.wire import Moment, WantedMoment, moment


def test_a_time_of_a_machine_whose_clock_stood_at_1970_is_answered() -> None:
    begun = moment(0.5)
    assert TypeAdapter(Moment).validate_python(begun) == begun
    assert TypeAdapter(Moment).dump_json(moment(0.0)) == b'"1970-01-01T00:00:00Z"'


@pytest.mark.parametrize("year", ["0001", "1970", "9000", "9999"])
def test_nobody_can_ask_for_a_time_that_cannot_be_reckoned_with(year: str) -> None:
    with pytest.raises(ValidationError, match="a time between the years 1971 and 8999"):
        JobOrder(goal=("EmptyHanded(gripper_1)",), deadline=f"{year}-06-01T00:00:00Z")  # type: ignore[arg-type]


def test_a_time_that_is_sent_is_taken_over_to_utc() -> None:
    sent = TypeAdapter(WantedMoment).validate_python("2026-11-21T12:00:00+02:00")
    assert sent == datetime(2026, 11, 21, 10, tzinfo=UTC)
    assert sent.tzinfo is UTC
