"""SPARQL queries and their results."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, StrictBool, StrictInt

from skiros_py.api.wire import Answer, Request
from skiros_py.api.world import GivenPose, Number

_LONGEST_TIME = 60.0
"""Maximum time limit of a query [s]."""


class TextLiteral(Request):
    """A text; a plain string would be a name."""

    text: Annotated[str, Field(max_length=65536)] = Field(examples=["pallet A"])
    """The text."""


class DecimalLiteral(Request):
    """A number of the type xsd:decimal; a plain one with a point is an xsd:double."""

    decimal: Annotated[str, Field(pattern=r"^[+-]?\d{1,40}(\.\d{1,40})?$")] = Field(examples=["0.40"])
    """The number."""


Bound = (
    StrictBool
    | StrictInt
    | Number
    | TextLiteral
    | DecimalLiteral
    | GivenPose
    | Annotated[list[Number], Field(max_length=2048)]
    | Annotated[str, Field(min_length=1, max_length=1000)]
)
"""Value of a parameter; a string is the name of an element, a class, a relation or a property."""


class Query(Answer):
    """A query."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        json_schema_extra={
            "examples": [
                {"query": "SELECT ?part { ?part sk:in $place }", "bindings": {"place": "pallet_a"}},
                {"query": "ASK { scene:starter_1 sk:placement ?somewhere }", "entailed": True},
            ]
        },
    )

    query: Annotated[str, Field(min_length=1, max_length=65536)]
    """SELECT, ASK or CONSTRUCT; all prefixes are declared, parameters are written $name."""
    bindings: Annotated[
        dict[Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,99}$")], Bound], Field(max_length=100)
    ] = Field(default_factory=dict)
    """Values of its parameters, by name without $."""
    entailed: bool = False
    """Whether triples entailed by OWL are included."""
    time_limit: Annotated[float, Field(gt=0.0, le=_LONGEST_TIME, allow_inf_nan=False)] = 5.0
    """Time limit [s]."""


class SelectAnswer(Answer):
    """Result of a SELECT."""

    form: Literal["SELECT"]
    """Form of the query."""
    variables: list[str] = Field(examples=[["part"]])
    """The columns."""
    rows: list[dict[str, Any]] = Field(examples=[[{"part": "starter_1"}]])
    """Values by variable: names as strings, literals as values, null if unbound."""


class AskAnswer(Answer):
    """Result of an ASK."""

    form: Literal["ASK"]
    """Form of the query."""
    answer: bool
    """Whether the pattern matches."""


class ConstructAnswer(Answer):
    """Result of a CONSTRUCT."""

    form: Literal["CONSTRUCT"]
    """Form of the query."""
    statements: list[tuple[str, str, Any]]
    """Subject, predicate and object."""
    turtle: str
    """The same as Turtle text."""


QueryAnswer = Annotated[SelectAnswer | AskAnswer | ConstructAnswer, Field(discriminator="form")]
