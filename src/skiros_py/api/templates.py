"""Goal templates on the wire (ISA-95: work masters): named goals with parameters."""

from __future__ import annotations

from pydantic import Field

from skiros_py.api.goals import GoalData
from skiros_py.api.wire import Answer, Name, Request


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
