"""A server for tests: ``skiros serve`` in a process of its own, which can be killed."""

from __future__ import annotations

import json
import signal
import subprocess
import threading
from pathlib import Path
from typing import Self

from support import warm_python

from skiros_py.client import Client
from skiros_py.errors import DeviceError

_PATIENCE = 60.0
"""How long it may take to start, or to end [s]."""


class ServerProcess:
    """A server that runs until :meth:`end`, :meth:`kill`, or the end of the ``with``.

    Args:
        *arguments: What stands behind ``skiros serve``, such as a scene and "--fake".
        data: The data directory.
        port: Where it listens; 0 for any free port.

    Attributes:
        url: Its address.

    Raises:
        DeviceError: It does not start; with what it said.
    """

    def __init__(self, *arguments: str, data: Path, port: int = 0) -> None:
        self.data = data
        self._process = warm_python.Popen(
            [*warm_python.SKIROS, "serve", *arguments, "--data", str(data), "--port", str(port), "--json"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._said: list[str] = []
        self._reader = threading.Thread(target=self._read, name="skiros-test-reader", daemon=True)
        self._reader.start()
        assert self._process.stdout is not None
        first = self._process.stdout.readline()
        if not first or "url" not in json.loads(first):
            self.kill()
            raise DeviceError(f"the server did not start: {self.said}")
        self.url: str = json.loads(first)["url"]

    @property
    def said(self) -> str:
        """What it has said on stderr until now."""
        return "".join(self._said)

    @property
    def pid(self) -> int:
        """The number of its process."""
        return self._process.pid

    def client(self) -> Client:
        """Returns a client that may do everything; close it."""
        return Client.of_data(self.data)

    def end(self, number: int = signal.SIGTERM) -> int:
        """Asks it politely to end, and returns its exit status."""
        self._process.send_signal(number)
        return self._wait()

    def kill(self) -> None:
        """Ends it as a power cut does."""
        self._process.kill()
        self._wait()

    def _wait(self) -> int:
        status = self._process.wait(_PATIENCE)
        self._reader.join(_PATIENCE)
        for pipe in (self._process.stdout, self._process.stderr):
            if pipe is not None:
                pipe.close()
        return status

    def _read(self) -> None:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            self._said.append(line)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._process.poll() is None:
            self.kill()
        else:
            self._wait()
