"""One generated scene that runs in physics: what is done to it meanwhile, and what the truth shows."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from manipulation_scenes import Scene
from table import Figure

from skiros_py.config import ONTOLOGIES
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.geometry import Pose
from skiros_py.ports.values import Pending
from skiros_py.recording.pictures import HEIGHT, WIDTH, RunPictures, captioned, over_the_shoulder
from skiros_py.simulation.truth import RobotContact, Truth
from skiros_py.station.session import Options, Session
from skiros_py.system import default_simulation
from skiros_py.tasks.report import ConditionReport, GoalReport, StepReport

if TYPE_CHECKING:
    from PIL.Image import Image

_TRANSIENT, _HELD = 2, 100
"""Cycles over which forces are averaged: 10 ms and half a second."""


class Forces:
    """What the robot touches while a scene runs.

    Attributes:
        links: Which links touched each body.
    """

    def __init__(self) -> None:
        self._felt: dict[str, dict[int, float]] = defaultdict(dict)
        self.links: dict[str, set[str]] = defaultdict(set)

    def note(self, cycle: int, contacts: Iterable[RobotContact]) -> None:
        """Notes the contacts of a cycle."""
        for contact in contacts:
            if contact.force > 0.0:
                felt = self._felt[contact.body]
                felt[cycle] = felt.get(cycle, 0.0) + contact.force
                self.links[contact.body].add(contact.link)

    def transient(self, body: str) -> float:
        """Returns the greatest mean force on a body over 10 ms [N]."""
        return self._mean(body, _TRANSIENT)

    def held(self, body: str) -> float:
        """Returns the greatest mean force on a body over half a second [N]."""
        return self._mean(body, _HELD)

    def hit(self, body: str) -> Hit:
        """Returns both, and the links that touched a body."""
        return Hit(self.transient(body), self.held(body), ", ".join(sorted(self.links[body])))

    def _mean(self, body: str, window: int) -> float:
        felt = self._felt.get(body)
        if not felt:
            return 0.0
        series = np.zeros(max(felt) - min(felt) + 1)
        series[np.array(list(felt)) - min(felt)] = list(felt.values())
        return float(np.convolve(series, np.ones(window) / window).max())


class Stage(AbstractContextManager["Stage"]):
    """A generated scene that runs, and what is done to it meanwhile.

    Args:
        scene: The scene.
        folder: Where its files are written.
        pictures: True to take pictures.
        simulation: The engine that simulates; empty for the default one.
        films: Files for an animation of the run, or a contact sheet of its moments.

    Attributes:
        session: The open cell.
        truth: Looks behind the sensors.
        forces: What the robot touched.
        conditions: The reports on the goals that were pursued.
        steps: The steps that were done for them.
        shots: Pictures with their captions.
    """

    def __init__(
        self, scene: Scene, folder: Path, *, pictures: bool = False, simulation: str = "", films: Sequence[Path] = ()
    ) -> None:
        self.scene = scene
        path = scene.write(folder)
        os.environ[ONTOLOGIES] = str(folder / "parts")
        self.session = Session(str(path), Options(seed=scene.seed, simulation=simulation or default_simulation()))
        self.truth = Truth(self.session.simulation)
        self.start = dict(self.truth.poses())
        self.forces = Forces()
        self.conditions: list[ConditionReport] = []
        self.steps: list[StepReport] = []
        self.shots: list[tuple[str, Pending[Any]]] = []
        self._pictures = pictures
        self._waiting: list[tuple[float, Callable[[], object]]] = []
        self._cycles = count()
        self.session.cycle.observe(self._on_cycle)
        self.session.monitor.subscribe(self._on_event)
        self._films = [RunPictures(self.session.runtime, lambda *_: self._picture(), film) for film in films]

    def pursue(self, goals: Sequence[str]) -> GoalReport:
        """Lets the robot pursue a goal, and keeps what it reports."""
        report = self.session.run(list(goals))
        self.conditions += report.conditions
        self.steps += report.steps
        return report

    def later(self, delay: float, action: Callable[[], object]) -> None:
        """Does something after a delay, at the end of a cycle [s]."""
        self._waiting.append((self.session.cycle.board.snapshot.time + delay, action))

    def after(self, module: str, text: str, action: Callable[[], object], *, delay: float = 0.0) -> None:
        """Does something once, when a module ends well, or says something that begins with a text.

        Args:
            module: Name of the module.
            text: How the progress message begins; empty for its end.
            action: What is done.
            delay: How long after that [s].
        """
        done: list[bool] = []

        def on_event(event: ModuleEvent) -> None:
            wanted = event.text.startswith(text) if text else event.status is Status.TERMINATED
            if event.module == module and event.kind == "primitive" and wanted and not done:
                done.append(True)
                self.later(delay, action)

        self.session.monitor.subscribe(on_event)

    def shift(self, bodies: Iterable[str], about: str, by: Pose) -> None:
        """Moves bodies as one, by a pose in the frame of one of them."""
        frame = self.truth.pose(about)
        for body in bodies:
            moved = frame @ by @ frame.inverse() @ self.truth.pose(body)
            self.session.simulation.move_body(body, moved)

    def shoot(self, caption: str) -> None:
        """Takes a picture over the shoulder of the robot, if pictures are wanted."""
        if self._pictures:
            self.shots.append((caption, self._picture()))

    def _picture(self) -> Pending[Any]:
        robot = self.session.spec.robots[0]
        view = over_the_shoulder(self.truth.base_pose(robot.carrier.id) if robot.carrier else robot.place)
        return self.session.simulation.picture(*view, width=WIDTH, height=HEIGHT)

    def fixed(self) -> list[str]:
        """Returns the bodies that never move."""
        return [body.id for body in self.session.spec.bodies if body.mass == 0.0 and not body.compartment]

    def lying_on_parts(self) -> set[str]:
        """Returns the parts that lie on other parts now."""
        cell = self.session.simulation
        parts = {body.id for body in cell.scene.bodies.values() if body.mass > 0.0}
        found = (contact for part in sorted(parts) for contact in cell.scene.engine.contacts(part))
        return {c.body for c in found if c.other in parts and c.force > 0.0 and c.normal[2] > _ON_TOP}

    def moved(self, body: str) -> float:
        """Returns how far a body is from where it was at the start [m]."""
        return self.truth.pose(body).distance(self.start[body])

    def __exit__(self, *_: object) -> None:
        for film in self._films:
            film.write()
        self.session.close()

    def _on_cycle(self) -> None:
        self.forces.note(next(self._cycles), self.truth.contacts())
        now = self.session.cycle.board.snapshot.time
        due = [action for at, action in self._waiting if at <= now]
        self._waiting = [(at, action) for at, action in self._waiting if at > now]
        for action in due:
            action()

    def _on_event(self, event: ModuleEvent) -> None:
        if event.kind == "skill" and event.status is Status.ERROR and len(self.shots) < _MOST_SHOTS:
            self.later(0.0, lambda: self.shoot(f"{event.module} {event.target}: {event.text}"))


_ON_TOP = 0.5
"""Least vertical part of the normal where a part lies on another."""
_MOST_SHOTS = 4
"""So many failures in one scene are worth a picture."""


class Hit(NamedTuple):
    """Mean forces over 10 ms and over half a second [N], and the links that touched."""

    transient: float
    held: float
    links: str


@dataclass(frozen=True, eq=False)
class Trial:
    """What happened in one scene.

    Attributes:
        scene: The scene.
        conditions: What the robot reported of each condition, and the truth.
        first: For each wanted part whether no step with it failed.
        hits: What it should not have touched, by body.
        facts: What else the campaign measured, by name.
        misses: What was not as it should be, each with its cause.
        pictures: Pictures of it.
    """

    scene: Scene
    conditions: Sequence[ConditionReport]
    first: Sequence[bool]
    hits: dict[str, Hit]
    facts: dict[str, float]
    misses: list[str]
    pictures: list[Image] = field(default_factory=list)

    @property
    def transient(self) -> float:
        """Greatest mean force over 10 ms on what it should not have touched [N]."""
        return max((hit.transient for hit in self.hits.values()), default=0.0)

    @property
    def held(self) -> float:
        """Greatest mean force over half a second on what it should not have touched [N]."""
        return max((hit.held for hit in self.hits.values()), default=0.0)

    @property
    def is_honest(self) -> bool:
        """True if what is believed of every condition is the truth."""
        return all(one.believed == one.true for one in self.conditions)

    @property
    def reached(self) -> bool:
        """True if every condition holds by the truth."""
        return all(one.true for one in self.conditions)


class Campaign(ABC):
    """What is tried in many scenes; a campaign of its own overrides what is different in it."""

    name = ""

    @abstractmethod
    def scene(self, seed: int) -> Scene:
        """Generates a scene."""

    def run(self, stage: Stage) -> dict[str, float]:
        """Runs a scene, and returns what is measured besides conditions and contacts."""
        stage.pursue(stage.scene.goals)
        return {}

    def must_not_touch(self, stage: Stage) -> Iterable[str]:
        """Returns the bodies that the robot must not touch: all that never move, besides the kit that it works in."""
        return [body for body in stage.fixed() if body != "kit_1"]

    def faults(self, stage: Stage, facts: dict[str, float]) -> Iterator[str]:  # noqa: ARG002
        """Yields what else was not as it should be, for people."""
        yield from ()

    @abstractmethod
    def figures(self, trials: Sequence[Trial]) -> list[Figure]:
        """Returns the figures of all scenes."""

    def trial(
        self, scene: Scene, folder: Path, *, pictures: bool = False, simulation: str = "", films: Sequence[Path] = ()
    ) -> Trial:
        """Runs one scene, and judges it; the arguments are those of :class:`Stage`."""
        with Stage(scene, folder, pictures=pictures, simulation=simulation, films=films) as stage:
            stage.shoot("start")
            facts = self.run(stage)
            hits = {body: hit for body in self.must_not_touch(stage) if (hit := stage.forces.hit(body)).transient > 0.0}
            misses = [_cause(stage, one) for one in stage.conditions if not one.true or one.believed != one.true]
            misses += [
                f"{b} touched with {t:.0f} N in 10 ms, {h:.0f} N held, by {by}" for b, (t, h, by) in hits.items()
            ]
            misses += self.faults(stage, facts)
            stage.shoot("; ".join(misses) or "as wanted")
            images = [captioned(shot.result(), f"{scene.name} {text}") for text, shot in stage.shots]
            return Trial(scene, stage.conditions, _first_tries(stage.steps), hits, facts, misses, images)


def _cause(stage: Stage, one: ConditionReport) -> str:
    """Says why a condition is missing, and where parts really are that are believed elsewhere."""
    world, really = stage.session.world, stage.truth.placements()
    placed = {part: world.placement(part) if world.has(part) else None for part in really}
    believed = {part: "nowhere" if at is None else at.place for part, at in placed.items()}
    elsewhere = [
        f"{part} is {really[part]}, believed {place}" for part, place in believed.items() if place != really[part]
    ]
    parts = [f"{part} is {place}" for part, place in really.items() if part in one.condition]
    truth = ", ".join(dict.fromkeys([*parts, *elsewhere])) or "parts are where they are believed"
    failed = [f"{s.skill} at {s.start:.0f} s: {s.reason}" for s in stage.steps if s.reason]
    tried = f"; failed steps: {' | '.join(dict.fromkeys(failed))}" if failed else ""
    belief = "believed" if one.believed else f"not believed ({one.reason})"
    return f"{one.condition}: {belief}, truth {one.true}: {truth}{tried}"


def _first_tries(steps: Sequence[StepReport]) -> list[bool]:
    """Returns for each part that was handled whether no step with it failed."""
    parts: dict[str, bool] = {}
    for step in steps:
        if (name := step.arguments.get("Object")) is not None:
            parts[name] = parts.get(name, True) and not step.reason
    return list(parts.values())


# ---------------------------------------------------------------- figures


def share(what: str, good: Sequence[bool], least: float) -> Figure:
    """Returns the figure of how many of some are right, with the least share [%]."""
    right = sum(good)
    percent = 100.0 * right / len(good) if good else 0.0
    return Figure(what, f"{right} of {len(good)}, {percent:.1f} %", f">= {least:g} %", bool(good) and percent >= least)


def none(what: str, faults: Iterable[bool]) -> Figure:
    """Returns the figure of what must never be so."""
    number = sum(faults)
    return Figure(what, str(number), "0", number == 0)


def at_most(what: str, values: Sequence[float], most: float, unit: str, compared: str = "") -> Figure:
    """Returns the figure of values, none of which may exceed a bound."""
    over = sum(value > most for value in values)
    shown = (
        f"median {np.median(values):.1f}, max {max(values):.1f} {unit}, {over} of {len(values)} over" if values else "-"
    )
    return Figure(what, shown, f"<= {most:g} {unit}", not over, compared)


def conditions(trials: Sequence[Trial], least: float) -> Figure:
    """Returns the share of conditions that hold by the truth [%]."""
    return share("conditions that hold by the truth", [bool(c.true) for t in trials for c in t.conditions], least)


def honest(trials: Sequence[Trial]) -> Figure:
    """Returns in how many scenes the belief is not the truth."""
    return none("scenes in which belief is not truth", (not trial.is_honest for trial in trials))


def first_tries(trials: Sequence[Trial]) -> Figure:
    """Returns how many parts were handled without a failed step."""
    first = [right for trial in trials for right in trial.first]
    return Figure("parts without a failed step", f"{sum(first)} of {len(first)}")
