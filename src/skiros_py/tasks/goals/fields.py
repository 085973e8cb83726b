"""The fields of goals as plain data, checked by pydantic; see :mod:`skiros_py.tasks.goals.data`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, TypeAdapter

from skiros_py.tasks.goals.said import Joined, Name, Negation, Quantification, Said, Word, implication

_KINDS = ("condition", "not", "all_of", "any_of", "if", "for_all", "exists")


class _Fields(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class WordField(_Fields):
    """A condition's word with its arguments."""

    condition: str
    arguments: list[str]

    def said(self) -> Said:
        """Returns what it says."""
        return Word(self.condition, tuple(map(Name, self.arguments)))


class NotField(_Fields):
    """It must not hold."""

    part: AnyGoal = Field(alias="not")

    def said(self) -> Said:
        """Returns what it says."""
        return Negation(self.part.said())


class AllField(_Fields):
    """All of them hold."""

    all_of: list[AnyGoal] = Field(min_length=1)

    def said(self) -> Said:
        """Returns what it says."""
        return Joined("and", tuple(part.said() for part in self.all_of))


class AnyField(_Fields):
    """At least one of them holds."""

    any_of: list[AnyGoal] = Field(min_length=1)

    def said(self) -> Said:
        """Returns what it says."""
        return Joined("or", tuple(part.said() for part in self.any_of))


class IfField(_Fields):
    """If one condition holds, so does the other."""

    premise: AnyGoal = Field(alias="if")
    then: AnyGoal

    def said(self) -> Said:
        """Returns what it says."""
        return implication((self.premise.said(), self.then.said()))


class ForAllField(_Fields):
    """It holds for all elements of a class."""

    for_all: str
    class_: str = Field(alias="class")
    holds: AnyGoal

    def said(self) -> Said:
        """Returns what it says."""
        return Quantification("for all", self.for_all, self.class_, self.holds.said())


class ExistsField(_Fields):
    """It holds for some element of a class."""

    exists: str
    class_: str = Field(alias="class")
    holds: AnyGoal

    def said(self) -> Said:
        """Returns what it says."""
        return Quantification("exists", self.exists, self.class_, self.holds.said())


def _kind(value: Any) -> str | None:
    """Returns the kind of a goal, from the first field that determines it."""
    if not isinstance(value, Mapping):
        return None
    return next((f"<{kind}>" for kind in _KINDS if kind in value), None)


AnyGoal = Annotated[
    Annotated[WordField, Tag("<condition>")]
    | Annotated[NotField, Tag("<not>")]
    | Annotated[AllField, Tag("<all_of>")]
    | Annotated[AnyField, Tag("<any_of>")]
    | Annotated[IfField, Tag("<if>")]
    | Annotated[ForAllField, Tag("<for_all>")]
    | Annotated[ExistsField, Tag("<exists>")],
    Discriminator(
        _kind,
        custom_error_type="goal",
        custom_error_message=f"expected an object with one of the fields {', '.join(_KINDS)}",
    ),
]

GOALS: TypeAdapter[list[AnyGoal]] = TypeAdapter(list[AnyGoal])
"""A list of goals."""
