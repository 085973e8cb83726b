"""Elements of the world, as they are told and written."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from skiros_py.api.values import ElementId, GivenValue, Name, Placement, Pose, Reason, Value
from skiros_py.api.wire import Answer, Request


class ElementSummary(Answer):
    """One element in a list."""

    id: str = Field(description="Its id; never used again after removal.", examples=["starter_1"])
    class_: str = Field(
        validation_alias="class",
        serialization_alias="class",
        description="Its most specific class.",
        examples=["kitting:Starter"],
    )
    label: str = Field(description="What people call it.", examples=["starter"])
    placement: Placement | None = Field(description="Where it is; null for what is nowhere, or goes with its owner.")
    abstract: bool = Field(description="True for what the ontology describes or what was learned, not really there.")
    version: int = Field(description="Number of the change that touched it last; its ETag.", examples=[17])


class Property(Answer):
    """What an element has as the value of a property."""

    value: Value = Field(description="The value; poses as position and orientation.", examples=[0.4])
    origin: Literal["own", "taught", "class"] = Field(
        description="Whether the element has it itself, it was taught for its class, or its class gives it."
    )
    taught_by: str | None = Field(default=None, description="For what was taught: the learned element that says it.")


class Relation(Answer):
    """A relation that holds."""

    subject: str = Field(examples=["starter_1"], description="Id of the subject.")
    relation: str = Field(examples=["sk:in"], description="The relation.")
    object: str = Field(examples=["pallet_a"], description="Id of the object.")
    family: str = Field(
        examples=["placement"], description='What the relation is for: "placement", "structure", "computed" or "plain".'
    )


class ElementDetails(ElementSummary):
    """Everything about one element."""

    changed_at: float = Field(description="When it was changed last [s, run time].", examples=[12.5])
    properties: dict[str, Property] = Field(description="Values by property.")
    relations: list[Relation] = Field(description="What is stated of it, in both directions: the first 200.")
    relations_total: int = Field(description="How many relations are stated of it.")
    computed: list[Relation] = Field(
        description="Computed relations, those that were asked for: of each the first 200 in either direction."
    )
    owner: str | None = Field(description="What it is a piece of.")
    map_pose: Pose | None = Field(description="Its pose in the map, where that is known.")


class ElementPage(Answer):
    """Some elements, in the order of their ids."""

    items: list[ElementSummary] = Field(description="The elements.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")


class RelationPage(Answer):
    """Some relations, in order."""

    items: list[Relation] = Field(description="The relations.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")


class NewRelation(Request):
    """A relation of a new element: the end that is left out is the element."""

    subject: ElementId | None = Field(default=None, description="Id of the subject.", examples=["kit_1"])
    relation: Name = Field(description="The relation.", examples=["sk:hasA"])
    object: ElementId | None = Field(default=None, description="Id of the object.")


class Addition(Request):
    """What is added."""

    class_: Name | None = Field(
        default=None,
        validation_alias="class",
        serialization_alias="class",
        description="Its class; not together with `like`.",
        examples=["kitting:Starter"],
    )
    like: ElementId | None = Field(
        default=None,
        description="Copied with its pieces: an abstract individual, or another element. Instead of a class.",
        examples=["kitting:standard_kit"],
    )
    id: ElementId | None = Field(
        default=None, description="Its id; the next of its class where left out. A copy always gets the next one."
    )
    label: Annotated[str, Field(min_length=1, max_length=1000)] | None = Field(
        default=None, description="What people call it; its class's name where left out."
    )
    properties: Annotated[dict[Name, GivenValue], Field(max_length=200)] = Field(
        default_factory=dict, description="Own values by property.", examples=[{"sk:mass": 0.4}]
    )
    placement: Placement | None = Field(default=None, description="Where it is.")
    relations: Annotated[list[NewRelation], Field(max_length=200)] = Field(
        default_factory=list, description="Relations of it, such as whose piece it is."
    )

    @model_validator(mode="after")
    def _says_what(self) -> Self:
        if (self.class_ is None) == (self.like is None):
            raise ValueError("say what is added: either 'class', or 'like' for a copy")
        if self.like is not None and self.id is not None:
            raise ValueError("a copy gets the next id of its class: leave out 'id'")
        return self


class NewElement(Addition):
    """An element to be added."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "class": "kitting:Starter",
                    "label": "spare starter",
                    "placement": {"relation": "sk:in", "place": "pallet_a"},
                    "reason": "delivered this morning",
                },
                {"like": "kitting:standard_kit", "placement": {"relation": "sk:on", "place": "kit_table"}},
            ]
        },
    )

    reason: Reason = Field(default="", description="Why, for people.", examples=["delivered this morning"])


class ElementPatch(Request):
    """What becomes different of an element, all at once; what is left out stays."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "label": "starter, dented",
                    "properties": {"sk:mass": 0.41, "sk:pose": {"position": [0.1, 0.0, 0.0], "frame": "pallet_a"}},
                    "placement": {"relation": "sk:in", "place": "pallet_a"},
                    "reason": "weighed",
                }
            ]
        },
    )

    label: Annotated[str, Field(min_length=1, max_length=1000)] | None = Field(
        default=None, description="What people call it."
    )
    properties: Annotated[dict[Name, GivenValue | None], Field(max_length=200)] = Field(
        default_factory=dict,
        description="Own values by property; null takes the own value away.",
        examples=[{"sk:mass": 0.4, "sk:graspHeight": None}],
    )
    placement: Placement | None = Field(default=None, description="Where it is from now on.")
    reason: Reason = Field(default="", description="Why, for people.", examples=["weighed"])


class TreeNode(Answer):
    """An element with what is placed there and what it is built of."""

    id: str = Field(description='Its id; "" for the node above everything.', examples=["pallet_a"])
    class_: str = Field(
        validation_alias="class", serialization_alias="class", description="Its class.", examples=["kitting:Pallet"]
    )
    label: str = Field(description="What people call it.", examples=["pallet A"])
    relation: str = Field(description="The relation by which it hangs on the node above.", examples=["sk:on"])
    version: int = Field(description="Number of the change that touched it last; its ETag.")
    children: list[TreeNode] = Field(description="What hangs on it, in the order of ids; perhaps not all.")
    children_total: int = Field(description="How many hang on it.")
    next: str | None = Field(
        description="Where not all children are here: the cursor to go on with, together with root=<id>."
    )
