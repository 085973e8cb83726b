"""One way to run a program: limits of time, memory and output; however it ends, its children end with it.

The program gets a process group of its own, which is killed when the program has ended, too: it may have left children.
Those that left the group as well are found by a mark in their environment. This is cleanup, not a sandbox: a child
that starts its own session *and* clears its environment is not found. Only a process-wide setting (adopting all
orphans) would find it, and that would interfere with programs started by other libraries.
"""

from __future__ import annotations

import contextlib
import os
import re
import resource
import select
import signal
import subprocess
import sysconfig
import time
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol


class ProgramError(Exception):
    """A program was not started, took more than it may, or was stopped. Callers translate it into a fault of theirs."""


class NotStarted(ProgramError):
    """A program could not even be started."""


_MARK = "SKIROS_PROGRAM"
_GLANCE = 0.02
"""Poll interval for cancellation, and for programs that ended without closing their output [s]."""
_DYING = 0.2
"""Longest wait for killed processes to disappear [s]."""
_STACK = ("Traceback (most recent call last):", '  File "')
_OUT_OF_MEMORY = re.compile(r"MemoryError|bad_alloc|out of memory|cannot allocate memory", re.IGNORECASE)
"""Last output of programs that ran out of memory; the system does not report it."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Resource limits of a program.

    Attributes:
        time: Wall time [s].
        memory: Address space of each of its processes [bytes]; None for no limit.
        output: What it may print [bytes].
        file: Size of any file that it writes [bytes].
        kept: How much of the output is kept from its start, and from its end [bytes].
    """

    time: float = 120.0
    memory: int | None = 4 << 30
    output: int = 64 << 20
    file: int = 1 << 30
    kept: int = 100_000


USUAL_LIMITS = Limits()
"""The default limits of planners."""


@dataclass(frozen=True, slots=True)
class Ended:
    """How a program ended by itself.

    Attributes:
        code: Its exit code; minus the signal's number where one killed it.
        output: What it printed, on both channels; if it is very long, its start and end.
        memory: Address space that each of its processes could have [bytes]; None for no limit.
    """

    code: int
    output: str
    memory: int | None = None

    @property
    def words(self) -> str:
        """Readable description of how it ended, with its last output."""
        how = f"ended with code {self.code}" if self.code >= 0 else f"was killed by {_signal_name(-self.code)}"
        tail = "\n".join(_without_stacks(self.output)[-8:])[-2000:]
        if self.code != 0 and self.memory is not None and _OUT_OF_MEMORY.search(tail):
            how = f"ran out of memory (it may take {self.memory / (1 << 30):.2g} GiB) and {how}"
        return f"{how}:\n{tail}" if tail else f"{how} and said nothing"


class Running(Protocol):
    """A program that runs in a process group of its own.

    Attributes:
        output: Descriptor of the pipe on which comes what it prints.
    """

    output: int

    def has_ended(self) -> bool:
        """Returns whether it has ended; its process id is still its own."""

    def kill(self) -> int:
        """Kills its group, waits until it is gone and closes the pipe; returns its exit code."""


class Child:
    """A program that this process starts.

    Args:
        title: Its display name.
        command: Program and arguments.
        folder: Where it runs.
        limits: What it may take.
        environment: Its environment.

    Raises:
        ProgramError: It cannot be started.
    """

    def __init__(
        self, title: str, command: Sequence[str], folder: Path, limits: Limits, environment: Mapping[str, str]
    ) -> None:
        try:
            self._process = subprocess.Popen(
                command,
                cwd=folder,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        except OSError as error:
            raise NotStarted(f"{title} cannot be started: '{command[0]}': {error.strerror}") from error
        assert self._process.stdout is not None
        self.output = self._process.stdout.fileno()
        if hasattr(resource, "prlimit"):  # only Linux has it
            for kind, most in resource_limits(limits):
                with contextlib.suppress(ProcessLookupError, ValueError):  # it has ended, or already has a lower limit
                    resource.prlimit(self._process.pid, kind, (most, most))

    def has_ended(self) -> bool:
        """Returns whether it has ended; it is not reaped, so that its number still is the group's."""
        return os.waitid(os.P_PID, self._process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None

    def kill(self) -> int:
        """Kills its group, waits until it is gone and closes the pipe; returns its exit code."""
        kill_group(self._process.pid)
        self._process.wait()
        wait_for_group(self._process.pid)
        assert self._process.stdout is not None
        self._process.stdout.close()
        return self._process.returncode


def run_program(
    title: str,
    start: Callable[[Mapping[str, str]], Running],
    limits: Limits,
    stopped: Callable[[], bool],
    *,
    is_alone: bool = False,
) -> Ended:
    """Runs a program to its end; afterwards neither it nor any detectable child is left.

    Args:
        title: Its display name.
        start: Starts it with an environment.
        limits: What it may take.
        stopped: Polled; returns True once it should be killed.
        is_alone: True if it is known to start no programs that leave its process group.

    Raises:
        ProgramError: It cannot be started, takes more than it may, or was stopped.
    """
    if stopped():
        raise ProgramError(f"{title} was stopped")
    mark = uuid.uuid4().hex
    running = start(os.environ | {_MARK: mark, "PATH": _search_path()})
    try:
        output = _attended(title, running, limits, stopped)
    finally:
        if not is_alone:
            kill_marked(_MARK, mark)
        code = running.kill()
    return Ended(code, output, limits.memory)


def _search_path() -> str:
    """Returns the program search path, with pip's script folder first, even if the environment is not activated."""
    return os.pathsep.join([sysconfig.get_path("scripts"), os.environ.get("PATH", os.defpath)])


def resource_limits(limits: Limits) -> list[tuple[int, int]]:
    """Returns the limits for the system, including CPU time in case nothing checks the clock."""
    wanted = {
        resource.RLIMIT_CPU: round(limits.time * (os.cpu_count() or 1)) + 1,
        resource.RLIMIT_FSIZE: limits.file,
        resource.RLIMIT_AS: limits.memory,
        resource.RLIMIT_CORE: 0,
    }
    return [(kind, most) for kind, most in wanted.items() if most is not None]


def _attended(title: str, running: Running, limits: Limits, stopped: Callable[[], bool]) -> str:
    """Reads what a program prints until it ends.

    Raises:
        ProgramError: It takes more than it may, or was stopped.
    """
    printed = _Printed(limits.kept)
    deadline = time.monotonic() + limits.time
    for piece in _pieces(running):
        printed.add(piece)
        if stopped():
            raise ProgramError(f"{title} was stopped")
        if time.monotonic() > deadline:
            raise ProgramError(f"{title} found no answer in {limits.time:g} s")
        if printed.size > limits.output:
            raise ProgramError(f"{title} printed more than {limits.output >> 20} MiB: {str(printed)[:200]!r} …")
    return str(printed)


def _pieces(running: Running) -> Iterator[bytes]:
    """Yields what a program prints as it comes, and nothing in between, until it ends."""
    os.set_blocking(running.output, False)
    poll = select.poll()
    poll.register(running.output, select.POLLIN)
    wait = 0.0005
    open_ = True
    while open_ or not running.has_ended():
        if not open_:  # it ends a moment after it has closed its output
            time.sleep(wait)
            wait = min(2.0 * wait, _GLANCE)
        elif poll.poll(1000 * _GLANCE):
            piece = os.read(running.output, 1 << 16)
            open_ = bool(piece)
            yield piece
            continue
        elif running.has_ended():  # a child holds the output open
            break
        yield b""


def kill_group(pid: int) -> None:
    """Kills a process group; does nothing if there is none."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)


def wait_for_group(pid: int) -> None:
    """Waits until what was killed is gone, and cannot write into the folder any more."""
    deadline = time.monotonic() + _DYING
    with contextlib.suppress(ProcessLookupError, PermissionError):
        while time.monotonic() < deadline:
            os.killpg(pid, 0)
            time.sleep(0.001)


def kill_marked(name: str, value: str) -> None:
    """Kills programs by a variable in their environment, and what they start meanwhile.

    Args:
        name: The variable.
        value: How its value begins.
    """
    word = f"\0{name}={value}".encode()
    deadline = time.monotonic() + _DYING
    while found := list(_marked(word)):
        for pid in found:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
        if time.monotonic() > deadline:
            break
        time.sleep(0.001)


def _marked(word: bytes) -> Iterator[int]:
    """Yields the processes that were started with a word in their environment, each variable after a zero."""
    for file in Path("/proc").glob("[0-9]*/environ"):  # only Linux has it
        with contextlib.suppress(OSError):  # it is over
            if word in b"\0" + file.read_bytes():
                yield int(file.parent.name)


def _without_stacks(output: str) -> list[str]:
    """Returns the lines of an output, safe for a terminal, without Python stack traces."""
    lines = [_printable(line) for line in output.strip().splitlines()]
    if any(line.startswith(_STACK) for line in lines):
        return [line for line in lines if not line.startswith((" ", *_STACK))]
    return lines


def _printable(line: str) -> str:
    return "".join(c if c.isprintable() or c == "\t" else "\N{REPLACEMENT CHARACTER}" for c in line)


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


class _Printed:
    """The start and the end of the output of a program.

    Args:
        kept: How much of each is kept [bytes].

    Attributes:
        size: How much it was in all [bytes].
    """

    def __init__(self, kept: int) -> None:
        self.size = 0
        self._kept = kept
        self._start = bytearray()
        self._end = bytearray()

    def add(self, piece: bytes) -> None:
        self.size += len(piece)
        room = self._kept - len(self._start)
        self._start += piece[:room]
        self._end += piece[room:]
        del self._end[: -self._kept]

    def __str__(self) -> str:
        left_out = self.size - len(self._start) - len(self._end)
        between = f"\n… {left_out} bytes …\n".encode() if left_out else b""
        return (bytes(self._start) + between + bytes(self._end)).decode("utf-8", errors="replace")
