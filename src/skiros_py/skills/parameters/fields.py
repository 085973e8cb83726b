"""Parameters of primitives: fields of their ``Params`` dataclass."""

from __future__ import annotations

import dataclasses
from typing import Any

from skiros_py.errors import DescriptionError
from skiros_py.skills.parameters.checks import check_params
from skiros_py.skills.parameters.param import Access, Kind, Param, ValueClass


def param(
    type_: str | ValueClass,
    help_: str,
    *,
    kind: Kind | None = None,
    default: Any = dataclasses.MISSING,
    unit: str = "",
    length: int = 1,
    access: Access = Access.EXCLUSIVE,
) -> Any:
    """Declares one field of a primitive's ``Params`` dataclass; see :class:`Param`.

    Where no kind is said, a field with a default is OFFLINE and one without is ONLINE.
    """
    if kind is None:
        kind = Kind.ONLINE if default is dataclasses.MISSING else Kind.OFFLINE
    metadata = {"type": type_, "help": help_, "kind": kind, "unit": unit, "length": length, "access": access}
    return dataclasses.field(default=default, metadata=metadata)


def params_of(dataclass_type: type) -> tuple[Param, ...]:
    """Reads the parameters that a ``Params`` dataclass declares.

    Raises:
        DescriptionError: A field was not declared with :func:`param`, or is no sound parameter.
        UnknownName: A field has a type that there is not.
    """
    params = tuple(_read(dataclass_type, field) for field in dataclasses.fields(dataclass_type))
    check_params(params, f"of {dataclass_type.__qualname__}")
    return params


def _read(owner: type, field: dataclasses.Field[Any]) -> Param:
    if "help" not in field.metadata:
        raise DescriptionError(f"{owner.__qualname__}.{field.name}: declare it with param(type, help, …)")
    said = dict(field.metadata)
    default = None if field.default is dataclasses.MISSING else field.default
    return Param(field.name, said.pop("type"), said.pop("help"), default=default, **said)
