"""A planner that is a program: a private folder for each call, limits, and everything killed at the end."""

from __future__ import annotations

import re
import shlex
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path, PurePosixPath
from threading import Event

from skiros_py.errors import PlanningError, UsageError
from skiros_py.planning.planners.planner import Answer, FuturePending, Solved, Unsolvable
from skiros_py.programs import USUAL_LIMITS, Child, Ended, Limits, ProgramError, Running, run_program

_STEP = re.compile(
    r"(?:(?P<start>\d+(?:\.\d+)?)\s*:\s*)?"  # 0.003:
    r"\(\s*(?P<words>[^()\s][^()]*)\)"  # (drive base_1 robot_1 box_a floor)
    r"(?:\s*\[\s*(?P<duration>\d+(?:\.\d+)?)[^\]]*\])?"  # [12.000]
)
_LONGEST = 16 << 20
"""Maximum size of a plan file [bytes]."""


def read_plan_text(title: str, text: str) -> Solved:
    """Reads a plan file.

    Args:
        title: What people call the planner.
        text: Lines such as ``(drive base_1 box_a)`` or ``0.000: (drive base_1 box_a) [5.000]``, and comments after
            semicolons.

    Raises:
        PlanningError: A line is not a step; or only some steps have a time.
    """
    found = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition(";")[0].strip()
        if not words:
            continue
        step = _STEP.fullmatch(words)
        if step is None:
            shown = words if len(words) <= 80 else words[:80] + "…"
            raise PlanningError(f"{title} wrote a plan whose line {number} is no step: '{shown}'")
        found.append(step)
    return _solved(title, found)


def read_plan_file(title: str, path: Path) -> Solved:
    """Reads a plan file; see :func:`read_plan_text`.

    Raises:
        PlanningError: It is not a plan, or cannot be read.
    """
    try:
        with path.open("rb") as file:
            content = file.read(_LONGEST + 1)
    except OSError as error:
        raise PlanningError(f"{title} wrote a plan that cannot be read: {error.strerror}") from error
    if len(content) > _LONGEST:
        raise PlanningError(f"{title} wrote a plan of more than {_LONGEST >> 20} MiB")
    return read_plan_text(title, content.decode("utf-8", errors="replace"))


def last_plan_file(folder: Path, pattern: str) -> Path | None:
    """Returns the plan file in a folder; the last, where a planner that improves its plans has numbered them."""
    found = [path for path in folder.glob(pattern) if path.is_file() and not path.is_symlink()]
    return max(found, key=lambda path: (len(path.name), path.name), default=None)


def steps_among(title: str, text: str) -> Solved | None:
    """Finds the steps in a planner's output; None if there are none."""
    found = [step for line in text.splitlines() if (step := _STEP.fullmatch(line.partition(";")[0].strip()))]
    return _solved(title, found) if found else None


def _solved(title: str, found: Iterable[re.Match[str]]) -> Solved:
    steps = list(found)
    timed = [step for step in steps if step["start"] is not None]
    if len(timed) not in (0, len(steps)):
        raise PlanningError(f"{title} wrote a plan in which {len(timed)} of {len(steps)} steps have a time")
    timed.sort(key=lambda step: float(step["start"]))
    return Solved(
        tuple(tuple(step["words"].lower().split()) for step in timed or steps),
        tuple(float(step["start"]) for step in timed),
        tuple(float(step["duration"] or 0.0) for step in timed),
    )


DOMAIN, PROBLEM = "domain.pddl", "problem.pddl"
"""Names of the files in the folder of a call."""


class ProgramPlanner(ABC):
    """The common base of planners that are programs.

    Args:
        limits: Resource limits of each call; a safeguard, not a means of control.

    Attributes:
        name: The name by which users select it.
        title: Its name in messages.
        supports: The PDDL requirements it supports.
        is_alone: True if it is known to start no programs that leave its process group.
        limits: Resource limits of each call.
    """

    name: str
    title: str
    supports: frozenset[str]
    is_alone = False

    def __init__(self, limits: Limits = USUAL_LIMITS) -> None:
        self.limits = limits
        self._threads = ThreadPoolExecutor(thread_name_prefix=self.name)
        self._closed = False

    @abstractmethod
    def start(self, folder: Path, environment: Mapping[str, str]) -> Running:
        """Starts the program in a folder.

        Raises:
            PlanningError: It cannot be started.
        """

    def failed(self, ended: Ended, *, out_of_time: Collection[int], out_of_memory: Collection[int]) -> PlanningError:
        """Returns the error that a program ended without an answer.

        Args:
            ended: How it ended.
            out_of_time: Exit codes of a program that ran out of time.
            out_of_memory: Exit codes of a program that ran out of memory.
        """
        if ended.code in out_of_memory:
            memory = "any" if self.limits.memory is None else f"{self.limits.memory / (1 << 30):.2g} GiB"
            return PlanningError(f"{self.title} ran out of memory (it may take {memory})")
        if ended.code in out_of_time:
            return PlanningError(f"{self.title} found no answer in {self.limits.time:g} s")
        return PlanningError(f"{self.title} {ended.words}")

    @abstractmethod
    def read(self, ended: Ended, folder: Path) -> Answer:
        """Reads the answer of a program that has ended.

        Raises:
            PlanningError: It has none.
        """

    def prepare(self, folder: Path) -> None:  # noqa: B027 - most programs need no more than the two files
        """Puts further files the program needs into its folder."""

    def solve(self, domain: str, problem: str) -> FuturePending[Answer]:
        """Starts solving; several calls may be under way at once.

        Raises:
            PlanningError: The planner is closed.
        """
        if self._closed:
            raise PlanningError(f"{self.title} was stopped")
        stop = Event()
        try:
            future = self._threads.submit(self._solve, domain, problem, stop)
        except RuntimeError as error:  # closed concurrently by another thread
            raise PlanningError(f"{self.title} was stopped") from error
        return FuturePending(future, stop.set, f"{self.title} was stopped")

    def close(self) -> None:
        """Kills running calls and waits for them; may be called twice."""
        self._closed = True
        self._threads.shutdown(wait=True, cancel_futures=True)

    def _solve(self, domain: str, problem: str, stop: Event) -> Answer:
        try:
            with tempfile.TemporaryDirectory(prefix="skiros-plan-", ignore_cleanup_errors=True) as name:
                return self._solve_in(Path(name), domain, problem, stop)
        except OSError as error:
            raise PlanningError(f"{self.title}: {error}") from error
        except ProgramError as error:
            raise PlanningError(str(error)) from error.__cause__

    def _solve_in(self, folder: Path, domain: str, problem: str, stop: Event) -> Answer:
        (folder / DOMAIN).write_text(domain, encoding="utf-8")
        (folder / PROBLEM).write_text(problem, encoding="utf-8")
        self.prepare(folder)
        start = partial(self.start, folder)
        ended = run_program(
            self.title, start, self.limits, lambda: self._closed or stop.is_set(), is_alone=self.is_alone
        )
        return self.read(ended, folder)


class CommandLinePlanner(ProgramPlanner):
    """A planner that is one command line."""

    @abstractmethod
    def command(self, domain: str, problem: str) -> Sequence[str]:
        """Returns the command line for two files in the folder where it will run."""

    def start(self, folder: Path, environment: Mapping[str, str]) -> Child:
        """Starts the program in a folder."""
        return Child(self.title, self.command(DOMAIN, PROBLEM), folder, self.limits, environment)


CLASSICAL = frozenset({":strips", ":typing"})
"""The requirements that every planner supports."""
EVERYTHING = CLASSICAL | {
    ":adl", ":action-costs", ":derived-predicates", ":fluents", ":object-fluents", ":durative-actions",
    ":duration-inequalities", ":continuous-effects", ":timed-initial-literals", ":preferences", ":constraints", ":time",
}  # fmt: skip
"""For a planner without declared requirements: it reports unsupported ones itself."""
_OWN_PLAN_FILE = "plan"
_USUAL_PLAN_FILES = ("plan*", "sas_plan*", "*.soln", "*.plan")


class CommandPlanner(CommandLinePlanner):
    """Runs a command line; the planner's own plan file, or what it prints, is read as the plan.

    >>> pyperplan = CommandPlanner("pyperplan", "pyperplan -s gbf -H hff {domain} {problem}", plan="{problem}.soln")
    >>> pyperplan.command("domain.pddl", "problem.pddl")[-2:]
    ['domain.pddl', 'problem.pddl']

    Args:
        name: The name by which users select it.
        template: The command line, as it is typed in a shell; ``{domain}`` and ``{problem}`` stand for the files,
            ``{plan}`` for the plan file to be written.
        plan: The file where the planner writes its plan by itself, such as "{problem}.soln" or, if it numbers its
            plans, "best*"; None if the template names ``{plan}``, it has a usual name, or the plan is printed.
        supports: The PDDL requirements it can take.
        no_plan: Its output, as a regular expression, or its exit codes, when it has proved that there is no plan.
        limits: Resource limits of each call.

    Raises:
        UsageError: The template or the place of the plan cannot work.
    """

    def __init__(
        self,
        name: str,
        template: str,
        *,
        plan: str | None = None,
        supports: Collection[str] = CLASSICAL,
        no_plan: str | Collection[int] = (),
        limits: Limits = USUAL_LIMITS,
    ) -> None:
        self.name = name
        self.title = f"planner '{name}'"
        self.supports = frozenset(supports)
        self._words = _words(template)
        named = any("{plan}" in word for word in self._words)
        self._plans = (plan,) if plan else (_OWN_PLAN_FILE,) if named else _USUAL_PLAN_FILES
        if plan and _leaves(plan):
            raise UsageError(f"planner '{name}': plan '{plan}' must be a file in the folder where the planner runs")
        self._no_plan = no_plan
        super().__init__(limits)

    def command(self, domain: str, problem: str) -> Sequence[str]:
        """Returns the command line for two files."""
        return [_filled(word, domain, problem) for word in self._words]

    def read(self, ended: Ended, folder: Path) -> Answer:
        """Reads the plan file; if none is configured or found, the planner's output."""
        if self._proved(ended):
            return Unsolvable()
        if ended.code != 0:
            raise PlanningError(f"{self.title} {ended.words}")
        return self._plan(ended, folder) or Unsolvable(f"it left no plan, and {ended.words}", proven=False)

    def _plan(self, ended: Ended, folder: Path) -> Solved | None:
        for pattern in self._plans:
            path = last_plan_file(folder, _filled(pattern, DOMAIN, PROBLEM))
            if path is not None:
                return read_plan_file(self.title, path)
        if self._plans is _USUAL_PLAN_FILES:
            return steps_among(self.title, ended.output)
        for pattern in self._plans:
            for path in folder.glob(_filled(pattern, DOMAIN, PROBLEM)):
                raise PlanningError(f"{self.title} left '{path.name}', which is {_kind(path)} and no plan file")
        return None

    def _proved(self, ended: Ended) -> bool:
        if isinstance(self._no_plan, str):
            return re.search(self._no_plan, ended.output) is not None
        return ended.code in self._no_plan


def _words(template: str) -> list[str]:
    """Splits a command line.

    Raises:
        UsageError: It is malformed, or does not name both files.
    """
    try:
        words = shlex.split(template)
    except ValueError as error:
        raise UsageError(f"planner command '{template}': {error}") from error
    missing = [file for file in ("{domain}", "{problem}") if not any(file in word for word in words)]
    if missing:
        named = " and ".join(missing)
        raise UsageError(f"planner command '{template}': it must name {named}, for example:\n{_EXAMPLE}")
    unknown = sorted({hole for word in words for hole in re.findall(r"\{\w*\}", word)} - _HOLES)
    if unknown:
        raise UsageError(f"planner command '{template}': {', '.join(unknown)} is none of {', '.join(sorted(_HOLES))}")
    return words


_HOLES = {"{domain}", "{problem}", "{plan}"}
_EXAMPLE = "  pyperplan -s gbf -H hff {domain} {problem}"


def _filled(text: str, domain: str, problem: str) -> str:
    values = {"{domain}": domain, "{problem}": problem, "{plan}": _OWN_PLAN_FILE}
    for hole, value in values.items():
        text = text.replace(hole, value)
    return text


def _kind(path: Path) -> str:
    """Describes a path that is not a regular file."""
    if path.is_symlink():
        return "a link"
    return "a folder" if path.is_dir() else "a pipe or device"


def _leaves(path: str) -> bool:
    """Returns whether a path leads out of its folder."""
    return PurePosixPath(path).is_absolute() or ".." in PurePosixPath(path).parts
