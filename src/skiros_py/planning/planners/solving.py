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
        reply: Path of the file for the reply: a pickle of the plan's text, of Unsolvable or of a PlanningError.
    """
    path, method = pickle.loads(Path(call).read_bytes())  # noqa: S301 - our own process has written it
    sys.path[:] = path
    said: str | Unsolvable | PlanningError
    try:
        folder = Path.cwd()
        answer = pickle.loads(method)(folder / domain, folder / problem, folder)  # noqa: S301 - the same
        said = _plain(answer)
    except BaseException as error:
        if by_user(error):
            raise
        traceback.print_exc()
        said = PlanningError(_fault(error))
    Path(reply).write_bytes(pickle.dumps(said))


def _fault(error: BaseException) -> str:
    match error:
        case PlanningError():
            return str(error)
        case MemoryError():
            return "it ran out of memory"
        case _:
            return f"{type(error).__name__}: {error}"


def _plain(answer: object) -> str | Unsolvable | PlanningError:
    """Returns an answer without classes that the reader would have to import."""
    match answer:
        case str():
            return str(answer)
        case Unsolvable(reason, proven):
            return Unsolvable(str(reason), bool(proven))
        case _:
            return PlanningError(f"it returned {answer!r}: neither the text of a plan nor Unsolvable()")


if __name__ == "__main__":
    main(*sys.argv[1:])
