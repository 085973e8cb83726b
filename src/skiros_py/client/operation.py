"""Operations of the API, each declared once, by a signature, for blocking and asynchronous clients."""

from __future__ import annotations

import inspect
import re
from collections.abc import Awaitable, Callable, Mapping
from functools import cached_property, partial
from typing import Any, Concatenate, Generic, ParamSpec, Protocol, TypeVar, overload

from pydantic import BaseModel
from pydantic_core import to_jsonable_python

from skiros_py.api.wire import adapter_of, validated
from skiros_py.client.request import Call, path_of

T = TypeVar("T")
P = ParamSpec("P")
C = TypeVar("C", bound="Sender | AsyncSender")
C_co = TypeVar("C_co", bound="Sender | AsyncSender", covariant=True)


class Sender(Protocol):
    """A blocking client, as its topics see it."""

    def send(self, call: Call[T]) -> T:
        """Sends a call and returns its result."""


class AsyncSender(Protocol):
    """An asynchronous client, as its topics see it."""

    async def send(self, call: Call[T]) -> T:
        """Sends a call and returns its result."""


class Topic(Generic[C_co]):
    """A part of a client."""

    def __init__(self, client: C_co) -> None:
        self.client = client


class Operation(Generic[P, T]):
    """An operation, as a method of a topic.

    ``client.jobs.get("kit-17")`` sends the call and returns its result, to be awaited if the client is asynchronous;
    ``Jobs.get("kit-17")``, of the class, returns the call without sending it.

    Args:
        declared: The declaration: its parameters after ``self``, and its docstring, are those of the method.
        make: Creates the call.
    """

    def __init__(self, declared: Callable[..., Any], make: Callable[P, Call[T]]) -> None:
        self._declared = declared
        self._make = make
        self.__doc__ = declared.__doc__

    @cached_property
    def signature(self) -> inspect.Signature:
        """Its parameters and result."""
        return _signature(self._declared)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> Call[T]:
        """Creates the call without sending it."""
        return self._make(*args, **kwargs)

    @overload
    def __get__(self, topic: None, owner: type) -> Operation[P, T]: ...
    @overload
    def __get__(self, topic: Topic[Sender], owner: type) -> Callable[P, T]: ...
    @overload
    def __get__(self, topic: Topic[AsyncSender], owner: type) -> Callable[P, Awaitable[T]]: ...
    def __get__(self, topic: Topic[Any] | None, owner: type) -> Any:
        """Returns the method of one client."""
        if topic is None:
            return self
        send = partial(_send, topic.client, self)
        send.__doc__ = self.__doc__  # for help()
        return send


def _send(client: Sender | AsyncSender, make: Callable[P, Call[T]], /, *args: P.args, **kwargs: P.kwargs) -> Any:
    return client.send(make(*args, **kwargs))


def _signature(declared: Callable[..., Any]) -> inspect.Signature:
    signature = inspect.signature(declared, eval_str=True)
    return signature.replace(parameters=list(signature.parameters.values())[1:])


def operation(
    request: str, *, once: bool = False, **renamed: str
) -> Callable[[Callable[Concatenate[Any, P], T]], Operation[P, T]]:
    """Declares an operation by a method without a body: its parameters are sent, its result is parsed.

    Parameters in braces are part of the path, ``version`` and ``seen`` the header ``If-Match`` (without a version: any,
    and no header), ``language`` the header ``Accept-Language``. Of GET, DELETE, and after a question mark, the others
    are the query; else they are the body: a model as it is, plain values as an object. None is left out.

    Args:
        request: Method and path, as ``POST /simulation/reset?force``.
        once: True if the request must not be repeated when the connection breaks.
        **renamed: Names in the API where they differ from those of the parameters; a last underscore is removed.
    """
    verb, _, address = request.partition(" ")
    path, _, asked = address.partition("?")

    def declare(declared: Callable[Concatenate[Any, P], T]) -> Operation[P, T]:
        def make(*args: P.args, **kwargs: P.kwargs) -> Call[T]:
            bound = made.signature.bind(*args, **kwargs)
            bound.apply_defaults()
            given = bound.arguments
            place = re.sub(r"/\{(\w+)\}", lambda part: path_of(given.pop(part[1])), path)
            headers: dict[str, str | None] = {}
            if "version" in given:
                headers["If-Match"] = tag(given.pop("version")) or "*"
            if "seen" in given:
                headers["If-Match"] = tag(given.pop("seen"))
            if "language" in given:
                headers["Accept-Language"] = given.pop("language")
            values = {renamed.get(name, name.rstrip("_")): value for name, value in given.items()}
            as_query = list(values) if verb in ("GET", "DELETE") else asked.split(",")
            query = {name: to_jsonable_python(values.pop(name)) for name in as_query if name in values}
            json = _json(values, made.signature) if values else None
            result = made.signature.return_annotation
            return Call(verb, place, result, query, json, headers, repeatable=not once)

        made: Operation[P, T] = Operation(declared, make)
        return made

    return declare


def call(declared: Callable[Concatenate[Any, P], Call[T]]) -> Operation[P, T]:
    """Declares an operation by a method that creates the call itself."""
    return Operation(declared, partial(declared, None))


def _json(body: dict[str, Any], signature: inspect.Signature) -> Any:
    for name, value in body.items():
        parameter = signature.parameters.get(name)
        if parameter is not None and _is_model(parameter.annotation):
            return as_json(value, parameter.annotation)
    return to_jsonable_python({name: value for name, value in body.items() if value is not None})


def _is_model(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def as_json(given: BaseModel | Mapping[str, Any], kind: Any) -> Any:
    """Returns what was given to a model as plain data; a subclass of the model is sent without its own fields.

    Args:
        given: The model, or its fields.
        kind: The model's type.

    Raises:
        UsageError: The fields are not those of the model.
    """
    model = given if isinstance(given, BaseModel) else validated(kind, given)
    return adapter_of(kind).dump_python(model, mode="json", by_alias=True, exclude_unset=True)


def tag(version: int | str | None) -> str | None:
    """Returns a version as an ETag; an ETag, and None, as they are."""
    return f'"{version}"' if isinstance(version, int) else version
