"""What all data of the wire has in common."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Any, Self

from pydantic import AfterValidator, AwareDatetime, BaseModel, ConfigDict, Field

_LONGEST_NAME = 200
_YEARS = range(1971, 9000)
"""Beyond these a time can no longer be moved from one time zone to another, or counted from 1970."""


class Request(BaseModel):
    """Base of what is sent to the server: what it does not know is refused, for it may be a slip of the pen."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)


class Answer(BaseModel):
    """Base of what the server answers: a client passes over what a younger server says besides."""

    model_config = ConfigDict(frozen=True, extra="ignore", populate_by_name=True)

    @classmethod
    def view_of(cls, source: object, **others: Any) -> Self:
        """Makes an answer of what has attributes of the same names.

        Args:
            source: Has them; moments may be seconds since 1970.
            **others: Fields that it has not, or in another form.
        """
        same = (name for name in cls.model_fields if name not in others and hasattr(source, name))
        return cls(**{name: getattr(source, name) for name in same}, **others)


def _sensible(value: datetime) -> datetime:
    if value.year not in _YEARS:
        raise ValueError(f"a time between the years {_YEARS[0]} and {_YEARS[-1]}")
    return value.astimezone(UTC)


Moment = AwareDatetime
"""A time as it is answered: UTC (ISO 8601). A machine whose clock stood at 1970 tells that, too."""

WantedMoment = Annotated[AwareDatetime, AfterValidator(_sensible)]
"""A time that somebody sends, with its zone (ISO 8601); kept and answered as UTC."""

Name = Annotated[str, Field(min_length=1, max_length=_LONGEST_NAME)]
"""Id, label or class."""


def moment(wall: float | None) -> datetime | None:
    """Returns the time that is so many seconds after 1970; None for None."""
    return None if wall is None else datetime.fromtimestamp(wall, UTC)
