"""Fast Downward as a program.

The planner is GPL-licensed and comes with the ``up-fast-downward`` package; it is started, never imported. Its two
parts, translator and search, run one after the other in one process that a resident program forks: the driver that
usually starts them, and the translator, are Python programs whose start takes longer than most tasks.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from skiros_py.errors import PlanningError
from skiros_py.planning.planners.plan_files import read_plan_file
from skiros_py.planning.planners.planner import Answer, Unsolvable
from skiros_py.planning.planners.program_planner import DOMAIN, PROBLEM, ProgramPlanner
from skiros_py.planning.planners.programs import Ended, Limits, Running
from skiros_py.planning.planners.resident import Resident, Run

LAMA_FIRST = (
    "let(hlm, "
    "eval_modify_costs(landmark_sum(lm_factory=lm_reasonable_orders_hps(lm_rhw()), pref=false), cost_type=one), "
    "let(hff, eval_modify_costs(ff(), cost_type=one), "
    "lazy_greedy([hff, hlm], preferred=[hff, hlm], cost_type=one, reopen_closed=false)))"
)
"""What the driver calls lama-first: the first search of LAMA (Richter & Westphal 2010); it ends at the first plan."""

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
    supports = frozenset(
        {
            ":strips", ":typing", ":equality", ":negative-preconditions", ":disjunctive-preconditions",
            ":existential-preconditions", ":universal-preconditions", ":quantified-preconditions",
            ":conditional-effects", ":adl", ":derived-predicates", ":action-costs",
        }
    )  # fmt: skip

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
        search = (str(self._programs / "downward"), "--search", self._search, "--internal-plan-file", "plan")
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
        if ended.code in _OUT_OF_MEMORY:
            raise PlanningError(f"{self.title} ran out of memory (it may take {_gibibytes(self.limits.memory)})")
        if ended.code in _OUT_OF_TIME:
            raise PlanningError(f"{self.title} found no answer in {self.limits.time:g} s")
        if ended.code != _PLAN_FOUND:
            raise PlanningError(f"{self.title} {ended.words}")
        return read_plan_file(self.title, folder / "plan")


def _gibibytes(memory: int | None) -> str:
    return "any" if memory is None else f"{memory / (1 << 30):.2g} GiB"
