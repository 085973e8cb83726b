"""Python processes of our own that may be killed: started with a socket, limited in memory and time."""

from __future__ import annotations

import copyreg
import dataclasses
import io
import os
import pickle
import resource
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from operator import attrgetter
from pathlib import Path
from types import FunctionType
from typing import Any

import cloudpickle

_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def start_python(function: str, *arguments: object) -> tuple[subprocess.Popen[bytes], socket.socket]:
    """Starts a process that runs one function with a socket to us.

    It has a session of its own, so that Ctrl-C reaches only us. What it writes is dropped unless SKIROS_DEBUG is set.

    Args:
        function: Where it is ("skiros_py.world.queries.replica:main"); it is called with the descriptor of its socket.
        *arguments: What it is called with besides; each as its ``repr`` says.

    Returns:
        The process, and our end of the socket.
    """
    module, _, name = function.partition(":")

    def command(line: int) -> list[str]:
        given = ", ".join(map(repr, (line, *arguments)))
        return ["-c", f"import sys; sys.path[:] = {sys.path!r}; from {module} import {name}; {name}({given})"]

    return start_connected(command, {**os.environ, **_ONE_THREAD})


def start_connected(
    command: Callable[[int], Sequence[str]], environment: Mapping[str, str], kind: int = socket.SOCK_STREAM
) -> tuple[subprocess.Popen[bytes], socket.socket]:
    """Starts Python with a socket to us; see :func:`start_python`.

    Args:
        command: Returns the arguments of Python, given the descriptor of its socket.
        environment: Its environment.
        kind: The kind of socket.

    Returns:
        The process, and our end of the socket.
    """
    ours, theirs = socket.socketpair(socket.AF_UNIX, kind)
    with theirs:
        process = subprocess.Popen(
            [sys.executable, *command(theirs.fileno())],
            pass_fds=[theirs.fileno()],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=None if os.environ.get("SKIROS_DEBUG") else subprocess.DEVNULL,
            start_new_session=True,
        )
    return process, ours


def end_connected(process: subprocess.Popen[bytes], line: socket.socket, grace: float = 1.0) -> None:
    """Closes our end of the socket, upon which the process ends; kills it if it takes longer than ``grace`` [s]."""
    line.close()
    try:
        process.wait(grace)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def is_stopped(pid: int) -> bool:
    """Returns whether a child process is suspended by a signal (SIGSTOP)."""
    try:
        return os.waitid(os.P_PID, pid, os.WSTOPPED | os.WNOHANG | os.WNOWAIT) is not None
    except ChildProcessError:  # it has ended
        return False


def packed(thing: object) -> bytes:
    """Returns an object as bytes that another Python process on this machine reads with ``pickle.loads``.

    Functions and classes of modules that a new process would not find (a script, a notebook, a test) are packed whole.

    Raises:
        Exception: Something in it cannot be packed. Its own methods decide what that is.
    """
    buffer = io.BytesIO()
    _Pickler(buffer, protocol=pickle.HIGHEST_PROTOCOL).dump(thing)
    return buffer.getvalue()


class _Pickler(cloudpickle.Pickler):  # type: ignore[misc]  # it has no types
    """Registers the modules that cannot be imported again; reads the state of dataclasses with slots in one call."""

    def reducer_override(self, obj: object) -> Any:
        kind: Any = type(obj)
        read = _state_reader(kind)
        if read is not None:
            return copyreg.__newobj__, (kind,), read(obj)  # type: ignore[attr-defined]  # the type stubs lack it
        if isinstance(obj, type | FunctionType) and not _is_found(obj.__module__):
            cloudpickle.register_pickle_by_value(sys.modules[obj.__module__])
        return super().reducer_override(obj)


@cache
def _state_reader(of: type) -> Callable[[object], Sequence[object]] | None:
    """Returns what reads the fields of a frozen dataclass with slots; None for other classes.

    Its own ``__getstate__`` looks up the fields of the class for every object, which is most of the time of packing.
    """
    if not dataclasses.is_dataclass(of) or getattr(of.__getstate__, "__module__", "") != dataclasses.__name__:
        return None
    names = [field.name for field in dataclasses.fields(of)]
    return attrgetter(*names) if len(names) > 1 else lambda obj: [getattr(obj, name) for name in names]


@cache
def _is_found(module: str | None) -> bool:
    """Returns False where a new Python process with our path does not find a module."""
    file = getattr(sys.modules.get(module or ""), "__file__", None)
    if module is None or file is None or not file.endswith(".py"):  # built in, compiled, or not yet imported
        return True
    top, *rest = module.split(".")
    if top in sys.stdlib_module_names:
        return True
    places = _search_locations(top)
    if places is None or not rest:
        return places is not None
    return any(
        os.path.isfile(f"{place}.py") or os.path.isfile(os.path.join(place, "__init__.py"))  # noqa: PTH113, PTH118
        for place in (os.path.join(location, *rest) for location in places)  # noqa: PTH118 - Path is slower
    )


@cache
def _search_locations(top: str) -> tuple[str, ...] | None:
    """Returns the folders of a package, none for a plain module; None if a new Python process does not find it."""
    spec = next(filter(None, (finder.find_spec(top, None) for finder in sys.meta_path)), None)
    return None if spec is None else tuple(spec.submodule_search_locations or ())


def limit(*, seconds: float, memory: int) -> None:
    """Lets the kernel end this process by SIGALRM after some time [s], and refuse it more memory than so many bytes.

    Args:
        seconds: From now on [s].
        memory: Bytes beside what it takes now.
    """
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    most = pages * resource.getpagesize() + memory
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


# ---------------------------------------------------------------- frames of bytes, with open files


_HEADER = 8
_PIECE = 1 << 20


def send(to: socket.socket, payload: bytes, files: Sequence[int] = ()) -> None:
    """Sends one frame, with open files.

    Raises:
        OSError: The other end is closed.
    """
    header = len(payload).to_bytes(_HEADER, "big")
    if files:
        socket.send_fds(to, [header], files)
    else:
        to.sendall(header)
    to.sendall(payload)


def receive(source: socket.socket, files: int = 0) -> tuple[bytes, list[int]]:
    """Waits for one frame and the files that come with it.

    Raises:
        EOFError: The other end is closed.
    """
    header, handed_over, _, _ = socket.recv_fds(source, _HEADER, files)
    header += _exactly(source, _HEADER - len(header)) if header else b""
    if not header:
        raise EOFError
    return _exactly(source, int.from_bytes(header, "big")), handed_over


def _exactly(source: socket.socket, size: int) -> bytes:
    found = bytearray()
    while len(found) < size:
        piece = source.recv(min(size - len(found), _PIECE))
        if not piece:
            raise EOFError
        found += piece
    return bytes(found)
