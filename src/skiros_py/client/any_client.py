"""The common base of the blocking and the asynchronous client."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar, Self

from skiros_py.client.discovery import InStep, server_of
from skiros_py.client.patience import Patience
from skiros_py.client.request import settings_for
from skiros_py.client.topics import C, Topics


class AnyClient(Topics[C]):
    """A client of one server; for its arguments see :class:`~skiros_py.client.client.Client`."""

    http: Any
    _http: ClassVar[Any]

    def __init__(
        self, url: str = "http://127.0.0.1:8000", key: str | None = None, *, timeout: float = 30.0, tries: int = 6
    ) -> None:
        super().__init__(self)  # type: ignore[arg-type]  # each kind of client is one of the senders
        self.url = url.rstrip("/")
        self._patience = Patience(tries)
        self.http = self._http(**settings_for(url, key, timeout))

    @classmethod
    def of_data(cls, data: str | Path, **options: Any) -> Self:
        """Returns the client of the server that owns a data directory of this machine; it needs no key.

        A replacement server started later, perhaps at another address, is found as well.

        Args:
            data: The data directory.
            **options: ``timeout`` and ``tries``.

        Raises:
            FileError: No server runs on it, or another user's does.
        """
        client = cls(server_of(Path(data)).url, **options)
        client.http.auth = InStep(Path(data))
        return client
