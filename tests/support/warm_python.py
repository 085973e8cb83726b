"""Python commands in tests, forked from a process in which the platform's modules are loaded.

A new interpreter takes a second or two to import them, which hundreds of commands would pay. What a command sees is
the same otherwise: its arguments, environment, folder, ``sys.path``, ``__main__``, signals and exit status. Tests of
the start of a process itself use :mod:`subprocess`.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import os
import pickle
import pkgutil
import runpy
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from skiros_py.processes import receive, send, start_python

SKIROS = (sys.executable, "-m", "skiros_py.cli")
"""The command ``skiros``."""

_LOADED = ("server.monitoring", "server.serving", "server.services", "client.streams", "testing.pytest_plugin")
_STATUS = struct.Struct("i")
_STANDARD = 3
"""Standard input, output, error."""


class Popen(subprocess.Popen[Any]):
    """As :class:`subprocess.Popen`, of Python with ``-m``, ``-c`` or a script, or of a command written in Python."""

    _report: socket.socket

    def _execute_child(self, args: Any, *rest: Any) -> None:
        _executable, _preexec, _close, pass_fds, cwd, env, _startup, _flags, shell = rest[:9]
        p2cread, _p2cwrite, _c2pread, c2pwrite, _errread, errwrite, *_ = rest[9:]
        new_session = rest[-2]
        assert not pass_fds, "a forked command is handed no files"
        assert not shell, "a forked command has no shell"
        self._report, theirs = socket.socketpair()
        files = [own if given == -1 else given for own, given in enumerate((p2cread, c2pwrite, errwrite))]
        request = ([*map(os.fspath, args)], os.fspath(cwd or Path.cwd()), dict(env or os.environ), bool(new_session))
        with theirs:
            send(_forking(os.getpid()), pickle.dumps(request), [*files, theirs.fileno()])
        self._close_pipe_fds(*rest[9:15])  # type: ignore[attr-defined]
        self.pid = self._reported()
        self._child_created = True

    def _reported(self) -> int:
        return int(_STATUS.unpack(self._report.recv(_STATUS.size, socket.MSG_WAITALL))[0])

    def _try_wait(self, wait_flags: int) -> tuple[int, int]:
        if self._report.fileno() == -1:
            return self.pid, 0
        self._report.setblocking(not wait_flags & os.WNOHANG)
        try:
            status = self._reported()
        except BlockingIOError:
            return 0, 0
        self._report.close()
        return self.pid, status

    def _internal_poll(self, *_: object, **__: object) -> int | None:
        if self.returncode is None and self._waitpid_lock.acquire(False):  # type: ignore[attr-defined]
            try:
                pid, status = self._try_wait(os.WNOHANG)
                if pid:
                    self.returncode = os.waitstatus_to_exitcode(status)
            finally:
                self._waitpid_lock.release()  # type: ignore[attr-defined]
        return self.returncode


def run(
    command: Sequence[str | os.PathLike[str]],
    *,
    cwd: str | os.PathLike[str] | None = None,
    env: Mapping[str, str] | None = None,
    typed: str | None = None,
    timeout: float | None = None,
) -> subprocess.CompletedProcess[str]:
    """Runs a command to its end, as :func:`subprocess.run` does, and returns what it wrote.

    Args:
        command: Its arguments, as of :class:`Popen`.
        cwd: Its folder; None for this one.
        env: Its environment; None for this one.
        typed: What it reads on standard input; None for nothing.
        timeout: How long it may take [s].
    """
    source = subprocess.DEVNULL if typed is None else subprocess.PIPE
    pipe = subprocess.PIPE
    with Popen(command, stdin=source, stdout=pipe, stderr=pipe, text=True, cwd=cwd, env=env) as process:
        try:
            written, errors = process.communicate(typed, timeout)
        except BaseException:
            process.kill()
            raise
    return subprocess.CompletedProcess(command, process.returncode, written, errors)


@cache
def _forking(pid: int) -> socket.socket:
    """Starts the process that forks."""
    process, line = start_python(f"{__name__}:main")

    def end() -> None:
        line.close()
        process.wait()

    atexit.register(end)
    return line


def main(line: int) -> None:
    """Loads the modules, and forks a process for each request."""
    import skiros_py.cli

    for module in pkgutil.iter_modules(skiros_py.cli.__path__):
        if module.name != "__main__":
            importlib.import_module(f"skiros_py.cli.{module.name}")
    for name in _LOADED:
        importlib.import_module(f"skiros_py.{name}")
    given = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    path = [place for place in sys.path if place not in ("", *given)]
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nothing waits for those that wait
    gc.collect()
    gc.freeze()
    orders = socket.socket(fileno=line)
    while True:
        try:
            content, files = receive(orders, _STANDARD + 1)
        except EOFError:
            os._exit(0)
        if not os.fork():
            orders.close()
            break
        for file in files:
            os.close(file)
    _become(*pickle.loads(content), files, path)


def _become(
    command: list[str], folder: str, environment: dict[str, str], new_session: bool, files: list[int], path: list[str]
) -> None:
    """Forks once more, waits for that process and reports how it ended; returns in none of them."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    *standard, report = files
    child = os.fork()
    if child:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        for file in standard:
            os.close(file)
        os.write(report, _STATUS.pack(child))
        os.write(report, _STATUS.pack(os.waitpid(child, 0)[1]))
        os._exit(0)
    os.close(report)
    for number, file in enumerate(standard):
        os.dup2(file, number)
        os.close(file)
    if new_session:
        os.setsid()
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[:] = [*filter(None, environment.get("PYTHONPATH", "").split(os.pathsep)), *path]
    importlib.invalidate_caches()
    match command[1:] if command[0] == sys.executable else command:
        case ["-m", module, *arguments]:
            sys.path.insert(0, folder)
            sys.argv = [module, *arguments]
            runpy.run_module(module, run_name="__main__", alter_sys=True)
        case ["-c", program, *arguments]:
            sys.path.insert(0, "")
            sys.argv = ["-c", *arguments]
            exec(program, {"__name__": "__main__"})
        case [script, *arguments]:
            sys.path.insert(0, str(Path(script).resolve().parent))
            sys.argv = [script, *arguments]
            runpy.run_path(script, run_name="__main__")
