"""Any planner that is a program and takes PDDL files, by one command line."""

from __future__ import annotations

import re
import shlex
from collections.abc import Collection, Sequence
from pathlib import Path, PurePosixPath

from skiros_py.errors import PlanningError, UsageError
from skiros_py.planning.planners.plan_files import last_plan_file, read_plan_file, steps_among
from skiros_py.planning.planners.planner import Answer, Solved, Unsolvable
from skiros_py.planning.planners.program_planner import DOMAIN, PROBLEM, CommandLinePlanner
from skiros_py.planning.planners.programs import USUAL_LIMITS, Ended, Limits

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
