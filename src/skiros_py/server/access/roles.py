"""Roles, the role that a route requires, and the query parameters it knows."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeVar
from urllib.parse import quote
from weakref import WeakKeyDictionary

from fastapi import Depends, Request, Response
from fastapi.dependencies.utils import get_flat_params
from fastapi.params import Query
from fastapi.routing import APIRoute

from skiros_py.errors import UnknownName
from skiros_py.server.problems import Problem, etag
from skiros_py.station.requests import Author

if TYPE_CHECKING:
    from skiros_py.server.services import Services
    from skiros_py.station.station import Station


V = TypeVar("V")


def check_query(request: Request) -> None:
    """Checks that the route has all query parameters of a request.

    Raises:
        Problem: A parameter is unknown (422); the text names the most similar known one.
    """
    if not request.query_params:
        return
    route: APIRoute = request.scope["route"]
    known = _KNOWN.get(route.endpoint)
    if known is None:
        queries = (field for field in get_flat_params(route.dependant) if isinstance(field.field_info, Query))
        known = _KNOWN.setdefault(route.endpoint, frozenset(field.alias for field in queries))
    for name in request.query_params:
        if name not in known:
            raise Problem(422, "InvalidRequest", str(UnknownName("query parameter", name, known)))


_KNOWN: WeakKeyDictionary[Callable[..., Any], frozenset[str]] = WeakKeyDictionary()
"""The parameters of a route's function; determined at its first request."""


LOCAL = "local"
"""Used instead of a key by programs that can read the data directory; they name their user themselves."""


class Role(enum.StrEnum):
    """Permissions of a caller; each of the first four roles includes those before it."""

    VIEWER = "viewer"
    """Only reads."""
    OPERATOR = "operator"
    """Edits scenes, orders and commands jobs, answers the robots' questions, stops everything."""
    ENGINEER = "engineer"
    """Runs single modules, jogs robots, teaches, makes SPARQL queries."""
    ADMIN = "admin"
    """Creates and revokes keys, reads the audit log, sets up webhooks."""
    MES = "mes"
    """A factory system: orders and commands jobs, follows them, stops everything; nothing else."""


_RANK = {Role.VIEWER: 0, Role.OPERATOR: 1, Role.ENGINEER: 2, Role.ADMIN: 3}


@dataclass(frozen=True, slots=True)
class Caller:
    """The caller of a request.

    Attributes:
        name: The name of the caller's key; author of its changes.
        role: Role of the caller.
        key: Id of the caller's key; empty if none is needed.
    """

    name: str
    role: Role
    key: str = ""

    @property
    def holder(self) -> str:
        """Identity as holder of locks: callers of the same name are distinguished by their keys."""
        return f"key {self.key}" if self.key not in ("", LOCAL) else self.name

    @property
    def author(self) -> Author:
        """The author of the caller's changes."""
        return Author(self.name, self.holder)


@dataclass(frozen=True, slots=True)
class Act:
    """A request by somebody who may make it; first parameter of each route.

    Attributes:
        request: The request.
        response: Its answer: headers and status.
    """

    request: Request
    response: Response

    @property
    def services(self) -> Services:
        """All services of the server."""
        services: Services = self.request.app.state.services
        return services

    @property
    def station(self) -> Station:
        """The use cases."""
        return self.services.station

    @property
    def caller(self) -> Caller:
        """The caller."""
        caller: Caller = self.request.state.caller
        return caller

    @property
    def author(self) -> Author:
        """The author of the caller's changes."""
        return self.caller.author

    def tag(self, version: int) -> None:
        """Puts a version into the headers of the answer."""
        self.response.headers["ETag"] = etag(version)

    def tagged(self, found: V, version: int | None = None) -> V:
        """Returns a resource, with its version in the headers of the answer.

        Args:
            found: The resource.
            version: Its version; that in its ``version`` if omitted.
        """
        self.tag(found.version if version is None else version)  # type: ignore[attr-defined]
        return found

    def locate(self, *parts: str) -> None:
        """Puts the address of a resource below ``/api/v1``, as browsers see it, into the headers of the answer."""
        api = f"{self.services.settings.prefix}/api/v1"
        self.response.headers["Location"] = "/".join((api, *(quote(part, safe="") for part in parts)))


@dataclass(frozen=True, slots=True)
class Need:
    """The role that a route requires; a FastAPI dependency.

    Attributes:
        least: The lowest permitted role.
        mes: Whether a factory system is permitted, too.
    """

    least: Role
    mes: bool = False

    def allows(self, role: Role) -> bool:
        """Returns whether a role is permitted."""
        return self.mes if role is Role.MES else _RANK[role] >= _RANK[self.least]

    async def __call__(self, request: Request, response: Response) -> Act:
        """Returns the request if its caller is permitted.

        Raises:
            Problem: The caller's role does not permit it.
        """
        caller: Caller = request.state.caller
        if not self.allows(caller.role):
            also = " or mes" if self.mes else ""
            raise Problem(
                403, "RoleTooLow", f"that takes the role {self.least}{also} at least; {caller.name} is {caller.role}"
            )
        check_query(request)  # here, since every route that does something requires a role
        return Act(request, response)


async def _anybody(request: Request, response: Response) -> Act:  # not in the thread pool, which may be full
    return Act(request, response)


Anybody = Annotated[Act, Depends(_anybody)]
"""For routes that need no role."""
Viewer = Annotated[Act, Depends(Need(Role.VIEWER))]
ViewerOrMes = Annotated[Act, Depends(Need(Role.VIEWER, mes=True))]
Operator = Annotated[Act, Depends(Need(Role.OPERATOR))]
OperatorOrMes = Annotated[Act, Depends(Need(Role.OPERATOR, mes=True))]
Engineer = Annotated[Act, Depends(Need(Role.ENGINEER))]
Admin = Annotated[Act, Depends(Need(Role.ADMIN))]
