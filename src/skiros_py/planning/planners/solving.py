"""Runs in the process of a planner that is a method (``FilesPlanner``): one call, one reply."""

from __future__ import annotations

import pickle
import sys
import traceback
from pathlib import Path

from skiros_py.errors import PlanningError
from skiros_py.interruptions import by_user
from skiros_py.planning.planners.planner import Unsolvable


def main(domain: str, problem: str, call: str, reply: str) -> None:
    """Calls the method and writes its reply.

    Args:
        domain: Path of the domain file.
        problem: Path of the problem file.
        call: Path of a pickle: where modules are found, and the method, pickled.
        reply: Path of the file for the reply: its kind in the first line, then a text.
    """
    path, method = pickle.loads(Path(call).read_bytes())  # noqa: S301 - our own process has written it
    sys.path[:] = path
    try:
        folder = Path.cwd()
        answer = pickle.loads(method)(folder / domain, folder / problem, folder)  # noqa: S301 - the same
        words = _words(answer)
    except BaseException as error:
        if by_user(error):
            raise
        traceback.print_exc()
        words = f"broke\n{_fault(error)}"
    Path(reply).write_text(words, encoding="utf-8")


def _fault(error: BaseException) -> str:
    match error:
        case PlanningError():
            return str(error)
        case MemoryError():
            return "it ran out of memory"
        case _:
            return f"{type(error).__name__}: {error}"


def _words(answer: object) -> str:
    match answer:
        case str():
            return f"plan\n{answer}"
        case Unsolvable(reason, proven):
            return f"{'proven' if proven else 'unproven'}\n{reason}"
        case _:
            return f"broke\nit returned {answer!r}: neither the text of a plan nor Unsolvable()"


if __name__ == "__main__":
    main(*sys.argv[1:])
