"""Fast Downward as a program: a private directory per call, limits, and its whole process group killed on cancel.

The planner is GPL-licensed and comes with the ``up-fast-downward`` package; it is started, never imported.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path

from skiros_py.errors import PlanningError
from skiros_py.planning.planner import Answer, Solved, Unsolvable

__all__ = ["FastDownward", "driver_path"]

_PLAN_FOUND = 0
_UNSOLVABLE = {10, 11, 12}  # translate unsolvable, search unsolvable, search unsolvable but incomplete


def driver_path() -> Path:
    """Returns the path of ``fast-downward.py``.

    Raises:
        PlanningError: The package that brings it is not installed.
    """
    spec = find_spec("up_fast_downward")
    if spec is None or spec.origin is None:
        raise PlanningError("Fast Downward is not installed: pip install up-fast-downward")
    return Path(spec.origin).parent / "downward" / "fast-downward.py"


class _Solving:
    """One call under way."""

    latency = 0.0

    def __init__(self, future: Future[Answer]) -> None:
        self._future = future

    def done(self) -> bool:
        return self._future.done()

    def result(self) -> Answer:
        try:
            return self._future.result()
        except CancelledError as error:
            raise PlanningError("Fast Downward was stopped") from error


class FastDownward:
    """Runs Fast Downward, by default its lama-first configuration, which stops by itself at the first plan.

    Args:
        options: Arguments before the files, such as ``("--alias", "lama-first")``.
        time_limit: Wall time after which a call is given up [s]; a guard, not a means of control.
    """

    name = "fast-downward"
    supports = frozenset(
        {
            ":strips", ":typing", ":equality", ":negative-preconditions", ":disjunctive-preconditions",
            ":existential-preconditions", ":universal-preconditions", ":quantified-preconditions",
            ":conditional-effects", ":adl", ":derived-predicates", ":action-costs",
        }
    )  # fmt: skip

    def __init__(self, options: tuple[str, ...] = ("--alias", "lama-first"), time_limit: float = 120.0) -> None:
        self._options = options
        self._time_limit = time_limit
        self._threads = ThreadPoolExecutor(thread_name_prefix="fast-downward")
        self._running: set[subprocess.Popen[str]] = set()
        self._closed = False

    def command(self, domain: str, problem: str) -> list[str]:
        """Returns the command line for two files, as it would be typed."""
        return [sys.executable, str(driver_path()), "--plan-file", "plan", *self._options, domain, problem]

    def solve(self, domain: str, problem: str) -> _Solving:
        """Starts solving; several calls may be under way at once."""
        if self._closed:
            raise PlanningError("Fast Downward was stopped")
        return _Solving(self._threads.submit(self._solve, domain, problem))

    def close(self) -> None:
        """Kills what still runs and waits for it."""
        self._closed = True
        for process in list(self._running):
            _kill(process)
        self._threads.shutdown(wait=True, cancel_futures=True)

    def _solve(self, domain: str, problem: str) -> Answer:
        with tempfile.TemporaryDirectory(prefix="skiros-plan-") as name:
            folder = Path(name)
            (folder / "domain.pddl").write_text(domain, encoding="utf-8")
            (folder / "problem.pddl").write_text(problem, encoding="utf-8")
            code, output = self._run(folder)
            if code in _UNSOLVABLE:
                return Unsolvable()
            if code != _PLAN_FOUND:
                raise PlanningError(f"Fast Downward ended with code {code}:\n{_tail(output)}")
            return Solved(_read_steps((folder / "plan").read_text(encoding="utf-8")))

    def _run(self, folder: Path) -> tuple[int, str]:
        with subprocess.Popen(
            self.command("domain.pddl", "problem.pddl"),
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        ) as process:
            self._running.add(process)
            if self._closed:  # closed between the request and now: nobody would kill it any more
                _kill(process)
            try:
                output, _ = process.communicate(timeout=self._time_limit)
            except subprocess.TimeoutExpired as error:
                raise PlanningError(f"Fast Downward found no answer in {self._time_limit:g} s") from error
            finally:
                _kill(process)
                self._running.discard(process)
        if self._closed:
            raise PlanningError("Fast Downward was stopped")
        return process.returncode, output


def _kill(process: subprocess.Popen[str]) -> None:
    """Kills the process group (driver, translator, search) and waits for the leader."""
    if process.poll() is None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _tail(output: str) -> str:
    return "\n".join(output.strip().splitlines()[-8:])


def _read_steps(text: str) -> tuple[tuple[str, ...], ...]:
    lines = (line.strip() for line in text.splitlines())
    return tuple(tuple(line.strip("()").split()) for line in lines if line and not line.startswith(";"))
