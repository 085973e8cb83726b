"""The OWL-RL reasoner in a process of its own, which may be ended: its library runs as long as it likes in all memory.

One process answers all questions of a check, as it takes half a second to start. The kernel watches over its memory,
and over its time too, should nobody be left to end it.
"""

from __future__ import annotations

import math
import os
import resource
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Self

import pyoxigraph as ox

from skiros_py.world.ontology.check.logic import NoAnswer, Reasoner, Verdict

__all__ = ["MEMORY", "OwlRlProcess", "main"]

MEMORY = 2000 << 20
"""Bytes that it may take beside what it takes at its start."""
_OUT_OF_MEMORY = 99
"""Exit status of a process that ran out of memory and could still say so."""
_GRACE = 1.0
"""How much later than we the kernel ends it [s]."""

_Answer = Verdict | bool | NoAnswer


class OwlRlProcess:
    """Asks the OWL 2 RL reasoner. Close it, or use it in a ``with``.

    Args:
        time_limit: How long it may take for all questions together, from the first on [s].
        memory: Bytes that it may take beside what it takes at its start.
    """

    name = "OWL-RL"
    is_complete = False

    def __init__(self, time_limit: float, memory: int = MEMORY) -> None:
        self._time_limit = time_limit
        self._memory = memory
        self._deadline = math.inf
        self._process: subprocess.Popen[bytes] | None = None
        self._line: Connection | None = None
        self._why_none = ""

    def judge(self, triples: Sequence[ox.Triple], classes: Sequence[str]) -> Verdict:
        """Looks for contradictions, and for classes (IRIs) that nothing can be of.

        Raises:
            NoAnswer: It takes too long or too much memory.
        """
        verdict = self._ask(triples, tuple(classes))
        assert isinstance(verdict, Verdict)
        return verdict

    def consistent(self, triples: Sequence[ox.Triple]) -> bool:
        """Returns False when the statements contradict each other.

        Raises:
            NoAnswer: It takes too long or too much memory.
        """
        answer = self._ask(triples, None)
        assert isinstance(answer, bool)
        return answer

    def close(self) -> None:
        """Ends the process, whatever it does, and waits for it; there are no answers any more."""
        self._why_none = self._why_none or "the OWL-RL reasoner was closed"
        if self._line is not None:
            self._line.close()
        if self._process is not None:
            self._process.kill()
            self._process.wait()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _ask(self, triples: Sequence[ox.Triple], classes: tuple[str, ...] | None) -> Verdict | bool:
        if self._why_none:
            raise NoAnswer(self._why_none)
        line = self._line or self._started()
        try:
            line.send((ox.serialize(triples, format=ox.RdfFormat.N_TRIPLES), classes))
            if not line.poll(max(self._deadline - time.monotonic(), 0.0)):
                raise self._given_up("the OWL-RL reasoner found no answer in the time given")
            answer: _Answer = line.recv()
        except (OSError, EOFError):
            raise self._given_up(self._why_it_died()) from None
        if isinstance(answer, NoAnswer):
            raise self._given_up(str(answer))
        return answer

    def _started(self) -> Connection:
        self._deadline = time.monotonic() + self._time_limit
        ours, theirs = socket.socketpair()
        self._line = Connection(ours.detach())
        # In a session of its own, so that Ctrl-C is for us only.
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-c", _program(theirs.fileno(), self._deadline, self._memory)],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=None if os.environ.get("SKIROS_DEBUG") else subprocess.DEVNULL,
                start_new_session=True,
            )
        return self._line

    def _given_up(self, why: str) -> NoAnswer:
        """Asked again, it would fail again: it is ended."""
        self._why_none = why
        self.close()
        return NoAnswer(why)

    def _why_it_died(self) -> str:
        """What ended the process, which closed its end of the line."""
        assert self._process is not None
        try:
            code = self._process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            return "the OWL-RL reasoner hangs"
        if code == -signal.SIGALRM:
            return "the OWL-RL reasoner found no answer in the time given"
        if code in (_OUT_OF_MEMORY, -signal.SIGABRT, -signal.SIGKILL):
            return f"the OWL-RL reasoner needs more than {self._memory >> 20} MiB of memory"
        return f"the OWL-RL reasoner broke down (status {code}; SKIROS_DEBUG=1 shows why)"


def _program(line: int, deadline: float, memory: int) -> str:
    start = "from skiros_py.world.ontology.check.owl_rl_process import main"
    return f"import sys; sys.path[:] = {sys.path!r}; {start}; main({line}, {deadline!r}, {memory})"


# ---------------------------------------------------------------- in the process


def main(line: int, deadline: float, memory: int) -> None:
    """Answers questions until nobody asks any more.

    Args:
        line: Descriptor of the socket on which questions come and answers go.
        deadline: Time of :func:`time.monotonic` at which it is given up [s].
        memory: Bytes that it may take beside what it takes now.
    """
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, max(deadline - time.monotonic(), 0.0) + _GRACE)
    try:
        from skiros_py.world.ontology.check.owl_rl import OwlRl  # rdflib takes its time

        _limit(memory)
        _serve(Connection(line), OwlRl(deadline))
    except MemoryError:
        os._exit(_OUT_OF_MEMORY)
    except (EOFError, OSError):  # nobody is there any more
        os._exit(0)


def _serve(line: Connection, reasoner: Reasoner) -> None:
    while True:
        packed, classes = line.recv()
        triples = [quad.triple for quad in ox.parse(packed, format=ox.RdfFormat.N_TRIPLES)]
        line.send(_answer(reasoner, triples, classes))


def _answer(reasoner: Reasoner, triples: Sequence[ox.Triple], classes: Sequence[str] | None) -> _Answer:
    try:
        return reasoner.consistent(triples) if classes is None else reasoner.judge(triples, classes)
    except NoAnswer as answer:
        return answer


def _limit(memory: int) -> None:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    most = pages * resource.getpagesize() + memory
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
