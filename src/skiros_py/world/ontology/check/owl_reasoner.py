"""The interface of reasoners; the OWL-RL reasoner in a process of its own, which may be killed; and HermiT.

One process answers all questions of a check, since starting it takes half a second. The kernel limits its memory and
time.
"""

from __future__ import annotations

import math
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Protocol

import pyoxigraph as ox

from skiros_py import programs
from skiros_py.processes import limit, start_python
from skiros_py.programs import Child, Ended, Limits, ProgramError, run_program
from skiros_py.world.names import STANDARD_PREFIXES


class NoAnswer(Exception):
    """A reasoner could not answer: too little time, or unsupported statements; the text says which."""


class NotStarted(NoAnswer):
    """A reasoner could not be started; the text says why."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """The answer of a reasoner.

    Attributes:
        consistent: False when the statements contradict each other.
        unsatisfiable: IRIs of the unsatisfiable classes, sorted; empty if not consistent.
        near: IRIs of individuals at which a contradiction was found; empty if unknown.
    """

    consistent: bool
    unsatisfiable: tuple[str, ...] = ()
    near: tuple[str, ...] = ()


class OwlReasoner(Protocol):
    """A reasoner.

    Attributes:
        name: Its display name.
        is_complete: True if it finds every contradiction of OWL 2 DL.
    """

    name: str
    is_complete: bool

    def judge(self, triples: Sequence[ox.Triple], classes: Sequence[str] = ()) -> Verdict:
        """Finds contradictions, and which of some classes (IRIs) are unsatisfiable.

        Raises:
            NoAnswer: It found no answer: it takes too long or too much memory, or does not support the statements.
        """


def some(class_: str) -> str:
    """Returns the IRI of the individual invented for a class (IRI)."""
    return f"urn:skiros-check:one-of:{class_}"


def one_of(class_: str) -> ox.Triple:
    """Returns the statement that a class (IRI) has an individual: a contradiction if it is unsatisfiable."""
    return ox.Triple(ox.NamedNode(some(class_)), ox.NamedNode(STANDARD_PREFIXES["rdf"] + "type"), ox.NamedNode(class_))


# ---------------------------------------------------------------- the OWL-RL process


MEMORY = 2000 << 20
"""Memory limit, in addition to its memory at start [bytes]."""
_OUT_OF_MEMORY = 99
"""Exit status of a process that ran out of memory."""
_GRACE = 1.0
"""How much later than our time limit the kernel ends it [s]."""


class OwlRlProcess(AbstractContextManager["OwlRlProcess"]):
    """Asks the OWL 2 RL reasoner. Close it, or use it in a ``with``.

    Args:
        time_limit: Time limit for all questions together, from the first on [s].
        memory: Memory limit, in addition to its memory at start [bytes].
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

    def judge(self, triples: Sequence[ox.Triple], classes: Sequence[str] = ()) -> Verdict:
        """Finds contradictions, and which of some classes (IRIs) are unsatisfiable.

        Raises:
            NoAnswer: It takes too long or too much memory.
        """
        if self._why_none:
            raise NoAnswer(self._why_none)
        line = self._line or self._started()
        try:
            line.send((ox.serialize(triples, format=ox.RdfFormat.N_TRIPLES), tuple(classes)))
            if not line.poll(max(self._deadline - time.monotonic(), 0.0)):
                raise self._given_up("the OWL-RL reasoner found no answer in the time given")
            answer: Verdict | NoAnswer = line.recv()
        except (OSError, EOFError):
            raise self._given_up(self._why_it_died()) from None
        if isinstance(answer, NoAnswer):
            raise self._given_up(str(answer))
        return answer

    def close(self) -> None:
        """Kills the process and waits for it; no more answers are given."""
        self._why_none = self._why_none or "the OWL-RL reasoner was closed"
        if self._line is not None:
            self._line.close()
        if self._process is not None:
            self._process.kill()
            self._process.wait()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _started(self) -> Connection:
        self._deadline = time.monotonic() + self._time_limit
        main = "skiros_py.world.ontology.check.owl_reasoner:main"
        self._process, line = start_python(main, self._deadline, self._memory)
        self._line = Connection(line.detach())
        return self._line

    def _given_up(self, why: str) -> NoAnswer:
        """Ends the process: asked again, it would fail again."""
        self._why_none = why
        self.close()
        return NoAnswer(why)

    def _why_it_died(self) -> str:
        """Returns why the process ended."""
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


# ---------------------------------------------------------------- in the process


def main(line: int, deadline: float, memory: int) -> None:
    """Answers questions until the parent is gone.

    Args:
        line: Descriptor of the socket for questions and answers.
        deadline: Time of :func:`time.monotonic` at which it gives up [s].
        memory: Memory limit, in addition to its present memory [bytes].
    """
    try:
        from skiros_py.world.ontology.check.owl_rl import OwlRl  # rdflib takes its time

        limit(seconds=max(deadline - time.monotonic(), 0.0) + _GRACE, memory=memory)
        socket, reasoner = Connection(line), OwlRl(deadline)
        while True:
            packed, classes = socket.recv()
            triples = [quad.triple for quad in ox.parse(packed, format=ox.RdfFormat.N_TRIPLES)]
            try:
                socket.send(reasoner.judge(triples, classes))
            except NoAnswer as answer:
                socket.send(answer)
    except MemoryError:
        os._exit(_OUT_OF_MEMORY)
    except (EOFError, OSError):  # the parent is gone
        os._exit(0)


# ---------------------------------------------------------------- HermiT


_MAIN = "org.semanticweb.HermiT.cli.CommandLine"
_INCONSISTENT = "InconsistentOntologyException"
_NO_START = re.compile(r"initialization of VM|Could not (?:create the Java|find or load main)|UnsupportedClassVersion")
_FAULT = re.compile(r"\w(?:Exception|Error)\b")
_TOO_BIG = re.compile(r"OutOfMemoryError|StackOverflowError|insufficient memory")
_LONGEST_ANSWER = 64 << 20
"""Bytes of the answer, which lists classes."""
_MEMORY = ("-Xmx2000M", "-Xss256M")  # it goes as deep as classes are deep
# No shared file of performance counters, and the compiler that is quick for programs of a second.
_QUICK = ("-XX:-UsePerfData", "-XX:+UseSerialGC", "-XX:TieredStopAtLevel=1")


def java() -> str | None:
    """Returns the path of ``java``, or None if there is none."""
    return shutil.which("java")


class HermiT:
    """Asks HermiT.

    Args:
        program: Path of ``java``.
        deadline: Time of :func:`time.monotonic` at which it gives up [s].
    """

    name = "HermiT"
    is_complete = True

    def __init__(self, program: str, deadline: float) -> None:
        self._program = program
        self._deadline = deadline

    def judge(self, triples: Sequence[ox.Triple], classes: Sequence[str] = ()) -> Verdict:
        """Finds contradictions, and which of some classes (IRIs) are unsatisfiable.

        Raises:
            NoAnswer: It takes too long, or HermiT does not support the statements.
        """
        question = ["--unsatisfiable", "--no-prefixes"] if classes else ["--consistency"]
        with tempfile.TemporaryDirectory(prefix="skiros-check-") as name:
            file = Path(name) / "ontology.nt"
            file.write_bytes(ox.serialize(triples, format=ox.RdfFormat.N_TRIPLES) or b"")
            ended = self._run(Path(name), [*question, file.as_uri()])
        if ended.code != 0:
            if _INCONSISTENT in ended.output:
                return Verdict(consistent=False)
            raise _fault(ended.code, ended.output)
        found = {line.strip() for line in ended.output.splitlines()}
        return Verdict(consistent=True, unsatisfiable=tuple(sorted(found.intersection(classes))))

    def _run(self, folder: Path, question: list[str]) -> Ended:
        path = _class_path()
        options = [*_MEMORY, *_QUICK, f"-Djava.io.tmpdir={folder}", "-cp", path, _MAIN, "--ignoreUnsupportedDatatypes"]
        command = [self._program, *options, *question]
        limits = Limits(max(self._deadline - time.monotonic(), 0.0), memory=None, kept=_LONGEST_ANSWER)
        try:
            start = partial(Child, self.name, command, folder, limits)
            return run_program(self.name, start, limits, lambda: False)
        except programs.NotStarted as error:
            raise NotStarted(str(error)) from None
        except ProgramError:
            raise NoAnswer("HermiT found no answer in the time given") from None


def _class_path() -> str:
    spec = find_spec("owlready2")
    assert spec is not None  # a dependency of ours
    assert spec.origin is not None
    folder = Path(spec.origin).parent / "hermit"
    return os.pathsep.join([str(folder), str(folder / "HermiT.jar")])


def _fault(code: int, errors: str) -> NoAnswer:
    """Returns why a run has no answer: Java does not start, too little memory, or unsupported statements."""
    reason = _reason(errors)
    if _TOO_BIG.search(errors) or code == -signal.SIGKILL:
        return NoAnswer(f"HermiT needs more memory than it may take ({_MEMORY[0].removeprefix('-Xmx')})")
    if _NO_START.search(errors) or not reason:
        said = " ".join(line.strip() for line in errors.splitlines() if line.strip())[:300]
        return NotStarted(f"HermiT does not start: {said or f'Java ended with status {code}'}")
    return NoAnswer(f"HermiT does not take these statements: {reason}")


def _reason(errors: str) -> str:
    """The first line of an error of HermiT, without class names; empty if there is none."""
    line = next((line for line in errors.splitlines() if _FAULT.search(line)), "")
    return (line.rpartition("Exception: ")[2] or line).strip()[:300]
