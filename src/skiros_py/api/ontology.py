"""What may be: classes, relations and properties, as people and forms need them."""

from __future__ import annotations

from pydantic import Field

from skiros_py.api.wire import Answer
from skiros_py.api.world import Value


class ClassNode(Answer):
    """A class with those below it; a class with several parents stands below its primary one."""

    name: str = Field(description="The class.", examples=["kitting:Starter"])
    label: str = Field(description="What people call it.", examples=["starter"])
    comment: str = Field(description="What it means.")
    parents: list[str] = Field(description="Its direct superclasses, the primary one first.")
    instances: int = Field(description="Elements of the scene that are of it or of a class below.")
    children: list[ClassNode] = Field(description="The classes below it, down to the depth that was asked for.")
    children_total: int = Field(description="How many classes stand directly below it.")


class PropertyInfo(Answer):
    """A property of elements."""

    name: str = Field(description="The property.", examples=["sk:mass"])
    label: str = Field(description="What people call it.", examples=["mass"])
    comment: str = Field(description="What it means, with its unit.")
    datatype: str = Field(description="Data type of its values.", examples=["xsd:decimal"])
    says: str = Field(description="What a value looks like, for people.", examples=["a finite number"])
    unit: str = Field(description="Unit of its values; empty where there is none.", examples=["kg"])
    borne_by: list[list[str]] = Field(description="What bears it: of each group one class at least.")


class ClassProperty(PropertyInfo):
    """A property that things of a class may have."""

    value: Value = Field(description="What the class gives, or was taught for it; null for nothing.")


class RelationInfo(Answer):
    """A relation between elements."""

    name: str = Field(description="The relation.", examples=["sk:in"])
    label: str = Field(description="What people call it.", examples=["in"])
    comment: str = Field(description="What it means.")
    family: str = Field(description='"placement", "structure", "computed" or "plain".', examples=["placement"])
    parents: list[str] = Field(description="Its direct super-relations.")
    subjects: list[list[str]] = Field(description="What the subject must be: of each group one class at least.")
    objects: list[list[str]] = Field(description="What the object must be: of each group one class at least.")
    place_end: str | None = Field(description='For a placement, the end that is the place: "subject" or "object".')
    functional: bool = Field(description="True when a subject has at most one object.")
    inverse: str | None = Field(description="The relation that says the same from the other end.")
    computed: bool = Field(description="True when a reasoner here works it out on demand.")


class PropertyPage(Answer):
    """Some properties, by name."""

    items: list[PropertyInfo] = Field(description="The properties.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")


class RelationPage(Answer):
    """Some relations, by name."""

    items: list[RelationInfo] = Field(description="The relations.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")


class HowMany(Answer):
    """How many things individuals of a class have by a relation or property."""

    relation: str = Field(description="The relation or property.", examples=["sk:hasA"])
    least: int = Field(description="The fewest.")
    most: int | None = Field(description="The most; null for any number.")
    of: str | None = Field(description="The class that is counted; null for all.")


class ClassUse(Answer):
    """A place where something takes elements of a class."""

    name: str = Field(description="The skill or condition.", examples=["pick"])
    argument: str = Field(description="Its parameter or argument.", examples=["object"])
    class_: str = Field(
        validation_alias="class",
        serialization_alias="class",
        description="What that may be.",
        examples=["sk:Manipulatable"],
    )


class ClassDetails(Answer):
    """Everything about one class."""

    name: str = Field(description="The class.", examples=["kitting:Starter"])
    label: str = Field(description="What people call it.")
    comment: str = Field(description="What it means.")
    parents: list[str] = Field(description="Its direct superclasses, the primary one first.")
    ancestors: list[str] = Field(description="The class and everything above it.")
    subclasses: list[str] = Field(description="The class and everything below it.")
    properties: list[ClassProperty] = Field(description="What its things may have.")
    relations_from: list[str] = Field(description="Relations whose subject its things may be.")
    relations_to: list[str] = Field(description="Relations whose object its things may be.")
    how_many: list[HowMany] = Field(description="How many things its things have.")
    instances: int = Field(description="Elements of the scene that are of it or of a class below.")
    some_instances: list[str] = Field(description="Ids of the first of them.")
    individuals: list[str] = Field(description="Abstract individuals: of the ontology, and learned.")
    skills: list[ClassUse] = Field(description="Skills that take its things.")
    conditions: list[ClassUse] = Field(description="Conditions about its things.")


class PlaceOption(Answer):
    """A place that might take something."""

    id: str = Field(description="Id of the place.", examples=["kit_1_a"])
    class_: str = Field(
        validation_alias="class",
        serialization_alias="class",
        description="Its class.",
        examples=["kitting:Compartment"],
    )
    label: str = Field(description="What people call it.")
    fits: bool = Field(description="Whether it would take it now.")
    why_not: str = Field(description="Why it would not; empty where it would.")


class PlacementOption(Answer):
    """One placement relation, and the present elements that can be the place."""

    relation: str = Field(description="The relation.", examples=["sk:in"])
    label: str = Field(description="What people call it.")
    places: list[PlaceOption] = Field(description="Places of the right class, in the order of ids.")
    total: int = Field(description="How many there are.")
    next: str | None = Field(
        description="Where not all are here: the cursor to go on with, together with relation=<relation>."
    )


class PlacementOptions(Answer):
    """Where something may be put."""

    class_: str = Field(
        validation_alias="class", serialization_alias="class", description="What is put.", examples=["kitting:Starter"]
    )
    element: str | None = Field(description="Which element, where one was named.")
    options: list[PlacementOption] = Field(description="The relations by which it may be placed.")
