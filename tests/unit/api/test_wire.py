"""The wire: times of sensible years, in UTC; fields described by their docstrings."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest
from pydantic import Field, TypeAdapter, ValidationError

from skiros_py.api.jobs import JobOrder
from skiros_py.api.wire import Answer, Moment, WantedMoment, moment


def test_a_time_in_1970_is_accepted() -> None:
    begun = moment(0.5)
    assert TypeAdapter(Moment).validate_python(begun) == begun
    assert TypeAdapter(Moment).dump_json(moment(0.0)) == b'"1970-01-01T00:00:00Z"'


@pytest.mark.parametrize("year", ["0001", "1970", "9000", "9999"])
def test_a_time_outside_the_supported_years_is_refused(year: str) -> None:
    with pytest.raises(ValidationError, match="a time between the years 1971 and 8999"):
        JobOrder(goal=("EmptyHanded(gripper_1)",), deadline=f"{year}-06-01T00:00:00Z")  # type: ignore[arg-type]


def test_a_received_time_is_converted_to_utc() -> None:
    sent = TypeAdapter(WantedMoment).validate_python("2026-11-21T12:00:00+02:00")
    assert sent == datetime(2026, 11, 21, 10, tzinfo=UTC)
    assert sent.tzinfo is UTC


class _Base(Answer):
    id: str
    """Names it."""
    size: float = 0.0
    """How large
    it is.
    """


class _Special(_Base):
    id: str
    """Names it here."""
    class_: str = Field(serialization_alias="class", description="Its class.")


def test_docstrings_of_fields_are_their_descriptions_in_the_schema() -> None:
    properties = _Special.model_json_schema(mode="serialization")["properties"]

    assert {name: field["description"] for name, field in properties.items()} == {
        "id": "Names it here.",
        "size": "How large it is.",
        "class": "Its class.",
    }
