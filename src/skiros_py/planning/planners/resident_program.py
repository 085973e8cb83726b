"""A program that keeps Python modules loaded and runs one of them for each order, in a forked copy of itself.

Starting Python and importing the modules would take longer than most runs. It is a separate program that uses only the
standard library: the modules are never imported into the ordering process.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import resource
import runpy
import selectors
import signal
import socket
import sys
import traceback
from dataclasses import dataclass
from importlib import import_module
from typing import Any

_LONGEST = 1 << 20
"""No order is longer [bytes]."""


@dataclass(frozen=True, slots=True)
class _Run:
    """A run under way: its process, a descriptor to wait for its end, and the pipe on which that is reported."""

    pid: int
    ended: int
    status: int


def main(descriptor: str, *modules: str) -> None:
    """Serves until the other end of its socket is closed.

    Each order is a JSON object: ``folder``, ``module`` with ``arguments``, the command ``then`` that takes the process
    over when the module has ended well, with the file ``input`` and the ``environment``, and ``limits`` (numbers of the
    resource and its limit). Two pipes come with it: for what the run prints, and for "pid" and "code", its process id
    and its exit code, one a line. When the reader of the second pipe closes it, the run is killed.

    Args:
        descriptor: Descriptor of the socket, which preserves message boundaries.
        *modules: What to load before the first order.
    """
    for module in modules:
        import_module(module)
    gc.freeze()
    with socket.socket(fileno=int(descriptor)) as orders:
        _Server(orders).serve()


class _Server:
    def __init__(self, orders: socket.socket) -> None:
        self._orders = orders
        self._selector = selectors.DefaultSelector()
        self._runs: dict[int, _Run] = {}

    def serve(self) -> None:
        self._selector.register(self._orders, selectors.EVENT_READ)
        while True:
            for key, _ in self._selector.select():
                if key.fileobj is not self._orders:
                    run = self._runs.get(key.data)
                    if run is not None and key.fd == run.ended:
                        self._report(run)
                    elif run is not None:
                        self._selector.unregister(run.status)
                        _kill(run)
                elif not self._take_order():
                    for run in self._runs.values():
                        _kill(run)
                    return

    def _take_order(self) -> bool:
        """Starts a run; returns False if no more orders will come."""
        message, (*files,), _, _ = socket.recv_fds(self._orders, _LONGEST, 2)
        if not message:
            return False
        output, status = files
        pid = os.fork()
        if pid == 0:
            self._orders.close()
            for run in self._runs.values():
                os.close(run.status)
            _run(json.loads(message), output, status)
        _write(status, "pid", pid)
        os.close(output)
        run = self._runs[pid] = _Run(pid, os.pidfd_open(pid), status)
        self._selector.register(run.ended, selectors.EVENT_READ, pid)
        self._selector.register(status, selectors.EVENT_READ, pid)  # it is "readable" once the reader has closed it
        return True

    def _report(self, run: _Run) -> None:
        del self._runs[run.pid]
        self._selector.unregister(run.ended)
        with contextlib.suppress(KeyError):
            self._selector.unregister(run.status)
        _kill(run)
        _write(run.status, "code", os.waitstatus_to_exitcode(os.waitpid(run.pid, 0)[1]))
        os.close(run.ended)
        os.close(run.status)


def _write(status: int, what: str, number: int) -> None:
    with contextlib.suppress(BrokenPipeError):
        os.write(status, f"{what} {number}\n".encode())


def _kill(run: _Run) -> None:
    """Kills the process and the group that it leads."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(run.pid, signal.SIGKILL)
    with contextlib.suppress(ProcessLookupError):
        signal.pidfd_send_signal(run.ended, signal.SIGKILL)


def _run(order: dict[str, Any], output: int, status: int) -> None:
    """Executes an order in this process, then exits it.

    It reports its process id as its parent does: either of them could be stopped or killed before that.
    """
    code: object = 1
    try:
        os.setsid()
        _write(status, "pid", os.getpid())
        os.close(status)
        os.chdir(order["folder"])
        os.dup2(output, 1)
        os.dup2(output, 2)
        for kind, most in order["limits"]:
            with contextlib.suppress(ValueError):  # it already has a lower limit
                resource.setrlimit(kind, (most, most))
        sys.argv = [order["module"], *order["arguments"]]
        runpy.run_module(order["module"], run_name="__main__", alter_sys=True)
        sys.stdout.flush()
        os.dup2(os.open(order["input"], os.O_RDONLY), 0)
        os.execve(order["then"][0], order["then"], order["environment"])  # noqa: S606
    except SystemExit as end:
        code = end.code
    except BaseException:  # noqa: BLE001 - the end of this process
        traceback.print_exc()
    finally:
        with contextlib.suppress(BaseException):
            sys.stdout.flush()
        os._exit(code if isinstance(code, int) else 1)


if __name__ == "__main__":
    main(*sys.argv[1:])
