"""Roles, and what a route asks of them."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import Depends, Request

from skiros_py.server.access.parameters import check_query
from skiros_py.server.problems import Problem
from skiros_py.station.requests import Author

LOCAL = "local"
"""Stands for a key with programs that may read the data directory; they say themselves who they work for."""


class Role(enum.StrEnum):
    """What somebody may do; each of the first four may do what those before it may."""

    VIEWER = "viewer"
    """Looks on."""
    OPERATOR = "operator"
    """Edits scenes, orders and commands jobs, answers the robots' questions, stops everything."""
    ENGINEER = "engineer"
    """Runs single modules, moves robots by hand, teaches, asks in SPARQL."""
    ADMIN = "admin"
    """Makes and revokes keys, reads the audit log, sets up webhooks."""
    MES = "mes"
    """A factory system: orders and commands jobs, follows them, stops everything; nothing else."""


_RANK = {Role.VIEWER: 0, Role.OPERATOR: 1, Role.ENGINEER: 2, Role.ADMIN: 3}


@dataclass(frozen=True, slots=True)
class Caller:
    """Who makes a request.

    Attributes:
        name: The name of their key; author of what they write.
        role: What they may do.
        key: Id of their key; empty where none is needed.
    """

    name: str
    role: Role
    key: str = ""

    @property
    def holder(self) -> str:
        """Whose locks are theirs: people of the same name are told apart by their keys."""
        return f"key {self.key}" if self.key not in ("", LOCAL) else self.name

    @property
    def author(self) -> Author:
        """The author of what they write."""
        return Author(self.name, self.holder)


@dataclass(frozen=True, slots=True)
class Need:
    """What a route asks for; a dependency of FastAPI.

    Attributes:
        least: The least role.
        mes: Whether a factory system may, too.
    """

    least: Role
    mes: bool = False

    def allows(self, role: Role) -> bool:
        """Returns whether a role is allowed."""
        return self.mes if role is Role.MES else _RANK[role] >= _RANK[self.least]

    async def __call__(self, request: Request) -> Caller:
        """Lets the caller through.

        Raises:
            Problem: Their role does not allow it.
        """
        caller: Caller = request.state.caller
        if not self.allows(caller.role):
            also = " or mes" if self.mes else ""
            raise Problem(
                403, "RoleTooLow", f"that takes the role {self.least}{also} at least; {caller.name} is {caller.role}"
            )
        check_query(request)  # for all that ask for a role, which is all that do something
        return caller


def needs(least: Role, *, mes: bool = False) -> Any:
    """Makes the dependency of a route that asks for a role: ``dependencies=[needs(Role.OPERATOR)]``.

    Args:
        least: The least role.
        mes: Whether a factory system may, too.
    """
    return Depends(Need(least, mes))


async def _caller(request: Request) -> Caller:
    caller: Caller = request.state.caller
    return caller


CallerDep = Annotated[Caller, Depends(_caller)]
"""For routes that want to know who asks; whether they may is what :func:`needs` says."""
