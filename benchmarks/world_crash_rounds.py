"""Rounds in which a process that writes to a world is killed: no acknowledged change may be lost.

The child announces each operation before it executes it and acknowledges it afterwards; the parent keeps a naive model
of the acknowledged operations, kills the child at a random moment, opens the directory and compares.
"""

from __future__ import annotations

import copy
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from skiros_py.errors import SkirosError
from skiros_py.world.element import Element, Placement, is_learned
from skiros_py.world.index import Index
from skiros_py.world.journal.data_directory import DataDirectory
from skiros_py.world.ontology import Ontology
from skiros_py.world.scene.learned import learned_turtle, read_learned
from skiros_py.world.transaction import Transaction
from skiros_py.world.world import World

_ROOT = Path(__file__).parents[1]
_ONTOLOGIES = (_ROOT / "ontologies" / "core.ttl", _ROOT / "src" / "skiros_py" / "testing" / "tiny.ttl")
_BOXES = ("box_a", "box_b", "box_c")
_SCENE = """\
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix tiny: <https://w3id.org/skiros-py/testing/tiny#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
scene:floor a sk:Floor ; rdfs:label "floor" .
scene:box_a a tiny:Box ; rdfs:label "box_a" ; sk:on scene:floor .
scene:box_b a tiny:Box ; rdfs:label "box_b" ; sk:on scene:floor .
scene:box_c a tiny:Box ; rdfs:label "box_c" ; sk:on scene:floor .
"""

Work = list[Any]
"""One operation: its name and its arguments."""


@dataclass(slots=True)
class Outcome:
    """The results of all rounds.

    Attributes:
        rounds: How many there were.
        acknowledged: Changes acknowledged to the child.
        unacknowledged: Changes that were found although the child was killed before their acknowledgement.
        compactions: Compactions that came to their end.
        faults: What was wrong, in words.
    """

    rounds: int = 0
    acknowledged: int = 0
    unacknowledged: int = 0
    compactions: int = 0
    faults: list[str] = field(default_factory=list)


def run(rounds: int, folder: Path, seed: int = 0) -> Outcome:
    """Kills a number of processes; see the module.

    Args:
        rounds: How many.
        folder: An empty folder to work in.
        seed: Of every random choice, but for the moments at which the processes are killed.
    """
    scene = folder / "scene.ttl"
    scene.write_text(_SCENE, encoding="utf-8")
    ontology = Ontology.load(_ONTOLOGIES)
    rng = random.Random(seed)  # noqa: S311
    outcome, model = Outcome(), _Model()
    with closing(_Children(folder)) as children:
        for number in range(rounds):
            said = children.until_killed(seed * 1_000_000 + number, rng)
            pending = _replay(model, said, outcome)
            if any("work" in line for line in said):
                model.shown = model.learned()  # it opened the directory, and that brought the file up to date
            model = _check(model, pending, ontology, folder, outcome, in_copy=rng.random() < 0.5)
            outcome.rounds += 1
            if outcome.faults:
                break
    return outcome


# ---------------------------------------------------------------- the model


class _Model:
    """The expected content, in plain dictionaries.

    Attributes:
        shown: What the file of what was learned shows where no child came to work since it was last looked at.
    """

    def __init__(self) -> None:
        self.things: dict[str, list[Any]] = {
            "floor": ["sk:Floor", "floor", {}],
            **{name: ["tiny:Box", name, {}] for name in _BOXES},
        }
        self.places: dict[str, tuple[str, str]] = dict.fromkeys(_BOXES, ("sk:on", "floor"))
        self.frames: dict[str, str] = {}
        self.goals: list[str] = []
        self.version = 1
        self.shown: dict[str, str] = {}
        self.ever = set(self.things)

    def do(self, work: Work) -> list[str]:
        """Executes one operation and returns the new ids."""
        before = copy.deepcopy(self._facts())
        given: list[str] = getattr(self, f"_{work[0]}")(*work[1:]) or []
        if self._facts() != before:
            self.version += 1
        return given

    def facts(self) -> object:
        """Returns the whole content, in the form of :func:`_facts`."""
        return (self.version, *copy.deepcopy(self._facts()))

    def learned(self) -> dict[str, str]:
        """Returns the labels of the learned concepts."""
        return {name: thing[1] for name, thing in self.things.items() if is_learned(name)}

    def _facts(self) -> tuple[object, ...]:
        return self.things, self.places, self.frames, self.goals

    def _add(self, box: str, masses: Sequence[float]) -> list[str]:
        names = [self._name("ball") for _ in masses]
        for name, mass in zip(names, masses, strict=True):
            self.things[name] = ["tiny:Ball", f"a ball of {mass} kg", {"sk:mass": mass}]
            self.places[name], self.frames[name] = ("sk:in", box), box
        return names

    def _swap(self, one: str, other: str) -> None:
        self.places[one], self.places[other] = self.places[other], self.places[one]

    def _set(self, name: str, property_: str, value: Any) -> None:
        self.things[name][2][property_] = value

    def _remove(self, *names: str) -> None:
        for name in names:
            del self.things[name], self.places[name], self.frames[name]

    def _teach(self, label: str) -> list[str]:
        name = self._name("learned:ball")
        self.things[name] = ["tiny:Ball", label, {"sk:appliesTo": "tiny:Ball"}]
        return [name]

    def _retell(self, name: str, label: str) -> None:
        self.things[name][1] = label

    def _forget(self, name: str) -> None:
        del self.things[name]

    def _aim(self, goals: list[str]) -> None:
        self.goals = sorted(set(goals))

    def _compact(self, keep: int) -> None:
        """Changes nothing."""

    def _mistake(self) -> None:
        """Is refused, and changes nothing."""

    def _name(self, stem: str) -> str:
        number = 1 + max((int(n.rpartition("_")[2]) for n in self.ever if n.rpartition("_")[0] == stem), default=0)
        self.ever.add(f"{stem}_{number}")
        return f"{stem}_{number}"


def _replay(model: _Model, said: Sequence[dict[str, Any]], outcome: Outcome) -> Work | None:
    """Executes in the model the operations acknowledged by the child; returns the one during which it died."""
    pending: Work | None = None
    for line in said:
        if "fault" in line:
            outcome.faults.append(line["fault"])
        elif "work" in line:
            pending = line["work"]
        elif "given" in line and pending is not None:
            before = model.version
            try:
                given = model.do(pending)
            except KeyError as error:
                outcome.faults.append(f"{pending} was done with {error}, which is not in the model")
                return None
            if (given, model.version) != (line["given"], line["version"]):
                outcome.faults.append(f"{pending}: {line}, and the model has {given}, version {model.version}")
            outcome.acknowledged += model.version - before
            outcome.compactions += pending[0] == "compact"
            pending = None
    return pending


def _check(
    model: _Model, pending: Work | None, ontology: Ontology, folder: Path, outcome: Outcome, *, in_copy: bool
) -> _Model:
    """Compares the content with the model; returns the model of the content."""
    after = copy.deepcopy(model)
    if pending is not None:
        after.do(pending)
    with _directory(folder, in_copy=in_copy) as path:
        if not path.exists():  # killed before it was made
            return model
        shown = _shown(ontology, path / "learned.ttl")
        if shown not in (model.shown, model.learned(), after.learned()):
            outcome.faults.append(f"learned.ttl shows {shown} and not {model.learned()}")
        model.shown = after.shown = shown
        try:
            with DataDirectory.open(path, ontology, scene=folder / "scene.ttl") as data:
                there = _facts(data.world)
                outcome.faults += _own_faults(data)
        except SkirosError as error:
            outcome.faults.append(str(error))
            return model
    if there == model.facts():
        return model
    if there != after.facts():
        outcome.faults.append(f"{there}\n  is neither {model.facts()}\n  nor, after {pending}, {after.facts()}")
    outcome.unacknowledged += 1
    return after


@contextmanager
def _directory(folder: Path, *, in_copy: bool) -> Iterator[Path]:
    """The directory itself, or a copy, so that the next child finds it as the killed one left it."""
    if not in_copy or not (folder / "data").exists():
        yield folder / "data"
        return
    shutil.copytree(folder / "data", folder / "copy")
    yield folder / "copy"
    shutil.rmtree(folder / "copy")


def _shown(ontology: Ontology, file: Path) -> dict[str, str]:
    """The labels in the file of learned concepts, which must be complete at any time."""
    if not file.exists():
        return {}
    world = read_learned(ontology, file)
    return {name: world.element(name).label for name in world.abstracts("sk:Element") if is_learned(name)}


def _own_faults(data: DataDirectory) -> Iterator[str]:
    first, version = data.journal.first, data.journal.version
    entries = data.journal.history()
    numbers = [entry.change.number for entry in entries]
    if numbers != list(range(first, version + 1)):
        yield f"changes {numbers} are remembered, not {first} to {version}"
    for entry in entries[-1:]:
        for name in entry.change.marks():
            if data.journal.history(name, last=1) != (entry,) or not data.journal.was_given(name):
                yield f"change {entry.change.number} is not in the history of {name}"
    file, text = data.path / "learned.ttl", learned_turtle(data.world.snapshot())
    if file.exists() and file.read_text(encoding="utf-8") != text:
        yield f"{file} is not up to date"


def _facts(world: World) -> object:
    state: Index = world.snapshot()
    names = [name for name in state.ids() if is_learned(name) or ":" not in name]
    things = {name: _thing(state.element(name)) for name in names}
    places = {name: (place.relation, place.place) for name in names if (place := state.placement(name))}
    frames = {name: frame for name in names for frame in state.objects(name, "sk:poseFrame")}
    return world.version, things, places, frames, list(state.goals)


def _thing(element: Element) -> list[object]:
    values = {name: list(v) if isinstance(v, tuple) else v for name, v in element.properties.items()}
    return [element.type, element.label, values]


# ---------------------------------------------------------------- killing


class _Children:
    """Forks children of a process that has imported everything, since a fresh start takes seconds."""

    def __init__(self, folder: Path) -> None:
        command = [sys.executable, __file__, str(folder)]
        self._mother = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def until_killed(self, seed: int, rng: random.Random) -> list[dict[str, Any]]:
        """Lets a child work, kills it at some moment, and returns its output."""
        assert self._mother.stdin is not None
        self._mother.stdin.write(b"%d\n" % seed)
        self._mother.stdin.flush()
        pid = self._line()["pid"]
        early = rng.random() < 0.25  # while it opens the directory; else while it writes
        lines = self._lines(1 if early else rng.randint(2, 120))
        time.sleep(rng.uniform(0.0, 0.06 if early else rng.choice([0.0003, 0.004])))
        with suppress(ProcessLookupError):  # a child at fault ends by itself
            os.kill(pid, signal.SIGKILL)
        return [*lines, *self._lines()] if not _dead(lines) else lines

    def close(self) -> None:
        """Ends the parent process."""
        assert self._mother.stdin is not None
        self._mother.stdin.close()
        self._mother.wait()
        assert self._mother.stdout is not None
        self._mother.stdout.close()

    def _lines(self, most: int | None = None) -> list[dict[str, Any]]:
        """Reads the output of the child, until it is dead or has written the requested amount."""
        lines: list[dict[str, Any]] = []
        while not _dead(lines) and (most is None or len(lines) < most):
            lines.append(self._line())
        return lines

    def _line(self) -> dict[str, Any]:
        assert self._mother.stdout is not None
        line: dict[str, Any] = json.loads(self._mother.stdout.readline())
        return line


def _dead(lines: Sequence[dict[str, Any]]) -> bool:
    return bool(lines) and "dead" in lines[-1]


# ---------------------------------------------------------------- the child


def _mother(folder: Path) -> None:
    """Forks a child for each line with a seed, and reports when it is dead."""
    ontology = Ontology.load(_ONTOLOGIES)
    while seed := sys.stdin.readline():
        pid = os.fork()
        if pid == 0:
            try:
                _child(folder, ontology, int(seed))
            finally:
                os._exit(0)
        os.waitpid(pid, 0)
        _say({"dead": pid})


def _child(folder: Path, ontology: Ontology, seed: int) -> None:
    _say({"pid": os.getpid()})
    rng = random.Random(seed)  # noqa: S311
    _say({"opens": True})
    try:
        data = DataDirectory.open(folder / "data", ontology, scene=folder / "scene.ttl")
        while True:
            work = _some_work(data.world, rng)
            _say({"work": work})
            given = _do(data, work)
            _say({"given": given, "version": data.world.version})
    except BaseException as error:  # noqa: BLE001  whatever it is, it is no kill
        _say({"fault": f"{type(error).__name__}: {error}"})


def _say(line: dict[str, Any]) -> None:
    os.write(1, json.dumps(line).encode() + b"\n")


def _some_work(world: World, rng: random.Random) -> Work:
    balls, learned = world.instances("tiny:Ball"), [n for n in world.abstracts("tiny:Ball") if is_learned(n)]
    makers: list[Callable[[], Work]] = [
        lambda: ["add", rng.choice(_BOXES), [rng.randint(1, 9) / 4 for _ in range(rng.randint(1, 5))]],
        lambda: ["teach", f"thing {rng.randint(0, 99)}"],
        lambda: ["aim", [f"In(ball_{rng.randint(1, 9)}, box_a)" for _ in range(rng.randint(0, 2))]],
        lambda: ["mistake"],
        lambda: ["compact", rng.randint(0, 60)],
    ]
    if len(balls) > 1:
        values = ("sk:mass", rng.random()), ("sk:missedLooks", rng.randint(0, 5)), ("sk:size", [rng.random(), 1.0])
        makers += 2 * [
            lambda: ["swap", *rng.sample(balls, 2)],
            lambda: ["set", rng.choice(balls), *rng.choice(values)],
            lambda: ["remove", *rng.sample(balls, min(len(balls), rng.randint(1, 4)))],
        ]
    if learned:
        makers += [
            lambda: ["retell", rng.choice(learned), f"thing {rng.randint(0, 99)}"],
            lambda: ["forget", rng.choice(learned)],
        ]
    return rng.choice(makers)()


def _do(data: DataDirectory, work: Work) -> list[str]:
    name, *rest = work
    if name == "compact":
        data.compact(*rest)
        return []
    try:
        with data.world.transaction("child", name) as tx:
            return _write(tx, data.world, name, rest)
    except SkirosError:
        if name != "mistake":
            raise
        return []


def _write(tx: Transaction, world: World, name: str, rest: list[Any]) -> list[str]:
    if name == "add":
        box, masses = rest
        return [_add(tx, box, mass) for mass in masses]
    if name == "teach":
        return [tx.add("tiny:Ball", rest[0], properties={"sk:appliesTo": "tiny:Ball"}, learned=True)]
    if name == "swap":
        one, other = (world.placement(ball) for ball in rest)
        assert one is not None
        assert other is not None
        tx.place(rest[0], other.relation, other.place)
        tx.place(rest[1], one.relation, one.place)
    elif name == "set":
        tx.set(rest[0], rest[1], tuple(rest[2]) if isinstance(rest[2], list) else rest[2])
    elif name in ("remove", "forget"):
        for element in rest:
            tx.remove(element)
    elif name == "retell":
        tx.set(rest[0], "rdfs:label", rest[1])
    elif name == "aim":
        tx.set_goals(rest[0])
    else:
        tx.add("tiny:Ball", placement=Placement("sk:in", "no_box"))
    return []


def _add(tx: Transaction, box: str, mass: float) -> str:
    ball = tx.add("tiny:Ball", f"a ball of {mass} kg", None, {"sk:mass": mass}, Placement("sk:in", box))
    tx.relate(ball, "sk:poseFrame", box)
    return ball


if __name__ == "__main__":
    _mother(Path(sys.argv[1]))
