"""Goals on the wire: as text, as structured conditions, or as named templates (ISA-95: work masters)."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import ConfigDict, Field, JsonValue, model_validator

from skiros_py.api.wire import Answer, Name, Request

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

    class_: Name = Field(alias="class", description="Class of the material.", examples=["Starter"])
    definition: str = Field(
        default="",
        max_length=200,
        description="Number of the material (ISA-95: material definition).",
        examples=["ST-4"],
    )
    lot: str = Field(default="", max_length=200, description="The lot that it shall be of, for the record.")
    quantity: Annotated[int, Field(ge=1, le=1000)] | Amount = Field(
        default=1,
        description='How many pieces; or, with units, a decimal number as text ("0.25").',
        examples=[1, "0.25"],
    )
    units: str = Field(default="", max_length=40, description="Units of the quantity; empty for pieces.")
    id: str = Field(default="", max_length=200, description="The very piece that is meant; empty for any.")
    location: str = Field(default="", max_length=200, description="Where it shall be.", examples=["kit_1_a"])
    use: str = Field(default="", max_length=200, description="What it is for (ISA-95: material use).")
    properties: dict[Name, PropertyText] = Field(
        default_factory=dict, max_length=20, description="What else is known of it, for the record."
    )

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
        """How many pieces that a goal can speak of; what is measured in units counts as one."""
        return 1 if self.units or isinstance(self.quantity, str) else self.quantity


class GoalOrder(Request):
    """What is wanted: a goal, or a template by name. Exactly one of the two."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"goal": one} for one in _GOALS]})

    goal: Goal | None = Field(
        default=None, description="A text, a structured condition, or a list of either.", examples=_GOALS
    )
    work_master: str = Field(default="", max_length=200, description="Name of the goal template to use instead.")
    parameters: dict[Name, Name] = Field(
        default_factory=dict, max_length=100, description="Values of the template's parameters."
    )
    materials: tuple[Material, ...] = Field(default=(), max_length=1000, description="The material that it is about.")

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.goal is None) == (not self.work_master):
            raise ValueError("give a goal or a work_master (the name of a goal template): one of the two")
        if self.parameters and not self.work_master:
            raise ValueError("parameters are those of a work_master; a goal names its elements itself")
        return self


class CheckedCondition(Answer):
    """One condition of a goal."""

    text: str = Field(description="As text.", examples=["InKit(Starter, kit_1)"])
    data: dict[str, Any] = Field(
        description="As structured data.", examples=[{"condition": "InKit", "arguments": ["kitting:Starter", "kit_1"]}]
    )
    holds: bool = Field(description="Whether it is believed to hold now.")
    why: str = Field(description="What decides that.", examples=["no Starter makes it true for kit_1"])
    lines: tuple[str, ...] = Field(description="The same as a tree, one line a step down.")


class CheckedGoal(Answer):
    """A goal as it was understood."""

    text: str = Field(description="All of it as one text.", examples=["InKit(Starter, kit_1)"])
    conditions: tuple[CheckedCondition, ...] = Field(description="The conditions that must hold together.")
    holds: bool = Field(description="Whether all of them hold now: then nothing would be done.")
    world: int = Field(description="Version of the world for which this is said.", examples=[42])


class GoalTexts(Request):
    """The goals that shall go with the scene."""

    goals: tuple[GoalText | GoalData, ...] = Field(
        max_length=1000, description="Texts or structured conditions; empty for none.", examples=[_GOALS[2]]
    )


class SceneGoals(Answer):
    """The goals that go with the scene."""

    goals: tuple[str, ...] = Field(description="Their texts, sorted.", examples=[["InKit(Starter, kit_1)"]])
    fault: str = Field(default="", description="Why they cannot be understood, where that is so.")


class Role(Answer):
    """One argument of a condition."""

    name: str = Field(examples=["kit"], description="What it is called.")
    class_: str = Field(alias="class", description="Class of what may stand there.", examples=["kitting:Kit"])
    reached: str = Field(
        description="Class of what the present robots can bring about there: the same, or a narrower one.",
        examples=["kitting:Compartment"],
    )


class ConditionWord(Answer):
    """A word of the language of goals."""

    name: str = Field(description="The word.", examples=["InKit"])
    help: str = Field(description="What it means.")
    roles: tuple[Role, ...] = Field(description="Its arguments, in order.")
    abstract: bool = Field(description='Whether an argument may be a class ("any starter").')
    skills: tuple[str, ...] = Field(
        description="Skills of the present robots that change what it is about; empty where none does.",
        examples=[["place"]],
    )


class ConditionWords(Answer):
    """The words of the language of goals."""

    conditions: tuple[ConditionWord, ...] = Field(description="By name.")


class TemplateParameter(Request):
    """Something that an order fills in."""

    name: Name = Field(description="What it is called.", examples=["kit"])
    class_: str = Field(
        default="", alias="class", max_length=200, description="Class of what may fill it.", examples=["Kit"]
    )
    default: str | None = Field(
        default=None, min_length=1, max_length=200, description="What fills it where an order does not."
    )
    description: str = Field(default="", max_length=2000, description="For people.", examples=["the kit to fill"])


class GoalTemplateContent(Request):
    """What a template says: structured conditions with placeholders in the place of names.

    ``{"parameter": NAME}`` is filled by an order's parameter; in ``per_material``, ``{"material": FIELD}`` by a field
    of the material: class, definition, id, location, lot or use.
    """

    description: str = Field(default="", max_length=2000, description="For people.", examples=["fills one kit"])
    parameters: tuple[TemplateParameter, ...] = Field(
        default=(), max_length=100, description="What an order fills in.", examples=[[{"name": "kit", "class": "Kit"}]]
    )
    goal: tuple[GoalData, ...] = Field(
        default=(),
        max_length=1000,
        description="Conditions that must hold together; may be empty where there is one for each material.",
        examples=[[{"condition": "InKit", "arguments": ["Starter", {"parameter": "kit"}]}]],
    )
    per_material: GoalData | None = Field(
        default=None,
        description="A condition for each piece of the ordered material.",
        examples=[{"condition": "InKit", "arguments": [{"material": "class"}, {"parameter": "kit"}]}],
    )


class GoalTemplate(Answer):
    """A template as it is kept."""

    name: str = Field(description="Its name.", examples=["fill kit"])
    version: int = Field(description="Its version, as in its ETag.", examples=[3])
    content: GoalTemplateContent = Field(description="What it says.")


class GoalTemplates(Answer):
    """All templates."""

    templates: tuple[GoalTemplate, ...] = Field(description="By name.")
