"""Clients that misbehave: half a header, a body without an end, an answer that is never read."""

from __future__ import annotations

import resource
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from urllib.parse import urlsplit

HALF = b"POST /api/v1/stop HTTP/1.1\r\nHost: 127.0.0.1\r\n"
"""A header without its end."""


def connect(url: str, said: bytes = b"", buffer: int = 0) -> socket.socket:
    """Opens a connection and sends the beginning of a request.

    Args:
        url: Address of the server.
        said: What is sent.
        buffer: Size of the client's buffer [bytes]; 0 for the usual one.
    """
    address = urlsplit(url)
    assert address.hostname is not None
    one = socket.socket()
    if buffer:
        one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
    one.settimeout(30)
    one.connect((address.hostname, address.port))
    one.sendall(said)
    return one


@contextmanager
def crowd(url: str, number: int, said: bytes = HALF, buffer: int = 0) -> Iterator[list[socket.socket]]:
    """Opens many connections for the duration of the block."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft < (wanted := number + 512):
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(wanted, hard), hard))
    with ExitStack() as stack:
        yield [stack.enter_context(connect(url, said, buffer)) for _ in range(number)]


def is_closed(one: socket.socket, patience: float = 30.0) -> bool:
    """Returns whether the server closes a connection in time."""
    one.settimeout(patience)
    try:
        while one.recv(1 << 16):
            pass  # what was sent before
        return True
    except TimeoutError:
        return False
    except ConnectionError:
        return True


def stop(url: str) -> tuple[int, float]:
    """Requests a stop with a new connection; returns the status of the answer, and its latency [s]."""
    begun = time.perf_counter()
    with connect(url, HALF + b"Content-Length: 0\r\nConnection: close\r\n\r\n") as one:
        answer = one.recv(4096)
    return int(answer.split()[1]), time.perf_counter() - begun
