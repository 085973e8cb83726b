"""Python programs that start at once: a resident program has their modules loaded and forks for each run."""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import subprocess
import sys
import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from skiros_py.errors import PlanningError
from skiros_py.planning.planners.programs import Limits, kill_group, resource_limits, wait_for_group

_ENDING = 1.0
"""How long the resident program may take to end [s]."""


@dataclass(frozen=True, slots=True)
class Run:
    """A run to execute.

    Attributes:
        module: The module that is run as a program.
        arguments: Its arguments.
        then: The command that takes over when the module has ended well.
        input: The file that this command reads.
    """

    module: str
    arguments: Sequence[str]
    then: Sequence[str]
    input: str


class Resident:
    """Starts runs in a resident program, which starts with the first of them. Thread-safe. The owner must close it.

    Args:
        title: Its display name.
        search_path: The folder where the modules are.
        modules: What is loaded before the first run.
    """

    def __init__(self, title: str, search_path: Path, modules: Sequence[str]) -> None:
        self._title = title
        self._search_path = search_path
        self._modules = modules
        self._lock = Lock()
        self._orders: socket.socket | None = None
        self._end: Callable[[], object] = lambda: None

    def start(self, run: Run, folder: Path, limits: Limits, environment: Mapping[str, str]) -> ResidentRun:
        """Starts a run; if the resident program has died, it is restarted.

        Raises:
            PlanningError: It cannot be started.
        """
        order = {
            "folder": str(folder),
            "module": run.module,
            "arguments": run.arguments,
            "then": run.then,
            "input": run.input,
            "environment": dict(environment),
            "limits": resource_limits(limits),
        }
        message = json.dumps(order).encode()
        (output, output_there), (status, status_there) = os.pipe(), os.pipe()
        try:
            with self._lock:
                self._send(message, [output_there, status_there])
        except OSError as error:
            os.close(output)
            os.close(status)
            raise PlanningError(f"{self._title} cannot be started: {error}") from error
        finally:
            os.close(output_there)
            os.close(status_there)
        return ResidentRun(output, status)

    def warm_up(self) -> None:
        """Starts the resident program if it is not running."""
        with self._lock:
            self._started()

    def close(self) -> None:
        """Ends the resident program and what it runs; may be called twice."""
        with self._lock:
            self._drop()

    def _send(self, message: bytes, files: Sequence[int]) -> None:
        try:
            socket.send_fds(self._started(), [message], files)
        except (BrokenPipeError, ConnectionResetError):  # it was killed
            self._drop()
            socket.send_fds(self._started(), [message], files)

    def _started(self) -> socket.socket:
        if self._orders is None:
            ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            program = str(Path(__file__).with_name("resident_program.py"))
            with theirs:
                process = subprocess.Popen(
                    # -S: no installed packages; -P: no modules beside the program
                    [sys.executable, "-S", "-P", program, str(theirs.fileno()), *self._modules],
                    env=os.environ | {"PYTHONPATH": str(self._search_path)},
                    pass_fds=[theirs.fileno()],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=None if os.environ.get("SKIROS_DEBUG") else subprocess.DEVNULL,
                    start_new_session=True,
                )
            self._orders = ours
            self._end = weakref.finalize(self, _end, process, ours)
        return self._orders

    def _drop(self) -> None:
        self._orders = None
        self._end()


def _end(process: subprocess.Popen[bytes], orders: socket.socket) -> None:
    orders.close()
    try:
        process.wait(_ENDING)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class ResidentRun:
    """A run under way; a :class:`~skiros_py.planning.planners.programs.Running`.

    Args:
        output, status: Descriptors of the pipes for what it prints, and for its process id and exit code.
    """

    def __init__(self, output: int, status: int) -> None:
        self.output = output
        self._status = status
        self._said = b""

    def has_ended(self) -> bool:
        """Returns whether it has ended, or was lost because the resident program was killed."""
        waiting = select.poll()
        waiting.register(self._status, select.POLLIN)
        while self._said.count(b"\n") < 2 and waiting.poll(0):
            piece = os.read(self._status, 100)
            self._said += piece
            if not piece:
                return True
        return self._said.count(b"\n") >= 2

    def kill(self) -> int:
        """Kills its group, waits until it is gone and closes the pipes; returns its exit code."""
        self.has_ended()  # reads what there is
        said = [int(line) for line in self._said.splitlines()]
        os.close(self._status)  # for the resident program: to kill it, where it runs
        os.close(self.output)
        if said:
            kill_group(said[0])
            wait_for_group(said[0])
        return said[1] if len(said) == 2 else -signal.SIGKILL
