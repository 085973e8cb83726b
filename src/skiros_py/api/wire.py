"""Base classes of all data on the wire, and problem documents (RFC 9457) with faults of fields."""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import cache, lru_cache, partial
from itertools import pairwise
from typing import Annotated, Any, Generic, Self, TypeVar

from pydantic import (
    AfterValidator,
    AwareDatetime,
    BaseModel,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    TypeAdapter,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    computed_field,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from skiros_py.errors import UsageError
from skiros_py.messages import Message, messages_in

_LONGEST_NAME = 200
_YEARS = range(1971, 9000)
"""Accepted years: other times cannot be converted between time zones, or to Unix timestamps."""


@cache
def _field_docstrings(module: str) -> dict[str, dict[str, str]]:
    """Returns the docstrings of the fields in a module, by class and field."""
    found: dict[str, dict[str, str]] = {}
    for statement in ast.parse(inspect.getsource(sys.modules[module])).body:
        if isinstance(statement, ast.ClassDef):
            texts = found.setdefault(statement.name, {})
            for pair in pairwise(statement.body):
                match pair:
                    case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(text))):
                        texts[name] = " ".join(text.split())
    return found


class _Documented(BaseModel):
    """Base whose fields are described, in the OpenAPI document, by the docstrings below them.

    Pydantic's own option ``use_attribute_docstrings`` reads the source at each import, which takes 0.2 s.
    """

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler, /) -> JsonSchemaValue:
        schema = handler(core_schema)
        properties = handler.resolve_ref_schema(schema).get("properties", {})
        for base in cls.__mro__:
            if issubclass(base, _Documented) and base is not _Documented:
                for name, text in _field_docstrings(base.__module__).get(base.__name__, {}).items():
                    field = cls.model_fields[name]
                    properties[field.serialization_alias or field.alias or name].setdefault("description", text)
        return schema


class Request(_Documented):
    """Base of the data sent to the server: unknown fields are refused, since they may be typing errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)


class Answer(_Documented):
    """Base of the data sent by the server: a client ignores fields that only a newer server has."""

    model_config = ConfigDict(frozen=True, extra="ignore", populate_by_name=True, from_attributes=True)

    @classmethod
    def view_of(cls, source: object, /, **others: Any) -> Self:
        """Makes an answer from the attributes of an object with the names of its fields.

        Fields that are answers are made from their objects in the same way.

        Args:
            source: The object; times may be Unix timestamps [s].
            **others: Values of fields that the object lacks, or has in another form.
        """
        same = (name for name in cls.model_fields if name not in others and hasattr(source, name))
        return cls(**{name: getattr(source, name) for name in same}, **others)


def _kept(value: object, check: ValidatorFunctionWrapHandler) -> str:
    return value if isinstance(value, Message) else str(check(value))


Sentence = Annotated[str, WrapValidator(_kept)]
"""A text for people, in English; messages keep what they are made of."""


class SentenceParts(Answer):
    """What a sentence is made of, for callers that say it in another language."""

    template: str = Field(examples=["{subject} is not {relation} {object}"])
    """The sentence with named fields; it identifies the sentence."""
    values: dict[str, Any] = Field(examples=[{"subject": "starter_1", "relation": "in", "object": "kit_1_a"}])
    """Value of each field: a text, or the same parts of another sentence."""


class Told(Answer):
    """Base of answers with sentences for people."""

    @computed_field
    def texts(self) -> dict[str, SentenceParts]:
        """What the sentences in this answer are made of, by sentence; those of plug-ins may be missing."""
        found = messages_in([value for _, value in self])
        return {str(text): SentenceParts(**data) for text, data in found.items()}


T = TypeVar("T")


class Page(Answer, Generic[T]):
    """A list, or a part of it: the form of every list."""

    model_config = ConfigDict(json_schema_serialization_defaults_required=True)

    items: Sequence[T]
    """The entries."""
    next: str | None = None
    """Cursor of the next page; null at the end."""


def _sensible(value: datetime) -> datetime:
    if value.year not in _YEARS:
        raise ValueError(f"a time between the years {_YEARS[0]} and {_YEARS[-1]}")
    return value.astimezone(UTC)


Moment = AwareDatetime
"""A time in a response: UTC (ISO 8601), also one from a machine whose clock stood at 1970."""

WantedMoment = Annotated[AwareDatetime, AfterValidator(_sensible)]
"""A time in a request, with its time zone (ISO 8601); stored and returned as UTC."""

Name = Annotated[str, Field(min_length=1, max_length=_LONGEST_NAME)]
"""Id, label or class."""


def moment(wall: float | None) -> datetime | None:
    """Returns the UTC time of a Unix timestamp [s]; None for None."""
    return None if wall is None else datetime.fromtimestamp(wall, UTC)


class ProblemDetails(BaseModel):
    """A problem document: what is wrong, and what would be right.

    Attributes:
        type: The kind of problem as an identifier (``urn:skiros:problem:<code>``), not an address.
        title: The kind of problem, as text; the same for all of a kind.
        status: The HTTP status.
        detail: What is wrong with this request, and what would be right.
        code: The kind of problem as a name, for programs ("UnknownJobOrderID", "InvalidJobOrderStatus", ...).
        instance: Id of the request, as in the server's log.
        return_status: ISA-95 return status of a job command, as a bit field (OPC 10031-4 v2.00, annex B.2).
        errors: The wrong fields, with reasons.
        texts: What the sentences above are made of, by sentence, for callers that say them in another language.
    """

    model_config = ConfigDict(extra="allow")

    type: str = "about:blank"
    title: str
    status: int
    detail: str = ""
    code: str = ""
    instance: str = ""
    return_status: int | None = None
    errors: list[dict[str, Any]] = Field(default_factory=list)
    texts: dict[str, dict[str, Any]] = Field(default_factory=dict)


_WORDS = {
    "bool": partial(Message, "must be true or false"),
    "int": partial(Message, "must be a whole number"),
    "int_from_float": partial(Message, "must be a whole number"),
    "float": partial(Message, "must be a number"),
    "decimal": partial(Message, "must be a number"),
    "finite_number": partial(Message, "must be a finite number"),
    "string": partial(Message, "must be text"),
    "list": partial(Message, "must be a list"),
    "tuple": partial(Message, "must be a list"),
    "dict": partial(Message, "must be an object with named fields"),
    "mapping": partial(Message, "must be an object with named fields"),
    "model": partial(Message, "must be an object with named fields"),
    "model_attributes": partial(Message, "must be an object with named fields"),
    "none_required": partial(Message, "must be null"),
    "missing": partial(Message, "is missing"),
    "extra_forbidden": partial(Message, "is not known here"),
    "greater_than_equal": partial(Message, "must be at least {ge}"),
    "greater_than": partial(Message, "must be more than {gt}"),
    "less_than_equal": partial(Message, "must be at most {le}"),
    "less_than": partial(Message, "must be less than {lt}"),
    "string_too_short": partial(Message, "must have at least {min_length} characters"),
    "string_too_long": partial(Message, "must have at most {max_length} characters"),
    "string_pattern_mismatch": partial(Message, "must be written as {pattern}"),
    "too_short": partial(Message, "must have at least {min_length} entries"),
    "too_long": partial(Message, "must have at most {max_length} entries"),
    "literal_error": partial(Message, "must be {expected}"),
    "enum": partial(Message, "must be {expected}"),
    "json_invalid": partial(Message, "is not JSON: {error}"),
}
"""Messages by pydantic's kind of error, without the suffixes that all errors of type have."""
_NONE = Message("must not be empty")
_LIMITS = ("ge", "gt", "le", "lt", "min_length", "max_length")


def fault_field(fault: Mapping[str, Any]) -> str:
    """Returns the path of the field that an error is about ("materials.0.class"), without kinds of a union."""
    return ".".join(part for part in map(str, fault["loc"]) if "[" not in part and not part.startswith("constrained-"))


def fault_words(fault: Mapping[str, Any]) -> str:
    """Returns the message for an error of a field, to follow the name of the field.

    Args:
        fault: An error of a ``pydantic.ValidationError``.
    """
    kind, context = str(fault["type"]), {name: _plain(value) for name, value in fault.get("ctx", {}).items()}
    if context.get("min_length") == 1:  # whether signs or entries are lacking
        return _NONE
    words = _WORDS.get(kind) or _WORDS.get(kind.removesuffix("_type").removesuffix("_parsing"))
    if words is None:
        return str(fault["msg"]).removeprefix("Value error, ")
    try:
        return words(**context)
    except LookupError:
        return str(fault["msg"])


@lru_cache(maxsize=256)
def adapter_of(kind: Any) -> TypeAdapter[Any]:
    """Returns what validates and writes data of a type."""
    return TypeAdapter(kind)


def validated(kind: Any, value: Any) -> Any:
    """Returns a value as one of a type.

    Raises:
        UsageError: It is none; the message names the fields that are wrong.
    """
    try:
        return adapter_of(kind).validate_python(value)
    except ValidationError as error:
        faults = [(fault_field(one), fault_words(one)) for one in error.errors(include_url=False)[:5]]
        raise UsageError("; ".join(f"{where}: {words}" if where else words for where, words in faults)) from None


def _plain(value: object) -> object:
    """Returns whole numbers as integers, which are shown without a decimal point."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def fault_limit(fault: Mapping[str, Any]) -> float | int | None:
    """Returns the violated limit; None if the error has none."""
    context = fault.get("ctx", {})
    return next((context[name] for name in _LIMITS if isinstance(context.get(name), int | float)), None)
