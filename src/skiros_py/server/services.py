"""Everything that routes reach: the running station, and what the server itself keeps."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Annotated, Self

from fastapi import Depends, Request

from skiros_py.runtime import Session
from skiros_py.server.control import ControlThread, OpenSession
from skiros_py.server.events.log import EventLog
from skiros_py.server.settings import ServerSettings

__all__ = ["Services", "ServicesDep"]


class Services:
    """What one server is made of. Start it, and close it, or use it in a ``with``.

    Whatever belongs to one session is set up anew with each of them, by listeners of the control thread.

    Args:
        opening: Opens the session.
        data: The data directory.
        settings: How the server is set up.

    Attributes:
        settings: How the server is set up.
        data: The data directory.
        control: Runs the session.
        events: What happens.
    """

    def __init__(self, opening: OpenSession, data: Path, settings: ServerSettings) -> None:
        self.settings = settings
        self.data = data
        self.control = ControlThread(opening)
        self.events = EventLog(settings.kept_events)
        self._stack = ExitStack()

    @property
    def session(self) -> Session:
        """The session; while it is being opened anew, that is waited for.

        Raises:
            Busy: There is none, and there will be none soon.
        """
        return self.control.session

    def start(self) -> None:
        """Opens the session and runs it.

        Raises:
            SkirosError: It cannot be opened.
        """
        try:
            self._stack.callback(self.control.close)
            self.control.start()
        except BaseException:
            self.close()
            raise

    def on_close(self, callback: Callable[[], object]) -> None:
        """Has something done when the server ends."""
        self._stack.callback(callback)

    def close(self) -> None:
        """Stops everything and ends all that was started; may be called twice."""
        self._stack.close()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _services(request: Request) -> Services:
    services: Services = request.app.state.services
    return services


ServicesDep = Annotated[Services, Depends(_services)]
"""For routes: everything there is."""
