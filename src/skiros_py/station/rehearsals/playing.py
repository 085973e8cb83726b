"""The process of a rehearsal: plans, carries the plan out in a world of its own, and plans again with what it found."""

from __future__ import annotations

import os
import pickle
import socket
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from skiros_py.errors import SkirosError
from skiros_py.interruptions import UserStop, raise_in
from skiros_py.messages import Message, joined
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.requests import RuledOut
from skiros_py.planning.service import Planned
from skiros_py.processes import packed, receive, send
from skiros_py.skills.outcome import CANCELLED, OBSTRUCTED, Failure, Outcome
from skiros_py.station.recordings.topics import camera_of
from skiros_py.station.rehearsals.order import MARK, RehearsalOrder
from skiros_py.station.session import Session
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.record import would_fail_again
from skiros_py.tasks.rehearsal import Play, Rehearsal, RehearsedStep, Round, StepState
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.trace import StepRun, describe_step, short_step
from skiros_py.world.change import Writer
from skiros_py.world.scene.learned import import_learned

_STREAM = 7
"""What a rehearsal draws has nothing to do with what a simulation of the same seed draws: that would be the truth."""
_GEOMETRY = frozenset({"reach", "collision", "constraint", "singularity", "limits", "not found", "no room"})
"""Causes that lie in the shapes and places of things."""

Tell = Callable[[Round | RehearsedStep], object]
"""Receives each step that has ended, and each round."""


def main(control: int, mark: str) -> None:
    """Plays the rehearsal that the process at the other end of a socket orders, until that goes away.

    Args:
        control: Descriptor of the socket.
        mark: Marks the programs of this rehearsal.
    """
    os.environ[MARK] = mark
    with socket.socket(fileno=control) as parent:
        order: RehearsalOrder = pickle.loads(receive(parent)[0])  # noqa: S301  from our own parent
        main_thread = threading.main_thread().ident
        assert main_thread is not None
        threading.Thread(target=_end_with, args=(parent, main_thread), daemon=True).start()
        answer: Rehearsal | SkirosError
        try:
            answer = rehearse(order, lambda event: send(parent, packed(event)))
        except SkirosError as error:
            answer = error
        send(parent, packed(answer))


def _end_with(parent: socket.socket, main_thread: int) -> None:
    """Waits until the other end is closed; then everything that was opened is closed."""
    while parent.recv(1):
        pass
    raise_in(main_thread, UserStop)


def rehearse(order: RehearsalOrder, tell: Tell = lambda _event: None) -> Rehearsal:
    """Plays a rehearsal in this process.

    Args:
        order: What is to be rehearsed.
        tell: Receives what happens, as it happens.

    Raises:
        SkirosError: The second world cannot be opened, the goal cannot be read, or planning broke.
    """
    started, ruled_out = time.perf_counter(), list(order.ruled_out)
    rounds: list[Round] = []
    with tempfile.TemporaryDirectory(prefix="skiros-rehearsal-") as folder:
        scene = Path(folder) / f"{order.name}.ttl"
        scene.write_text(order.scene, encoding="utf-8")
        while len(rounds) < order.rounds:
            round_ = _round(order, scene, ruled_out, len(rounds), tell)
            rounds.append(round_)
            tell(round_)
            found = [one for play in round_.plays for one in play.ruled_out if one not in ruled_out]
            ruled_out += found
            if not found:
                break
    return Rehearsal(tuple(rounds), tuple(ruled_out), order.assumptions, time.perf_counter() - started)


def _round(order: RehearsalOrder, scene: Path, ruled_out: Sequence[RuledOut], number: int, tell: Tell) -> Round:
    plays: list[Play] = []
    for draw in range(order.draws):
        options = replace(order.options, seed=_seed(order.options.seed, draw))
        with Session(str(scene), options) as session:
            if order.learned:
                _learn(session, order.learned, scene.parent)
            player = _Player(session, f"{number + 1}-{draw + 1}", order, tell)
            play = player.play(draw, ruled_out)
        if isinstance(play, Round):
            return play
        plays.append(play)
        if play.ruled_out:
            break
    return Round(tuple(plays))


def _seed(seed: int, draw: int) -> int:
    return int(np.random.SeedSequence([seed, _STREAM, draw]).generate_state(1)[0])


def _learn(session: Session, learned: str, folder: Path) -> None:
    file = folder / "learned.ttl"
    file.write_text(learned, encoding="utf-8")
    with session.world.transaction("rehearsal", Message("learned before"), writer=Writer.SYSTEM) as tx:
        import_learned(session.world, tx, file)


class _Player:
    """Carries out one plan in one world.

    Args:
        session: The world.
        name: For the names of pictures.
        order: What is to be rehearsed.
        tell: Receives each step that has ended.
    """

    def __init__(self, session: Session, name: str, order: RehearsalOrder, tell: Tell) -> None:
        self._session, self._name, self._order, self._tell = session, name, order, tell
        self._task: TaskHandle | None = None
        self._steps: list[RehearsedStep] = []
        self._failed: dict[str, RehearsedStep] = {}
        self._begun: Counter[str] = Counter()  # of the current plan
        self._failures: Counter[tuple[str, str]] = Counter()
        self._found: list[RuledOut] = []
        self._why_ended = ""
        session.tasks.on_begin(self._follow)
        session.on_plan(self._note_plan)
        session.cycle.observe(self._watch_time)

    def play(self, draw: int, ruled_out: Sequence[RuledOut]) -> Play | Round:
        """Plays the plan that avoids what was ruled out; returns a round without plays where there is none."""
        report = self._session.run(self._order.goal or None, ruled_out=ruled_out)
        if report.no_plan and not self._found:
            return Round(no_plan=report.no_plan)
        steps = (*self._steps, *self._not_tried(report))
        return Play(draw, steps, report.reached, self._reason(report), report.simulated, tuple(self._found))

    def _follow(self, task: TaskHandle) -> None:
        self._task = task
        task.after_step(self._after_step)

    def _note_plan(self, planned: Planned) -> None:
        if isinstance(planned.outcome, Plan):
            self._begun.clear()

    def _watch_time(self) -> None:
        if self._task is not None and self._session.cycle.board.now > self._order.limit:
            self._why_ended = Message("it takes longer than {limit:.0f} s", limit=self._order.limit)
            self._task.stop(self._why_ended)

    def _after_step(self, run: StepRun, outcome: Outcome) -> None:
        """Notes how a step went; one that shows something to be impossible ends the play."""
        assert self._task is not None
        skills = self._session.tasks.skills
        skill, failure = skills[run.step.skill], outcome if isinstance(outcome, Failure) else None
        if failure is not None and failure.code == CANCELLED and self._found:
            return
        key = describe_step(run.step, skill)
        before = self._failed.pop(key, None)
        step = RehearsedStep(
            short_step(run.step, skill),
            run.step.skill,
            dict(run.step.arguments),
            StepState.DONE,
            (before.tries if before else 0) + 1,
            seconds=(before.seconds if before else 0.0) + self._session.cycle.board.now - run.start,
        )
        if failure is not None:
            cause, bodies = str(failure.values.get("cause", "")), _bodies(failure.values)
            step = replace(step, state=StepState.FAILED, reason=failure.reason, cause=cause, bodies=bodies)
            self._failed[key] = step = replace(step, picture=self._picture(run))
        elif before is not None:
            step = replace(before, state=StepState.DONE, tries=step.tries, seconds=step.seconds)
        if before is not None:
            self._steps.remove(before)
        if before is None or not self._begun[key]:
            self._begun[key] += 1
        self._steps.append(step)
        self._tell(step)
        if failure is not None and failure.code not in (CANCELLED, OBSTRUCTED):
            self._found += self._impossible(run.step, failure)
            if self._found:
                self._task.stop(Message("the plan does not work"))

    def _impossible(self, step: Step, failure: Failure) -> tuple[RuledOut, ...]:
        """Returns which attempts a failure rules out: at once if out of reach, else if it comes again and again."""
        skill, cause = self._session.tasks.skills[step.skill], failure.values.get("cause")
        if cause not in _GEOMETRY:
            return ()
        if failure.is_out_of_reach:
            return would_fail_again(step, skill, failure, self._session.world)
        agent, target = step.arguments[skill.agent], step.arguments[skill.target]
        self._failures[step.skill, target] += 1
        assert self._task is not None
        if self._failures[step.skill, target] < self._task.policy.attempts:
            return ()
        return (RuledOut(step.skill, agent, target, None, failure.reason),)

    def _picture(self, run: StepRun) -> str:
        folder, camera = self._order.pictures, camera_of(self._session)
        if folder is None or camera is None:
            return ""
        from skiros_py.recording.pictures import webp  # needs Pillow

        file = folder / f"{self._name}-{run.number}-{run.step.skill}.webp"
        file.write_bytes(webp(camera(self._session.cycle.board.snapshot, run.agent).result()))
        return str(file)

    def _not_tried(self, report: GoalReport) -> list[RehearsedStep]:
        """Returns the steps of the plan that were not run."""
        plan = self._task.plan if self._task is not None else None
        if plan is None or report.reached:
            return []
        skills = self._session.tasks.skills
        begun, left = self._begun.copy(), []
        for step in plan.steps:
            key = describe_step(step, skills[step.skill])
            if not begun[key]:
                text = short_step(step, skills[step.skill])
                left.append(RehearsedStep(text, step.skill, dict(step.arguments), StepState.NOT_TRIED))
            begun[key] -= bool(begun[key])
        return left

    def _reason(self, report: GoalReport) -> str:
        """Returns why the goal was not reached, as the task says or as the world shows."""
        if report.reached:
            return ""
        if self._found or self._why_ended:
            return self._found[0].reason if self._found else self._why_ended
        missing = [c for c in report.conditions if not (c.believed if c.true is None else c.true)]
        said = (c.reason or Message("{condition} is believed, but not so", condition=c.condition) for c in missing)
        return joined("; ", dict.fromkeys(said)) or report.fault or Message("stopped before it was reached")


def _bodies(values: Mapping[str, object]) -> tuple[str, ...]:
    """Returns the ids of what a failure is about, of any of its values that has some."""
    found: list[str] = []
    for name in ("bodies", "out_of_reach", "blocked_by", "not_seen"):
        value = values.get(name, ())
        found += [value] if isinstance(value, str) else [str(one) for one in value] if isinstance(value, list) else []
    return tuple(found)
