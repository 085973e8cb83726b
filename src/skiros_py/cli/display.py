"""What a person sees during a run: skills found, goal, plan, progress, and the table at the end."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Self

from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.planning.plan import NoPlan
from skiros_py.planning.service import Planned
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.trace_writer import short_step

if TYPE_CHECKING:
    from skiros_py.station.session import Session

_FILE_WIDTH = 200
"""Columns of the table where it is not shown on a terminal."""


class RunDisplay:
    """Follows one session; lines for what is final, one live line for what is going on (on a terminal only)."""

    def __init__(self, session: Session, *, to_stderr: bool) -> None:
        self._session = session
        self._console = Console(stderr=to_stderr, highlight=False, soft_wrap=True)
        if not self._console.is_terminal:  # a file or a pipe has no width to fit
            self._console.width = _FILE_WIDTH
        self._live = Live(console=self._console, refresh_per_second=8, transient=True)
        self._skill = self._primitive = ""
        self._plans = 0
        session.monitor.subscribe(self._on_event)
        session.on_plan(self._on_plan)

    def __enter__(self) -> Self:
        self._show_start()
        if self._console.is_terminal:
            self._live.start()
            self._session.cycle.observe(self._refresh)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._live.stop()

    def say(self, text: str) -> None:
        """Prints one line."""
        self._console.print(text, markup=False)

    def _show_start(self) -> None:
        session = self._session
        robots = ", ".join(robot.id for robot in session.spec.robots)
        self.say(f"scene   {session.scene}: {robots}, seed {session.options.seed}")
        for agent, manager in sorted(session.managers.items()):
            for name, skill in sorted(manager.descriptions.items()):
                self.say(f"skill   {name:8} by {agent}: {skill.help}")
        for condition in session.goal:
            self.say(f"goal    {condition}")

    def _on_plan(self, planned: Planned) -> None:
        self._plans += 1
        for note in planned.notes:
            self.say(f"warning {note}")
        if isinstance(planned.outcome, NoPlan):
            for reason in planned.outcome.reasons:
                self.say(f"no plan {reason}")
            for repair in planned.outcome.repairs:
                self.say(f"        to make it work: {repair.text}")
            if elsewhere := self._session.catalogue.elsewhere:
                self.say(f"no plan {self._session.catalogue.why_elsewhere(*sorted(elsewhere))}")
            return
        self.say(f"plan    {'made' if self._plans == 1 else 'made again'} in {planned.wall * 1e3:.0f} ms")
        skills = {c.skill.name: c.skill for c in self._session.tasks.capabilities}
        for number, step in enumerate(planned.outcome.steps, start=1):
            self.say(f"  {number:2}. {short_step(step, skills[step.skill])}")

    def _on_event(self, event: ModuleEvent) -> None:
        if event.kind == "primitive":
            self._primitive = f"{event.module}: {event.text}" if event.status is not Status.STARTED else event.module
            if event.status is Status.ERROR:
                self.say(f"{event.time:8.1f} s    {event.module} failed: {event.text}")
            return
        self._primitive = event.text if event.status is Status.RUNNING else ""
        if event.status in (Status.STARTED, Status.RUNNING):
            self._skill = f"{event.module} {event.target}"
        else:
            mark = {Status.TERMINATED: "done", Status.ERROR: "failed", Status.PREEMPTED: "stopped"}[event.status]
            what = f"{event.module} {event.target}"
            self.say(f"{event.time:8.1f} s  {what} {mark}{': ' + event.text if event.text else ''}")

    def _refresh(self) -> None:
        snapshot = self._session.cycle.board.snapshot
        if snapshot.cycle % 20 == 0:
            line = f"{snapshot.time:8.1f} s  {self._skill}  {self._primitive}"
            self._live.update(Text(line[: self._console.width], style="cyan"))

    def show_report(self, report: GoalReport) -> None:
        """Prints the table: each goal condition, belief, truth, tries; then times."""
        if not report.steps and not report.no_plan and report.reached:
            self.say("the goal already holds: nothing to do")
        table = Table(box=None, pad_edge=False)
        for column in ("goal condition", "believed", "truth", "tries", "simulated", "wall", "why not"):
            table.add_column(column, justify="right" if column in ("tries", "simulated", "wall") else "left")
        for c in report.conditions:
            truth = "-" if c.true is None else _yes(c.true)
            times = _seconds(c.simulated), _seconds(c.wall)
            table.add_row(Text(c.condition), _yes(c.believed), truth, str(c.tries), *times, Text(c.reason))
        self._console.print(table)
        verdict = "stopped" if report.stopped else "goal reached" if report.reached else "goal not reached"
        self.say(f"{verdict}: {report.simulated:.1f} s simulated, {report.wall:.1f} s wall, digest {report.digest}")


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f} s"


def _yes(value: bool) -> str:
    return "yes" if value else "no"
