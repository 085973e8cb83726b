"""HermiT, the OWL 2 DL reasoner that comes with owlready2: a Java program, started for each question.

It is given one file in a private folder, without imports, so that it has nothing to fetch.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import pyoxigraph as ox

from skiros_py.world.ontology.check.logic import NoAnswer, NotStarted, Verdict
from skiros_py.world.ontology.check.owl import owl

__all__ = ["HermiT", "java"]

_MAIN = "org.semanticweb.HermiT.cli.CommandLine"
_INCONSISTENT = "InconsistentOntologyException"
_NO_START = re.compile(r"initialization of VM|Could not (?:create the Java|find or load main)|UnsupportedClassVersion")
_FAULT = re.compile(r"\w(?:Exception|Error)\b")
_TOO_BIG = re.compile(r"OutOfMemoryError|StackOverflowError|insufficient memory")
_MEMORY = ("-Xmx2000M", "-Xss256M")  # it goes as deep as classes are deep
# No shared file of performance counters, and the compiler that is quick for programs of a second.
_QUICK = ("-XX:-UsePerfData", "-XX:+UseSerialGC", "-XX:TieredStopAtLevel=1")


def java() -> str | None:
    """Returns the path of ``java``, or None where there is none."""
    return shutil.which("java")


class HermiT:
    """Asks HermiT.

    Args:
        program: Path of ``java``.
        deadline: Time of :func:`time.monotonic` at which a question is given up [s].
    """

    name = "HermiT"
    is_complete = True

    def __init__(self, program: str, deadline: float) -> None:
        self._program = program
        self._deadline = deadline

    def judge(self, triples: Sequence[ox.Triple], classes: Sequence[str]) -> Verdict:
        """Looks for contradictions, and for classes (IRIs) that nothing can be of.

        Raises:
            NoAnswer: It takes too long, or HermiT does not take the statements.
        """
        output = self._ask(triples, "--unsatisfiable", "--no-prefixes")
        if output is None:
            return Verdict(consistent=False)
        found = {line.strip() for line in output.splitlines()} - {owl("Nothing")}
        return Verdict(consistent=True, unsatisfiable=tuple(sorted(found.intersection(classes))))

    def consistent(self, triples: Sequence[ox.Triple]) -> bool:
        """Returns False when the statements contradict each other.

        Raises:
            NoAnswer: It takes too long, or HermiT does not take the statements.
        """
        return self._ask(triples, "--consistency") is not None

    def _ask(self, triples: Sequence[ox.Triple], *question: str) -> str | None:
        """Its answer, or None where the statements contradict each other."""
        with tempfile.TemporaryDirectory(prefix="skiros-check-") as name:
            file = Path(name) / "ontology.nt"
            file.write_bytes(ox.serialize(triples, format=ox.RdfFormat.N_TRIPLES) or b"")
            code, output, errors = self._run(Path(name), [*question, file.as_uri()])
        if code == 0:
            return output
        if _INCONSISTENT in errors:
            return None
        raise _fault(code, f"{errors}\n{output}")  # Java says on either why it does not start

    def _run(self, folder: Path, question: list[str]) -> tuple[int, str, str]:
        path = _class_path()
        options = [*_MEMORY, *_QUICK, f"-Djava.io.tmpdir={folder}", "-cp", path, _MAIN, "--ignoreUnsupportedDatatypes"]
        with _started([self._program, *options, *question], folder) as process:
            try:
                output, errors = process.communicate(timeout=max(self._deadline - time.monotonic(), 0.0))
            except subprocess.TimeoutExpired as error:
                raise NoAnswer("HermiT found no answer in the time given") from error
            finally:
                _kill(process)
        return process.returncode, output, errors


def _started(command: list[str], folder: Path) -> subprocess.Popen[str]:
    try:
        return subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="replace",
            start_new_session=True,
        )
    except OSError as error:
        raise NotStarted(f"HermiT does not start: {error.strerror or error}") from None


def _class_path() -> str:
    spec = find_spec("owlready2")
    assert spec is not None  # a dependency of ours
    assert spec.origin is not None
    folder = Path(spec.origin).parent / "hermit"
    return os.pathsep.join([str(folder), str(folder / "HermiT.jar")])


def _kill(process: subprocess.Popen[str]) -> None:
    """Kills what still runs and waits for it."""
    if process.poll() is None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _fault(code: int, errors: str) -> NoAnswer:
    """What a run without an answer means: a Java that does not start, too little memory, or statements refused."""
    reason = _reason(errors)
    if _TOO_BIG.search(errors) or code == -signal.SIGKILL:
        return NoAnswer(f"HermiT needs more memory than it may take ({_MEMORY[0].removeprefix('-Xmx')})")
    if _NO_START.search(errors) or not reason:
        said = " ".join(line.strip() for line in errors.splitlines() if line.strip())[:300]
        return NotStarted(f"HermiT does not start: {said or f'Java ended with status {code}'}")
    return NoAnswer(f"HermiT does not take these statements: {reason}")


def _reason(errors: str) -> str:
    """The first line of a fault of HermiT's own, without the names of its classes; nothing where there is none."""
    line = next((line for line in errors.splitlines() if _FAULT.search(line)), "")
    return (line.rpartition("Exception: ")[2] or line).strip()[:300]
