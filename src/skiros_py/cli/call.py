"""``skiros call``: any operation of a server's API, with its result as JSON."""

from __future__ import annotations

import inspect
import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import GenericAlias
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.commands import SERVER
from skiros_py.cli.options import JSON, key_values
from skiros_py.cli.output import REACHED, tell
from skiros_py.cli.server_choice import reach
from skiros_py.errors import UnknownName, UsageError
from skiros_py.files import read_text

if TYPE_CHECKING:
    from skiros_py.client.operation import Operation


@click.command("call", epilog="Example: skiros call scenes.load name=kitting --data cell")
@click.argument("operation", required=False)
@click.argument("arguments", nargs=-1, metavar="[NAME=VALUE]...")
@SERVER
@JSON
def command(
    operation: str | None,
    arguments: tuple[str, ...],
    data: Path | None,
    url: str | None,
    key_file: Path | None,
    *,
    as_json: bool,
) -> int:
    """Calls an OPERATION of a server and prints its result as JSON; without OPERATION, lists all operations.

    A VALUE is text or JSON; @FILE takes the content of a file. Pictures and other files are written to stdout as they
    are.
    """
    known = dict(operations())
    if operation is None and as_json:
        return tell({name: list(method.signature.parameters) for name, method in known.items()}, as_json=True)
    if operation is None:
        for name, method in known.items():
            click.echo(f"{name}{_parameters(method)}\n    {inspect.cleandoc(method.__doc__ or '').splitlines()[0]}")
        return REACHED
    if operation not in known:
        raise UnknownName("operation", operation, known)
    call = _call(known[operation], arguments)
    with reach(data, url, key_file) as client:
        result = client.send(call)
    if isinstance(result, bytes):
        sys.stdout.buffer.write(result)
    elif isinstance(result, str):
        click.echo(result)
    elif result is not None:
        tell(result, as_json=True)
    return REACHED


def operations() -> Iterator[tuple[str, Operation[..., Any]]]:
    """Yields the operations of the client, by name ("scenes.load")."""
    from skiros_py.client.operation import Operation
    from skiros_py.client.topics import Topics

    for topic, part in vars(Topics[Any](None)).items():
        for name, method in vars(type(part)).items():
            if isinstance(method, Operation):
                yield f"{topic}.{name}", method


def _parameters(method: Operation[..., Any]) -> str:
    parameters = method.signature.parameters.values()
    return "".join(f" {p.name}=…" if p.default is p.empty else f" [{p.name}=…]" for p in parameters)


def _call(method: Operation[..., Any], texts: Sequence[str]) -> Any:
    """Returns the call of an operation with arguments given as texts.

    Raises:
        UsageError: An argument is unknown, missing or invalid.
        FileError: The file of an argument cannot be read.
    """
    parameters = method.signature.parameters
    given = key_values("call", texts, "name=kitting")
    if unknown := next((name for name in given if name not in parameters), None):
        raise UnknownName("argument", unknown, parameters)
    values = {name: _value(text, parameters[name]) for name, text in given.items()}
    several = [one for p in parameters.values() if p.kind is p.VAR_POSITIONAL for one in values.pop(p.name, ())]
    try:
        return method(*several, **values)
    except TypeError as error:
        raise UsageError(f"{error}; needed:{_parameters(method)}") from None


def _value(text: str, parameter: inspect.Parameter) -> Any:
    from skiros_py.api.wire import validated

    if text.startswith("@"):
        text = read_text(Path(text[1:]))
    kind: Any = parameter.annotation
    if parameter.kind is parameter.VAR_POSITIONAL:
        kind = GenericAlias(tuple, (kind, ...))
    try:
        return validated(kind, text)
    except UsageError as error:
        refusal = str(error)
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        raise UsageError(f"{parameter.name}: {refusal}; what is not text is written as JSON") from None
    try:
        return validated(kind, value)
    except UsageError as error:
        raise UsageError(f"{parameter.name}: {error}") from None
