"""Goals as plain data, for programs: dictionaries and lists, as JSON has them, checked by pydantic.

::

    {"condition": "InKit", "arguments": ["Starter", "kit_1"]}
    {"not": GOAL}   {"all_of": [GOAL, …]}   {"any_of": [GOAL, …]}   {"if": GOAL, "then": GOAL}
    {"for_all": "c", "class": "Compartment", "holds": GOAL}   {"exists": "p", "class": "Starter", "holds": GOAL}
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, TypeAdapter

from skiros_py.errors import UsageError
from skiros_py.skills.conditions import Condition, ConditionType, Junction, Quantified
from skiros_py.tasks.goals.forms import Joined, Name, Negation, Quantification, Said, Word, implication
from skiros_py.tasks.goals.parsing import goal_of
from skiros_py.world.view import WorldView

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


_LONGEST_PATH = 20


def goal_from_data(data: object, view: WorldView, conditions: Mapping[str, ConditionType]) -> tuple[Condition, ...]:
    """Creates a goal from plain data.

    Args:
        data: One condition, or a list of them that must hold together; see the head of this module.
        view: The world, for elements and classes; an element may be given by id or by its label.
        conditions: The known condition words.

    Returns:
        Conditions that must hold together, each once; what "all_of" joins becomes several.

    Raises:
        UnknownName: A word is unknown; the message gives the nearest that exists.
        UsageError: A field is wrong, and the message gives its path; or the goal makes no sense.
    """
    from pydantic import ValidationError  # imported only when needed: the command line must start quickly

    several = isinstance(data, list | tuple)
    try:
        fields = GOALS.validate_python(data if several else [data])
    except ValidationError as error:
        problems = [(one["loc"] if several else one["loc"][1:], one["msg"]) for one in error.errors()]
        raise UsageError("\n".join(f"goal{_path(loc)}: {_said(message)}" for loc, message in problems)) from None
    return goal_of((one.said() for one in fields), view, conditions)


def goal_as_data(goal: Sequence[Condition]) -> list[dict[str, Any]]:
    """Returns a goal as plain data that :func:`goal_from_data` turns back into the same goal."""
    return [_data(condition) for condition in goal]


def _data(condition: Condition) -> dict[str, Any]:
    if condition.negated:
        return {"not": _data(~condition)}
    match condition:
        case Junction(word=word, parts=parts):
            return {"all_of" if word == "and" else "any_of": [_data(part) for part in parts]}
        case Quantified(quantifier=quantifier, variable=variable, class_=class_, part=part):
            return {quantifier.replace(" ", "_"): variable, "class": class_, "holds": _data(part)}
        case _:
            return {"condition": condition.type.name, "arguments": list(condition.arguments)}


def _path(loc: Sequence[int | str]) -> str:
    """Formats the path to a field ("[0].not.arguments[1]"); names in angle brackets are kinds, not fields."""
    fields = [f"[{name}]" if isinstance(name, int) else f".{name}" for name in loc if not str(name).startswith("<")]
    cut = (
        fields if len(fields) <= _LONGEST_PATH else [*fields[: _LONGEST_PATH // 2], "…", *fields[-_LONGEST_PATH // 2 :]]
    )
    return "".join(cut)


def _said(message: str) -> str:
    return message[:1].lower() + message[1:]
