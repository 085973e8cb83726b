"""What goes between a process and its replica: frames of bytes over a socket, files handed over with them."""

from __future__ import annotations

import socket
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from skiros_py.world.queries.answering import Binding
from skiros_py.world.store.store import UNLIMITED, AnswerLimits

OUT_OF_MEMORY = 77
"""Exit status of a query that could get no more memory; the engine itself aborts."""

_HEADER = 8
_PIECE = 1 << 20


@dataclass(frozen=True, slots=True)
class Order:
    """A query to be answered.

    Attributes:
        sparql: The query.
        bindings: What its parameters stand for.
        entailed: Whether what OWL entails counts.
        time_limit: How long it may take [s].
        memory: How much memory it may take [bytes].
        limits: How large the answer may get.
    """

    sparql: str
    bindings: Mapping[str, Binding] = field(default_factory=dict)
    entailed: bool = False
    time_limit: float = 5.0
    memory: int = 1 << 30
    limits: AnswerLimits = UNLIMITED


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
