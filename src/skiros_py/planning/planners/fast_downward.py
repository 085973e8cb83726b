"""Fast Downward as a program, whose Python part stays loaded between calls.

The planner is GPL-licensed and comes with the ``up-fast-downward`` package; it is started, never imported. Its two
parts, translator and search, run one after the other in one process that a resident program forks: the driver that
usually starts them, and the translator, are Python programs whose start takes longer than most tasks.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import socket
import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path
from threading import Lock

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.pddl import LEARNED_COST
from skiros_py.planning.planners.planner import Answer, Unsolvable
from skiros_py.planning.planners.program_planner import (
    CLASSICAL,
    DOMAIN,
    PROBLEM,
    ProgramPlanner,
    last_plan_file,
    read_plan_file,
)
from skiros_py.processes import end_connected, is_stopped, start_connected
from skiros_py.programs import Ended, Limits, Running, kill_group, resource_limits, wait_for_group

_START = 0.3
"""How long the resident program may take to start a run that is cancelled [s]."""
_REPORT = 10.0
"""How long a run that was started by a resident program which is dead by now may take to report [s]."""


@dataclass(frozen=True, slots=True)
class Run:
    """A run to execute.

    Attributes:
        module: The module that is run as a program.
        arguments: Its arguments.
        then: The command that takes over when the module has ended well.
        input: The file that this command reads.
    """

    module: str
    arguments: Sequence[str]
    then: Sequence[str]
    input: str


class Resident:
    """Starts runs in a resident program, which starts with the first of them. Thread-safe. The owner must close it.

    Args:
        title: Its display name.
        search_path: The folder where the modules are.
        modules: What is loaded before the first run.
    """

    def __init__(self, title: str, search_path: Path, modules: Sequence[str]) -> None:
        self._title = title
        self._search_path = search_path
        self._modules = modules
        self._lock = Lock()
        self._orders: socket.socket | None = None
        self._pid = 0
        self._end: Callable[[], object] = lambda: None

    def start(self, run: Run, folder: Path, limits: Limits, environment: Mapping[str, str]) -> ResidentRun:
        """Starts a run; if the resident program has died, it is restarted.

        Raises:
            PlanningError: It cannot be started.
        """
        where = {"folder": str(folder), "environment": dict(environment), "limits": resource_limits(limits)}
        message = json.dumps(asdict(run) | where).encode()
        (output, output_there), (status, status_there) = os.pipe(), os.pipe()
        try:
            with self._lock:
                self._send(message, [output_there, status_there])
        except OSError as error:
            os.close(output)
            os.close(status)
            raise PlanningError(f"{self._title} cannot be started: {error}") from error
        finally:
            os.close(output_there)
            os.close(status_there)
        return ResidentRun(output, status, self._pid)

    def warm_up(self) -> None:
        """Starts the resident program if it is not running."""
        with self._lock:
            waiting = select.poll()
            if self._orders is not None:
                waiting.register(self._orders, select.POLLHUP)
            if waiting.poll(0):
                self._drop()
            self._started()

    def close(self) -> None:
        """Ends the resident program and what it runs; may be called twice."""
        with self._lock:
            self._drop()

    def _send(self, message: bytes, files: Sequence[int]) -> None:
        try:
            socket.send_fds(self._started(), [message], files)
        except (BrokenPipeError, ConnectionResetError):  # it was killed
            self._drop()
            socket.send_fds(self._started(), [message], files)

    def _started(self) -> socket.socket:
        if self._orders is None:
            program = str(Path(__file__).with_name("resident_program.py"))
            process, self._orders = start_connected(
                # -S: no installed packages; -P: no modules beside the program
                lambda line: ["-S", "-P", program, str(line), *self._modules],
                os.environ | {"PYTHONPATH": str(self._search_path)},
                socket.SOCK_SEQPACKET,
            )
            self._pid = process.pid
            self._end = weakref.finalize(self, end_connected, process, self._orders)
        return self._orders

    def _drop(self) -> None:
        self._orders = None
        self._end()


class ResidentRun:
    """A run under way; a :class:`~skiros_py.programs.Running`.

    Args:
        output, status: Descriptors of the pipes for what it prints, and for its process id and exit code.
        resident: Process id of the resident program.
    """

    def __init__(self, output: int, status: int, resident: int) -> None:
        self.output = output
        self._status = status
        self._resident = resident
        self._said = b""

    def has_ended(self) -> bool:
        """Returns whether it has ended, or was lost because the resident program was killed or suspended."""
        if b"pid" not in self._said and is_stopped(self._resident):
            self._kill_resident()
        return self._has_reported(b"code", 0.0)

    def _kill_resident(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._resident, signal.SIGKILL)

    def _has_reported(self, word: bytes, seconds: float) -> bool:
        """Returns whether a number was reported, at most some time [s] later; also True if none will be."""
        waiting = select.poll()
        waiting.register(self._status, select.POLLIN)
        while word not in self._said and waiting.poll(1e3 * seconds):
            piece = os.read(self._status, 100)
            self._said += piece
            if not piece:
                return True
        return word in self._said

    def kill(self) -> int:
        """Kills its group, waits until it is gone and closes the pipes; returns its exit code.

        A resident program that has not started it is stopped or hangs: it is killed, and the next run starts another.
        """
        if not self._has_reported(b"pid", _START):
            self._kill_resident()
            self._has_reported(b"pid", _REPORT)  # by the run itself if it was started even so; none is left otherwise
        self.has_ended()  # reads what there is
        said = dict(line.split() for line in self._said.splitlines())
        os.close(self._status)  # for the resident program: to kill it, where it runs
        os.close(self.output)
        if b"pid" in said:
            pid = int(said[b"pid"])
            kill_group(pid)
            if b"code" not in said:  # it may not lead a group yet
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            wait_for_group(pid)
        return int(said.get(b"code", -signal.SIGKILL))


LAMA_FIRST = (
    "let(hlm, "
    "eval_modify_costs(landmark_sum(lm_factory=lm_reasonable_orders_hps(lm_rhw()), pref=false), cost_type=one), "
    "let(hff, eval_modify_costs(ff(), cost_type=one), "
    "lazy_greedy([hff, hlm], preferred=[hff, hlm], cost_type=one, reopen_closed=false)))"
)
"""What the driver calls lama-first: the first search of LAMA (Richter & Westphal 2010); it ends at the first plan."""

_CHEAP = "let(hff, eval_modify_costs(ff(), cost_type=plusone), lazy_wastar([hff], preferred=[hff], w={weight}))"
LAMA_CHEAP = f"iterated([{', '.join([LAMA_FIRST, *(_CHEAP.format(weight=w) for w in (5, 2))])}], pass_bound=false)"
"""Three searches, each of which ends at its first plan: the cheapest of them counts."""

_TRANSLATOR = "fast_downward.translate"
_LOADED = tuple(f"{_TRANSLATOR}.{module}" for module in ("main", "options", "pddl_parser"))

_PLAN_FOUND = 0
_PROVED_UNSOLVABLE = {10, 11}
"""By the translator, by the search."""
_SEARCHED_IN_VAIN = 12
"""The search ended without a plan, but it may be incomplete."""
_OUT_OF_MEMORY = {20, 22}
_OUT_OF_TIME = {21, 23}


def driver_path() -> Path:
    """Returns the path of ``fast-downward.py``.

    Raises:
        PlanningError: The package that brings it is not installed.
    """
    spec = find_spec("up_fast_downward")
    if spec is None or spec.origin is None:
        raise PlanningError("Fast Downward is not installed: pip install up-fast-downward")
    return Path(spec.origin).parent / "downward" / "fast-downward.py"


class FastDownward(ProgramPlanner):
    """Runs Fast Downward, by default its lama-first configuration, which stops by itself at the first plan.

    Args:
        search: The search configuration, such as ``"astar(lmcut())"``.
        time_limit: Wall time after which a call is given up [s]; a guard, not a means of control.
        memory: Address space of each of its processes [bytes].

    Raises:
        PlanningError: The package that brings it is not installed.
    """

    name = "fast-downward"
    title = "Fast Downward"
    is_alone = True
    supports = CLASSICAL | {":adl", ":derived-predicates", ":action-costs"}

    def __init__(
        self,
        search: str = LAMA_FIRST,
        time_limit: float = 120.0,
        memory: int = 4 << 30,
    ) -> None:
        super().__init__(Limits(time_limit, memory))
        self._search = search
        self._programs = driver_path().parent / "builds" / "release" / "bin"
        self._resident = Resident(self.title, self._programs, _LOADED)

    def start(self, folder: Path, environment: Mapping[str, str]) -> Running:
        """Starts translator and search."""
        has_costs = f"({LEARNED_COST}" in (folder / DOMAIN).read_text(encoding="utf-8")
        chosen = LAMA_CHEAP if has_costs and self._search == LAMA_FIRST else self._search
        search = (str(self._programs / "downward"), "--search", chosen, "--internal-plan-file", "plan")
        run = Run(_TRANSLATOR, (DOMAIN, PROBLEM, "--sas-file", "task.sas"), search, "task.sas")
        return self._resident.start(run, folder, self.limits, environment)

    def warm_up(self) -> None:
        """Starts the resident program, so that the first task need not wait for it."""
        self._resident.warm_up()

    def close(self) -> None:
        """Kills running calls and waits for them; may be called twice."""
        super().close()
        self._resident.close()

    def read(self, ended: Ended, folder: Path) -> Answer:
        """Reads the answer."""
        if ended.code in _PROVED_UNSOLVABLE:
            return Unsolvable()
        if ended.code == _SEARCHED_IN_VAIN:
            return Unsolvable("its search came to an end without a plan", proven=False)
        if ended.code != _PLAN_FOUND:
            raise self.failed(ended, out_of_time=_OUT_OF_TIME, out_of_memory=_OUT_OF_MEMORY)
        return read_plan_file(self.title, last_plan_file(folder, "plan*") or folder / "plan")
