"""What may be: classes, relations and properties, as people and forms need them."""

from __future__ import annotations

from pydantic import Field

from skiros_py.api.wire import Answer, Page
from skiros_py.api.world import Value


class ClassNode(Answer):
    """A class with those below it; a class with several parents stands below its primary one."""

    name: str = Field(examples=["kitting:Starter"])
    """The class."""
    label: str = Field(examples=["starter"])
    """What people call it."""
    comment: str
    """What it means."""
    parents: list[str]
    """Its direct superclasses, the primary one first."""
    instances: int
    """Elements of the scene that are of it or of a class below."""
    children: list[ClassNode]
    """The classes below it, down to the depth that was asked for."""
    children_total: int
    """How many classes stand directly below it."""


class PropertyInfo(Answer):
    """A property of elements."""

    name: str = Field(examples=["sk:mass"])
    """The property."""
    label: str = Field(examples=["mass"])
    """What people call it."""
    comment: str
    """What it means, with its unit."""
    datatype: str = Field(examples=["xsd:decimal"])
    """Data type of its values."""
    says: str = Field(examples=["a finite number"])
    """What a value looks like, for people."""
    unit: str = Field(examples=["kg"])
    """Unit of its values; empty where there is none."""
    borne_by: list[list[str]]
    """What bears it: of each group one class at least."""


class ClassProperty(PropertyInfo):
    """A property that things of a class may have."""

    value: Value
    """What the class gives, or was taught for it; null for nothing."""


class RelationInfo(Answer):
    """A relation between elements."""

    name: str = Field(examples=["sk:in"])
    """The relation."""
    label: str = Field(examples=["in"])
    """What people call it."""
    comment: str
    """What it means."""
    family: str = Field(examples=["placement"])
    """"placement", "structure", "computed" or "plain"."""
    parents: list[str]
    """Its direct super-relations."""
    subjects: list[list[str]]
    """What the subject must be: of each group one class at least."""
    objects: list[list[str]]
    """What the object must be: of each group one class at least."""
    place_end: str | None
    """For a placement, the end that is the place: "subject" or "object"."""
    functional: bool
    """True when a subject has at most one object."""
    inverse: str | None
    """The relation that says the same from the other end."""
    computed: bool
    """True when a reasoner here works it out on demand."""


PropertyPage = Page[PropertyInfo]
"""Some properties, by name."""


RelationInfoPage = Page[RelationInfo]
"""Some relations, by name."""


class HowMany(Answer):
    """How many things individuals of a class have by a relation or property."""

    relation: str = Field(examples=["sk:hasA"])
    """The relation or property."""
    least: int
    """The fewest."""
    most: int | None
    """The most; null for any number."""
    of: str | None
    """The class that is counted; null for all."""


class ClassUse(Answer):
    """A place where something takes elements of a class."""

    name: str = Field(examples=["pick"])
    """The skill or condition."""
    argument: str = Field(examples=["object"])
    """Its parameter or argument."""
    class_: str = Field(validation_alias="class", serialization_alias="class", examples=["sk:Manipulatable"])
    """What that may be."""


class ClassDetails(Answer):
    """Everything about one class."""

    name: str = Field(examples=["kitting:Starter"])
    """The class."""
    label: str
    """What people call it."""
    comment: str
    """What it means."""
    parents: list[str]
    """Its direct superclasses, the primary one first."""
    ancestors: list[str]
    """The class and everything above it."""
    subclasses: list[str]
    """The class and everything below it."""
    properties: list[ClassProperty]
    """What its things may have."""
    relations_from: list[str]
    """Relations whose subject its things may be."""
    relations_to: list[str]
    """Relations whose object its things may be."""
    how_many: list[HowMany]
    """How many things its things have."""
    instances: int
    """Elements of the scene that are of it or of a class below."""
    some_instances: list[str]
    """Ids of the first of them."""
    individuals: list[str]
    """Abstract individuals: of the ontology, and learned."""
    skills: list[ClassUse]
    """Skills that take its things."""
    conditions: list[ClassUse]
    """Conditions about its things."""


class PlaceOption(Answer):
    """A place that might take something."""

    id: str = Field(examples=["kit_1_a"])
    """Id of the place."""
    class_: str = Field(validation_alias="class", serialization_alias="class", examples=["kitting:Compartment"])
    """Its class."""
    label: str
    """What people call it."""
    fits: bool
    """Whether it would take it now."""
    why_not: str
    """Why it would not; empty where it would."""


class PlacementOption(Answer):
    """One placement relation, and the present elements that can be the place."""

    relation: str = Field(examples=["sk:in"])
    """The relation."""
    label: str
    """What people call it."""
    places: list[PlaceOption]
    """Places of the right class, in the order of ids."""
    total: int
    """How many there are."""
    next: str | None
    """Where not all are here: the cursor to go on with, together with relation=<relation>."""


class PlacementOptions(Answer):
    """Where something may be put."""

    class_: str = Field(validation_alias="class", serialization_alias="class", examples=["kitting:Starter"])
    """What is put."""
    element: str | None
    """Which element, where one was named."""
    options: list[PlacementOption]
    """The relations by which it may be placed."""
