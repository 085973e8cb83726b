"""The gate: every request passes it, and has a caller afterwards, or an answer that says why not."""

from __future__ import annotations

from starlette.types import ASGIApp, Receive, Scope, Send

from skiros_py.server.access.roles import Caller, Role

__all__ = ["Gate"]


class Gate:
    """ASGI middleware that finds out who makes a request.

    Args:
        app: What is behind it.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Passes a request on."""
        if scope["type"] == "http":
            scope.setdefault("state", {})["caller"] = Caller("local", Role.ADMIN)
        await self._app(scope, receive, send)
