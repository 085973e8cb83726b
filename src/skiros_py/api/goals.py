"""Goals on the wire: as text, as structured conditions, or as named templates (ISA-95: work masters)."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import ConfigDict, Field, JsonValue, model_validator

from skiros_py.api.wire import Answer, Name, Page, Request, Sentence, Told

_LONGEST_TEXT = 20_000

Amount = Annotated[str, Field(pattern=r"^[0-9]{1,12}(\.[0-9]{1,9})?$")]
PropertyText = Annotated[str, Field(max_length=500)]

GoalText = Annotated[str, Field(min_length=1, max_length=_LONGEST_TEXT)]
GoalData = dict[str, JsonValue]
"""A structured condition: ``{"condition": "InKit", "arguments": ["Starter", "kit_1"]}``, ``{"not": GOAL}``,
``{"all_of": [GOAL, …]}``, ``{"any_of": [GOAL, …]}``, ``{"if": GOAL, "then": GOAL}``,
``{"for_all": "c", "class": "Compartment", "holds": GOAL}``, ``{"exists": "p", "class": "Starter", "holds": GOAL}``."""

Goal = GoalText | GoalData | Annotated[tuple[GoalText | GoalData, ...], Field(min_length=1, max_length=1000)]
"""A text, a structured condition, or a list of either, which must hold together."""

_GOALS: list[Any] = [
    "InKit(Starter, kit_1)",
    {"condition": "InKit", "arguments": ["Starter", "kit_1"]},
    ["InKit(Starter, kit_1)", {"not": {"condition": "LocationEmpty", "arguments": ["kit_1_a"]}}],
]


class Material(Request):
    """Material that an order is about (ISA-95: material requirement)."""

    class_: Name = Field(alias="class", examples=["Starter"])
    """Class of the material."""
    definition: str = Field(default="", max_length=200, examples=["ST-4"])
    """Number of the material (ISA-95: material definition)."""
    lot: str = Field(default="", max_length=200)
    """Required lot, for the record."""
    quantity: Annotated[int, Field(ge=1, le=1000)] | Amount = Field(default=1, examples=[1, "0.25"])
    """How many pieces; or, with units, a decimal number as text ("0.25")."""
    units: str = Field(default="", max_length=40)
    """Units of the quantity; empty for pieces."""
    id: str = Field(default="", max_length=200)
    """Id of a specific piece; empty for any."""
    location: str = Field(default="", max_length=200, examples=["kit_1_a"])
    """Where it is to be used."""
    use: str = Field(default="", max_length=200)
    """Its use (ISA-95: material use)."""
    properties: dict[Name, PropertyText] = Field(default_factory=dict, max_length=20)
    """Further properties, for the record."""

    @model_validator(mode="before")
    @classmethod
    def _whole_number(cls, data: Any) -> Any:
        """Reads "3" as 3, for pieces."""
        if isinstance(data, dict) and isinstance(number := data.get("quantity"), str) and number.isdecimal():
            return data | {"quantity": int(number[:20])}
        return data

    @model_validator(mode="after")
    def _units(self) -> Self:
        if isinstance(self.quantity, str) and not self.units:
            raise ValueError("quantity: a whole number of pieces from 1 to 1000, or a decimal number with units")
        return self

    @property
    def pieces(self) -> int:
        """Number of pieces for goals; material measured in units counts as one piece."""
        return 1 if self.units or isinstance(self.quantity, str) else self.quantity


class GoalOrder(Request):
    """A goal, or the name of a goal template: exactly one of the two."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"goal": one} for one in _GOALS]})

    goal: Goal | None = Field(default=None, examples=_GOALS)
    """A text, a structured condition, or a list of either."""
    work_master: str = Field(default="", max_length=200)
    """Name of the goal template to use instead."""
    parameters: dict[Name, Name] = Field(default_factory=dict, max_length=100)
    """Values of the template's parameters."""
    materials: tuple[Material, ...] = Field(default=(), max_length=1000)
    """The required material."""

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.goal is None) == (not self.work_master):
            raise ValueError("give a goal or a work_master (the name of a goal template): one of the two")
        if self.parameters and not self.work_master:
            raise ValueError("parameters are those of a work_master; a goal names its elements itself")
        return self


class CheckedCondition(Answer):
    """One condition of a goal."""

    text: str = Field(examples=["InKit(Starter, kit_1)"])
    """As text."""
    data: dict[str, Any] = Field(examples=[{"condition": "InKit", "arguments": ["kitting:Starter", "kit_1"]}])
    """As structured data."""
    holds: bool
    """Whether it is believed to hold now."""
    why: Sentence = Field(examples=["no Starter makes it true for kit_1"])
    """The deciding reason."""
    lines: tuple[Sentence, ...]
    """The reasons as a tree, indented by level."""


class CheckedGoal(Told):
    """A parsed goal."""

    text: str = Field(examples=["InKit(Starter, kit_1)"])
    """The whole goal as text."""
    conditions: tuple[CheckedCondition, ...]
    """The conditions that must hold together."""
    holds: bool
    """Whether all of them hold now: then nothing needs to be done."""
    world: int = Field(examples=[42])
    """Version of the world to which this applies."""


class GoalTexts(Request):
    """The goals to store with the scene."""

    goals: tuple[GoalText | GoalData, ...] = Field(max_length=1000, examples=[_GOALS[2]])
    """Texts or structured conditions; empty for none."""


class SceneGoals(Told):
    """The goals stored with the scene."""

    goals: tuple[str, ...] = Field(examples=[["InKit(Starter, kit_1)"]])
    """Their texts, sorted."""
    fault: Sentence = ""
    """Why they cannot be parsed; empty if they can."""


class Role(Answer):
    """One argument of a condition."""

    name: str = Field(examples=["kit"])
    """Its name."""
    class_: str = Field(alias="class", examples=["kitting:Kit"])
    """Class of permitted elements."""
    reached: str = Field(examples=["kitting:Compartment"])
    """Class of elements for which the present robots can achieve it: the same, or a narrower one."""


class ConditionWord(Answer):
    """A condition of the goal language."""

    name: str = Field(examples=["InKit"])
    """Its name."""
    help: str
    """Its meaning."""
    roles: tuple[Role, ...]
    """Its arguments, in order."""
    abstract: bool
    """Whether an argument may be a class ("any starter")."""
    skills: tuple[str, ...] = Field(examples=[["place"]])
    """Skills of the present robots that can affect it; empty if none can."""


ConditionWords = Page[ConditionWord]
"""The conditions of the goal language, by name."""


class TemplateParameter(Request):
    """A parameter of a goal template."""

    name: Name = Field(examples=["kit"])
    """Its name."""
    class_: str = Field(default="", alias="class", max_length=200, examples=["Kit"])
    """Class of permitted elements."""
    default: str | None = Field(default=None, min_length=1, max_length=200)
    """Its default."""
    description: str = Field(default="", max_length=2000, examples=["the kit to fill"])
    """Description, for people."""


class GoalTemplateContent(Request):
    """What a template says: structured conditions with placeholders in the place of names.

    ``{"parameter": NAME}`` is filled by an order's parameter; in ``per_material``, ``{"material": FIELD}`` by a field
    of the material: class, definition, id, location, lot or use.
    """

    description: str = Field(default="", max_length=2000, examples=["fills one kit"])
    """Description, for people."""
    parameters: tuple[TemplateParameter, ...] = Field(
        default=(), max_length=100, examples=[[{"name": "kit", "class": "Kit"}]]
    )
    """Its parameters."""
    goal: tuple[GoalData, ...] = Field(
        default=(), max_length=1000, examples=[[{"condition": "InKit", "arguments": ["Starter", {"parameter": "kit"}]}]]
    )
    """Conditions that must hold together; may be empty if there is one for each material."""
    per_material: GoalData | None = Field(
        default=None, examples=[{"condition": "InKit", "arguments": [{"material": "class"}, {"parameter": "kit"}]}]
    )
    """A condition for each piece of the ordered material."""
