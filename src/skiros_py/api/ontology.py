"""The ontology on the wire: classes, relations and properties."""

from __future__ import annotations

from pydantic import Field

from skiros_py.api.wire import Answer, Page, Sentence, Told
from skiros_py.api.world import NamedElement, Value


class Term(Answer):
    """A term of the ontology."""

    name: str = Field(examples=["kitting:Starter"])
    """Its name."""
    label: str = Field(examples=["starter"])
    """Its label."""
    comment: str
    """Its meaning."""


class ClassNode(Term):
    """A class with its subclasses; a class with several parents is listed below its primary one."""

    parents: list[str]
    """Its direct superclasses, the primary one first."""
    instances: int
    """Number of elements of it or its subclasses in the scene."""
    children: list[ClassNode]
    """Its direct subclasses, down to the requested depth."""
    children_total: int
    """Number of its direct subclasses."""


class PropertyInfo(Term):
    """A property of elements."""

    datatype: str = Field(examples=["xsd:decimal"])
    """Data type of its values."""
    says: str = Field(examples=["a finite number"])
    """Form of its values, for people."""
    unit: str = Field(examples=["kg"])
    """Unit of its values; empty if they have none."""
    borne_by: list[list[str]]
    """Classes of elements that may have it: at least one class of each group."""


class ClassProperty(PropertyInfo):
    """A property that elements of a class may have."""

    value: Value
    """Value given by the class, or taught for it; null if there is none."""


class RelationInfo(Term):
    """A relation between elements."""

    family: str = Field(examples=["placement"])
    """"placement", "structure", "computed" or "plain"."""
    parents: list[str]
    """Its direct super-relations."""
    subjects: list[list[str]]
    """Required classes of the subject: at least one class of each group."""
    objects: list[list[str]]
    """Required classes of the object: at least one class of each group."""
    place_end: str | None
    """For a placement, the end that is the place: "subject" or "object"."""
    functional: bool
    """Whether a subject has at most one object."""
    inverse: str | None
    """The inverse relation; null if there is none."""
    computed: bool
    """Whether a reasoner computes it on demand."""


PropertyPage = Page[PropertyInfo]
"""Some properties, by name."""


RelationInfoPage = Page[RelationInfo]
"""Some relations, by name."""


class HowMany(Answer):
    """Cardinality of a relation or property for the elements of a class."""

    relation: str = Field(examples=["sk:hasA"])
    """The relation or property."""
    least: int
    """Minimum."""
    most: int | None
    """Maximum; null for any number."""
    of: str | None
    """Class of the counted elements; null for all."""


class ClassUse(Answer):
    """A skill or condition that accepts elements of a class."""

    name: str = Field(examples=["pick"])
    """The skill or condition."""
    argument: str = Field(examples=["object"])
    """Its parameter or argument."""
    class_: str = Field(validation_alias="class", serialization_alias="class", examples=["sk:Manipulatable"])
    """Its class."""


class ClassDetails(Term):
    """A class with its properties and relations."""

    parents: list[str]
    """Its direct superclasses, the primary one first."""
    ancestors: list[str]
    """The class and its superclasses."""
    subclasses: list[str]
    """The class and its subclasses."""
    properties: list[ClassProperty]
    """Properties of its elements."""
    relations_from: list[str]
    """Relations whose subject its elements may be."""
    relations_to: list[str]
    """Relations whose object its elements may be."""
    how_many: list[HowMany]
    """Cardinalities of its elements."""
    instances: int
    """Number of elements of it or its subclasses in the scene."""
    some_instances: list[str]
    """Ids of the first of them."""
    individuals: list[str]
    """Abstract individuals: of the ontology, and learned."""
    skills: list[ClassUse]
    """Skills that accept its elements."""
    conditions: list[ClassUse]
    """Conditions that accept its elements."""


class PlaceOption(NamedElement):
    """A possible place."""

    fits: bool
    """Whether it accepts the element now."""
    why_not: Sentence
    """Why not; empty if it does."""


class PlacementOption(Answer):
    """One placement relation, and the present elements that can be the place."""

    relation: str = Field(examples=["sk:in"])
    """The relation."""
    label: str
    """Its label."""
    accepted: bool
    """Whether skills of the present robots need things of this class to be placed by it."""
    places: list[PlaceOption]
    """Places of the right class, in the order of ids."""
    total: int
    """Total number of places."""
    next: str | None
    """If places are missing: the cursor for reading on, together with relation=<relation>."""


class PlacementOptions(Told):
    """Possible places of an element."""

    class_: str = Field(validation_alias="class", serialization_alias="class", examples=["kitting:Starter"])
    """Class of the element."""
    element: str | None
    """Id of the element, if one was given."""
    options: list[PlacementOption]
    """The possible placement relations."""
