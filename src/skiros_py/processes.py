"""Python processes of our own that may be killed: started with a socket, limited in memory and time."""

from __future__ import annotations

import os
import resource
import signal
import socket
import subprocess
import sys
from pathlib import Path

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
    ours, theirs = socket.socketpair()
    with theirs:
        given = ", ".join(map(repr, (theirs.fileno(), *arguments)))
        program = f"import sys; sys.path[:] = {sys.path!r}; from {module} import {name}; {name}({given})"
        process = subprocess.Popen(
            [sys.executable, "-c", program],
            pass_fds=[theirs.fileno()],
            env={**os.environ, **_ONE_THREAD},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=None if os.environ.get("SKIROS_DEBUG") else subprocess.DEVNULL,
            start_new_session=True,
        )
    return process, ours


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
