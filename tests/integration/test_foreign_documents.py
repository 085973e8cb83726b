"""A net with two tokens and a reactive node from an outside wheel: edited as documents, reloaded, drawn, recorded."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest
from support.serving import serving

from skiros_py.api.documents import DocumentInfo
from skiros_py.errors import DocumentError, DocumentFault, NotFound, StaleVersion, UnknownName, UsageError
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.recording import Recorder, Recording, RecordingWriter
from skiros_py.skills.behaviour import nodes_of
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.station.alarms.alarms import Alarms
from skiros_py.station.document_store import DocumentStore
from skiros_py.station.documents import DocumentService
from skiros_py.station.events.log import EventLog
from skiros_py.station.requests import Seen
from skiros_py.station.session import Options, Session
from skiros_py.testing import TINY_ONTOLOGY, tiny_scene

WHEEL = '''
from collections import Counter
from dataclasses import dataclass
from types import MappingProxyType

from skiros_py.behaviours import Behaviour, DocumentKind, Edge, Uses
from skiros_py.errors import DescriptionError, DocumentError, DocumentFault
from skiros_py.skills.outcome import tick
from skiros_py.skills.outcome import Failure, Success
from skiros_py.skills.parameters import param
from skiros_py.skills.primitive import Primitive


class Note(Primitive):
    """Announces a text."""

    name = "note"

    @dataclass(frozen=True, slots=True)
    class Params:
        text: str = param("text", "What is announced.")

    def execute(self):
        self.emit("noted", self.params.text)
        yield
        return Success(self.params.text)


@dataclass(frozen=True, slots=True)
class Net(Behaviour):
    """A place/transition net; it ends when its goal place holds enough tokens, or nothing can fire."""

    kind = "net"
    transitions: object
    inputs: object
    outputs: object
    tokens: object
    goal: str
    wanted: int

    @property
    def title(self):
        return f"net, until {self.wanted} in {self.goal}"

    def named_children(self):
        return self.transitions

    def edges(self):
        return [
            Edge(one, other, place)
            for one in self.transitions for place in self.outputs[one]
            for other in self.transitions if place in self.inputs[other]
        ]

    def run(self, scope):
        tokens, running = Counter(self.tokens), {}
        with scope.apart() as inner:
            try:
                while tokens[self.goal] < self.wanted:
                    for name in self.transitions:
                        if name not in running and all(tokens[p] > 0 for p in self.inputs[name]):
                            tokens.subtract(self.inputs[name])
                            inner.emit("fires", {"transition": name, "tokens": {p: n for p, n in tokens.items() if n}})
                            running[name] = inner.run(self.transitions[name], name)
                    if not running:
                        return Failure(f"nothing can fire: {dict(tokens)}")
                    for name, one in list(running.items()):
                        outcome = tick(one)
                        if isinstance(outcome, Failure):
                            return outcome
                        if outcome is not None:
                            del running[name]
                            tokens.update(self.outputs[name])
                    yield
            finally:
                for one in running.values():
                    one.close()
            yield from inner.recover()
        return Success("reached")


class NetDocument(DocumentKind):
    """A place/transition net."""

    kind = "net"

    def behaviour(self, document, reader):
        parts = {}
        for name, one in document["transitions"].items():
            for place in (*one["from"], *one["to"]):
                if place not in document["places"]:
                    raise DescriptionError(f"there is no place '{place}'", f"transitions.{name}")
            parts[name] = reader.behaviour(one["do"], f"transitions.{name}.do")
        inputs = {name: tuple(one["from"]) for name, one in document["transitions"].items()}
        outputs = {name: tuple(one["to"]) for name, one in document["transitions"].items()}
        return Net(MappingProxyType(parts), inputs, outputs, document["places"], document["goal"], document["wanted"])


class Moody(DocumentKind):
    """Cannot be read on a bad day."""

    kind = "moody"
    formats = {"json": "application/json", "signed": "application/x-signed"}
    bad_day = False

    def __init__(self):
        while self.bad_day == "hangs":
            pass
        if self.bad_day:
            raise KeyError("no kind today")

    def behaviour(self, document, reader):
        return reader.behaviour(document)

    def parse(self, text, format_):
        if format_ == "signed" and not text.startswith("moody "):
            raise DocumentError((DocumentFault("", "it is not signed", 1, 1),))
        return super().parse(text.removeprefix("moody "), format_)

    def export(self, document, format_):
        return ("moody " if format_ == "signed" else "") + super().export(document, format_)


@dataclass(frozen=True, slots=True)
class Odd(Behaviour):
    """Does not say what it is."""

    kind = "odd"
    how: str
    seconds: float = 1.0
    until: float | None = None

    @property
    def title(self):
        if self.how == "title":
            raise RuntimeError("no title today")
        return "odd"

    def uses(self):
        return None if self.how == "uses" else Uses()

    def named_children(self):
        return {"a/b": Odd("fine")} if self.how == "slash" else {"a": 3} if self.how == "child" else {}

    def edges(self):
        return (Edge("", "nowhere"),) if self.how == "edges" else ()

    def run(self, scope):
        yield
        scope.emit("ran")
        return Success()


@dataclass(frozen=True, slots=True)
class React(Behaviour):
    """In each cycle the first child whose quantity of the base is there; the others are cancelled."""

    kind = "react"
    child: Behaviour
    otherwise: Behaviour
    place: str

    @property
    def title(self):
        return f"react to being at {self.place}"

    def named_children(self):
        return {"there": self.child, "away": self.otherwise}

    def edges(self):
        return [Edge("", "there", "at"), Edge("", "away", "else"), Edge("away", "", "again")]

    def run(self, scope):
        chosen, run = None, None
        with scope.apart() as inner:
            try:
                while True:
                    at = scope.context.world.objects("robot_1", "sk:at")[0] == self.place
                    if chosen is not at:
                        if run is not None:
                            run.close()
                            yield from inner.recover()
                        chosen = at
                        run = inner.run(self.child, "there") if at else inner.run(self.otherwise, "away")
                    outcome = tick(run)
                    if outcome is not None:
                        return outcome
                    yield
            finally:
                if run is not None:
                    run.close()
'''
POINTS = """[skiros.primitives]
note = net_of_a_test:Note

[skiros.behaviours]
net = net_of_a_test:Net
react = net_of_a_test:React
odd = net_of_a_test:Odd

[skiros.documents]
net = net_of_a_test:NetDocument
moody = net_of_a_test:Moody
tree = skiros_py.behaviours.tree_document:Tree
"""


def note(text: str) -> dict[str, Any]:
    return {"type": "do", "module": "note", "arguments": {"text": text}}


def net(wanted: int = 2) -> dict[str, Any]:
    """Two tokens go round: what is made is packed, and the free hand makes again."""
    return {
        "places": {"free": 2, "made": 0, "packed": 0},
        "transitions": {
            "make": {"from": ["free"], "to": ["made"], "do": note("make")},
            "pack": {"from": ["made"], "to": ["free", "packed"], "do": note("pack")},
        },
        "goal": "packed",
        "wanted": wanted,
    }


PAUSE = {"type": "wait", "seconds": 0.1}


class Cell:
    """A session with the wheel, its documents, and its events; as much of a station as documents need."""

    def __init__(self, session: Session, store: DocumentStore) -> None:
        self.session = session
        self.document_store = store
        self.alarms = Alarms(EventLog(100), lambda: session)
        self.documents = DocumentService(self)  # type: ignore[arg-type]
        self.documents.open(session)
        self.events: list[ModuleEvent] = []
        session.monitor.subscribe(self.events.append, nodes=True)

    def write(self, kind: str, id_: str, data: Any, seen: int | None = None) -> DocumentInfo:
        return self.documents.put(kind, id_, data, Seen(seen))[0]

    def faults(self, kind: str, data: Any) -> tuple[DocumentFault, ...]:
        try:
            self.write(kind, "checked", data)
        except DocumentError as error:
            return error.faults
        return ()

    def run(self, module: str, agent: str = "base_1", cycles: int = 400) -> Outcome:
        running = self.session.managers[agent].start(module, {})
        for _ in range(cycles):
            self.session.cycle.step()
            if running.done:
                break
        return running.result

    def noted(self) -> list[Any]:
        return [event.value for event in self.events if event.event == "noted"]


@pytest.fixture
def wheel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The wheel, installed."""
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))
    site = tmp_path / "site"
    info = site / "net_of_a_test-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: net-of-a-test\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(POINTS.replace("tree = skiros_py.behaviours.tree_document:Tree\n", ""))
    (site / "net_of_a_test.py").write_text(WHEEL)
    monkeypatch.syspath_prepend(str(site))


@pytest.fixture
def cell(wheel: None, tmp_path: Path) -> Iterator[Cell]:
    scene = tiny_scene(tmp_path)
    store = DocumentStore(tmp_path / "documents.sqlite")
    with Session(str(scene), Options(fake=True)) as session:
        yield Cell(session, store)
    store.close()


def test_a_cyclic_net_with_two_tokens_runs_as_a_document(cell: Cell) -> None:
    document = cell.write("net", "line", net(wanted=4))

    outcome = cell.run("net:line")

    assert outcome == Success("reached")
    assert cell.noted().count("pack") >= 4
    starts = [e for e in cell.events if e.kind == "document" and e.status is Status.STARTED]
    assert [(e.module, e.path, e.implementation) for e in starts] == [
        ("net:line", "net:line", f"revision {document.revision}")
    ]
    fired = [e.value["transition"] for e in cell.events if e.event == "fires"]
    assert fired[:3] == ["make", "pack", "make"] or fired[:2] == ["make", "make"]
    paths = {e.path for e in cell.events if e.module == "note"}
    assert paths == {"net:line/body/make", "net:line/body/pack"}
    ids = [e.id for e in cell.events if e.module == "note" and e.status is Status.STARTED]
    assert len(ids) == len(set(ids))


def test_a_net_is_drawn_with_its_cycle_and_labels(cell: Cell) -> None:
    cell.write("net", "line", net())

    root, *_ = nodes_of(cell.session.managers.documents["net:line"].behaviour, "body")

    drawn = {(edge.source, edge.target, edge.label) for edge in root.edges}
    assert drawn == {("body/make", "body/pack", "made"), ("body/pack", "body/make", "free")}


def test_a_fault_is_refused_with_its_place_and_changes_nothing(cell: Cell) -> None:
    before = cell.write("net", "line", net())
    broken = net()
    broken["transitions"]["pack"]["from"] = ["mad"]

    with pytest.raises(UsageError, match=r"transitions\.pack: there is no place 'mad'"):
        cell.write("net", "line", broken)

    assert cell.documents.get("net", "line") == before
    faults = cell.faults("tree", {"type": "sequence", "children": [note("a"), {"type": "nix"}]})
    assert [fault.place for fault in faults] == ["children[1]"]


MOVER = {"key": "Mover", "type": "sk:Base", "help": "What drives."}
DRIVE = {"type": "do", "module": "drive"}


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"type": "do", "module": "fly"}, "there is no primitive or skill 'fly'"),
        ({"type": "do", "module": "note", "arguments": {"texts": "a"}}, "primitive 'note' has no parameter texts"),
        ({"type": "parallel", "children": [DRIVE, DRIVE]}, "parallel branches 1 and 2 both take"),
        (
            {"type": "wait_until", "conditions": [{"expression": 'Mover.still > "x"'}]},
            "'>' takes a number, and 'x' is a text",
        ),
        (
            {"type": "wait_until", "conditions": [{"expression": "Mover.stil"}]},
            "no sk:Base has a signal 'stil'",
        ),
        (
            {"type": "wait_until", "conditions": [{"expression": "belt_9.still"}]},
            "unknown signal 'belt_9.still'",
        ),
    ],
    ids=[
        "unknown module",
        "unknown parameter",
        "one device twice",
        "impossible expression",
        "unknown signal",
        "unknown device",
    ],
)
def test_a_document_that_calls_a_missing_module_is_refused_with_the_place_of_the_call(
    cell: Cell, wrong: Any, said: str
) -> None:
    tree = {"parameters": [MOVER], "body": {"type": "sequence", "children": [note("a"), wrong]}}

    faults = cell.faults("tree", tree)

    assert [fault.place for fault in faults] == ["1"]
    assert said in faults[0].text
    with pytest.raises(UsageError, match="tree:wrong: "):
        cell.write("tree", "wrong", tree)
    assert cell.documents.all("tree").items == ()


@pytest.mark.parametrize("between", ["sequence", "fallback"])
def test_documents_that_call_each_other_in_a_circle_are_refused_whatever_lies_between(cell: Cell, between: str) -> None:
    cell.write("tree", "there", {"type": "do", "module": "tree:back"})
    back = {"type": between, "children": [note("x"), {"type": "do", "module": "tree:there"}]}

    with pytest.raises(UsageError, match="1: tree:there leads to calls in a circle, which never end"):
        cell.write("tree", "back", back)
    assert [document.id for document in cell.documents.all("tree").items] == ["there"]


def test_a_reactive_node_in_a_tree_is_edited_while_the_session_runs(cell: Cell) -> None:
    tree = {"type": "react", "place": "box_a", "child": note("there"), "otherwise": note("away")}
    first = cell.write("tree", "watch", tree)
    cell.run("tree:watch")
    second = cell.write("tree", "watch", {**tree, "otherwise": note("far")}, seen=first.revision)
    cell.run("tree:watch")

    assert cell.noted() == ["away", "far"]
    revisions = [e.implementation for e in cell.events if e.kind == "document" and e.status is Status.STARTED]
    assert revisions == [f"revision {first.revision}", f"revision {second.revision}"]
    assert [one.data["otherwise"] for one in cell.documents.revisions("tree", "watch").items] == [
        note("away"),
        note("far"),
    ]
    with pytest.raises(StaleVersion):
        cell.write("tree", "watch", tree, seen=first.revision)


def test_a_reactive_node_cancels_one_child_for_the_other(cell: Cell) -> None:
    long = {"type": "sequence", "children": [note("away"), {"type": "wait", "seconds": 60}]}
    tree = {"type": "react", "place": "box_a", "child": note("there"), "otherwise": long}
    cell.write("tree", "watch", tree)
    running = cell.session.managers["base_1"].start("tree:watch", {})
    for _ in range(20):
        cell.session.cycle.step()
    with cell.session.world.transaction("test", "it arrives") as tx:
        tx.place("robot_1", "sk:at", "box_a")
    for _ in range(20):
        cell.session.cycle.step()

    assert running.result == Success("there")
    assert cell.noted() == ["away", "there"]
    cancelled = [e.path for e in cell.events if e.status is Status.PREEMPTED]
    assert "tree:watch/body/away" in cancelled


def test_a_document_calls_another_one_but_not_a_removed_one(cell: Cell) -> None:
    cell.write("tree", "inner", note("deep"))
    cell.write("tree", "outer", {"type": "do", "module": "tree:inner"})
    cell.run("tree:outer")
    cell.documents.remove("tree", "inner")

    assert cell.noted() == ["deep"]
    assert {e.path for e in cell.events if e.module == "note"} == {"tree:outer/body/body"}
    assert isinstance(cell.run("tree:outer"), Failure)
    with pytest.raises(UnknownName):
        cell.session.managers["base_1"].start("tree:inner", {})


def test_a_run_keeps_its_revision_while_its_document_is_edited_and_the_recording_names_both(
    cell: Cell, tmp_path: Path
) -> None:
    slow = {"type": "react", "place": "box_b", "child": note("there"), "otherwise": PAUSE}
    line = net(wanted=2)
    line["transitions"]["make"]["do"] = slow
    recording = tmp_path / "run.mcap"
    with Recorder(RecordingWriter(recording), cell.session.runtime, {}):
        first = cell.write("net", "line", line)
        running = cell.session.managers["base_1"].start("net:line", {})
        for _ in range(5):
            cell.session.cycle.step()
        quick = {**line, "goal": "made", "wanted": 1}
        second = cell.write("net", "line", quick, seen=first.revision)
        while not running.done:
            cell.session.cycle.step()
        packed = cell.noted().count("pack")
        again = cell.run("net:line")

    assert (running.result, again) == (Success("reached"), Success("reached"))
    assert packed >= 2
    assert cell.noted().count("pack") == packed
    started = [e.implementation for e in cell.events if e.kind == "document" and e.status is Status.STARTED]
    assert started == [f"revision {first.revision}", f"revision {second.revision}"]
    with Recording(recording) as recorded:
        kept = [message for _, _, message in recorded.messages("/documents/net:line")]
    assert [one["revision"] for one in kept] == [first.revision, second.revision]
    assert [one["behaviour"]["wanted"] for one in kept] == [2, 1]


@pytest.mark.parametrize(("location", "said"), [("nowhere", "unknown element 'nowhere'"), ("base_1", "base_1 is a ")])
def test_constants_of_a_tree_that_name_no_fitting_element_are_problems_at_the_node(
    cell: Cell, location: str, said: str
) -> None:
    drive = {"type": "do", "module": "drive", "arguments": {"Location": location}}

    written = cell.write("tree", "trip", {"type": "sequence", "children": [note("off"), drive]})

    assert [problem.place for problem in written.problems] == ["1"]
    assert said in written.problems[0].text


def test_a_new_document_may_call_one_that_is_written_later(cell: Cell) -> None:
    calls = {"type": "sequence", "children": [note("there"), {"type": "do", "module": "tree:back"}]}

    first = cell.write("tree", "there", calls)
    second = cell.write("tree", "back", note("back"))

    assert [(one.place, one.text) for one in first.problems] == [("1", "there is no document 'tree:back' that can run")]
    assert second.problems == cell.documents.get("tree", "there").problems == ()
    assert cell.run("tree:there") == Success("back")


def test_removing_a_document_is_reported_as_a_problem_of_its_callers(cell: Cell) -> None:
    cell.write("tree", "inner", note("deep"))
    cell.write("tree", "outer", {"type": "do", "module": "tree:inner"})
    cell.documents.remove("tree", "inner")

    assert [one.place for one in cell.documents.get("tree", "outer").problems] == [""]
    assert [fault.place for fault in cell.faults("tree", {"type": "do", "module": "grove:inner"})] == [""]


def test_the_next_session_offers_stored_documents(cell: Cell) -> None:
    cell.write("tree", "hello", note("hello"))
    cell.session.managers.documents.clear()

    DocumentService(cell).open(cell.session)  # type: ignore[arg-type]

    assert cell.run("tree:hello") == Success("hello")


def test_a_document_is_exported_and_imported_as_text(cell: Cell) -> None:
    first = cell.write("tree", "hello", note("hello"))

    text, media_type, revision = cell.documents.export("tree", "hello")
    again, new = cell.documents.import_text("tree", "copy", text, media_type)

    assert (again.data, new, revision) == (note("hello"), True, first.revision)
    with pytest.raises(DocumentError) as wrong:
        cell.documents.import_text("tree", "copy", '{"type": "do",\n "module" "note"}', media_type)
    assert [(fault.line, fault.place) for fault in wrong.value.faults] == [(2, "")]
    assert cell.documents.get("tree", "copy").revision == again.revision


def test_faults_of_a_plug_in_document_are_found_in_the_lines_of_its_text(cell: Cell) -> None:
    data = net()
    first = next(iter(data["transitions"].values()))
    for wrong in ({"type": "do", "module": "fly"}, {"type": "wiat"}):
        first["do"] = wrong
        text = json.dumps(data, indent=1)
        line = 1 + text[: text.index(wrong.get("module", wrong["type"]))].count("\n")

        with pytest.raises(DocumentError) as refused:
            cell.documents.import_text("net", "copy", text, "application/json")

        (fault,) = refused.value.faults
        assert line - 2 <= fault.line <= line, f"line {line}: {fault}"


def test_the_palette_lists_plug_in_nodes_with_their_fields(cell: Cell) -> None:
    kinds = {kind.kind: kind for kind in cell.documents.kinds().items}
    entries = {entry.kind: entry for entry in kinds["tree"].palette}

    assert set(entries["react"].fields) == {"child", "otherwise", "place"}
    assert entries["wait"].help == "Lets so many seconds of run time pass."
    assert kinds["net"].help == "A place/transition net."


@pytest.mark.parametrize(
    ("how", "reason"),
    [
        ("title", r"its title raises RuntimeError: no title today"),
        ("uses", r"its uses\(\) must be Uses\(…\), not None"),
        ("slash", r"the key of a child has no '/', not 'a/b'"),
        ("child", r"not 3"),
        ("edges", r"its edges\(\) join itself \(''\) and its children, not 'nowhere'"),
    ],
)
def test_a_node_without_a_type_is_refused_with_its_place_and_not_stored(cell: Cell, how: str, reason: str) -> None:
    tree = {"type": "sequence", "children": [note("a"), {"type": "odd", "how": how}]}

    with pytest.raises(UsageError, match=rf"tree:bad: 1 \(odd\): .*{reason}"):
        cell.write("tree", "bad", tree)

    with pytest.raises(NotFound):
        cell.documents.get("tree", "bad")


@pytest.mark.parametrize(("how", "reason"), [("raises", "no kind today"), ("hangs", "did not end within 0.2 s")])
def test_a_stored_document_that_is_no_longer_readable_is_set_aside_and_can_be_removed(
    cell: Cell, monkeypatch: pytest.MonkeyPatch, how: str, reason: str
) -> None:
    monkeypatch.setattr("skiros_py.station.documents._PATIENCE", 0.2)
    cell.write("moody", "sad", note("sad"))
    cell.write("tree", "hello", note("hello"))
    cell.session.managers.documents.clear()
    monkeypatch.setattr(cell.session.catalogue.documents["moody"], "bad_day", how)

    again = DocumentService(cell)  # type: ignore[arg-type]
    again.open(cell.session)

    assert set(cell.session.managers.documents) == {"tree:hello"}
    (alarm,) = cell.alarms.active
    assert (alarm.source, reason in alarm.text) == ("moody:sad", True)
    sad = again.get("moody", "sad")
    assert (sad.data, reason in sad.problems[0].text) == (note("sad"), True)
    with pytest.raises(UsageError, match=reason):
        again.put("moody", "sadder", note("sad"))
    again.remove("moody", "sad")
    assert (again.all("moody").items, cell.alarms.active) == ((), ())


@pytest.mark.parametrize(
    ("fields", "fault"),
    [
        ({"seconds": "soon"}, ("children[0].seconds", "it must be float, not 'soon'")),
        ({"seconds": True}, ("children[0].seconds", "it must be float, not True")),
        ({"until": [1]}, ("children[0].until", "it must be float | None, not [1]")),
        ({"how": 3}, ("children[0].how", "it must be str, not 3")),
    ],
)
def test_a_field_with_the_wrong_type_is_refused_with_its_place(
    cell: Cell, fields: dict[str, Any], fault: tuple[str, str]
) -> None:
    tree = {"type": "sequence", "children": [{"type": "odd", "how": "fine", **fields}]}

    faults = cell.faults("tree", tree)

    assert [(one.place, one.text) for one in faults] == [fault]
    assert cell.faults("tree", {"type": "odd", "how": "fine", "seconds": 2, "until": None}) == ()


def test_events_of_nodes_and_called_documents_carry_the_enclosing_run(cell: Cell) -> None:
    cell.write("tree", "inner", {"type": "sequence", "children": [{"type": "odd", "how": "fine"}]})
    cell.write("tree", "outer", {"type": "sequence", "children": [{"type": "do", "module": "tree:inner"}]})

    assert isinstance(cell.run("tree:outer"), Success)

    starts = {e.id: e for e in cell.events if e.status is Status.STARTED}
    (ran,) = (e for e in cell.events if e.event == "ran")
    around = [starts[ran.id]]
    while around[-1].parent:
        around.append(starts[around[-1].parent])
    assert ran.parent == around[0].parent
    assert [(e.kind, e.path) for e in around] == [
        ("node", "tree:outer/body/0/body/0"),
        ("node", "tree:outer/body/0/body"),
        ("document", "tree:outer/body/0"),
        ("node", "tree:outer/body/0"),
        ("node", "tree:outer/body"),
        ("document", "tree:outer"),
    ]


EXAMPLES: dict[str, dict[str, Any]] = {
    "tree": PAUSE,
    "sequence": {"title": "round", "steps": [{"skill": "drive", "arguments": {"Location": "box_a"}}]},
    "template": {"goal": [{"condition": "LocationEmpty", "arguments": ["kit_1_a"]}]},
    "net": net(),
    "moody": PAUSE,
}


@pytest.mark.usefixtures("wheel")
def test_documents_of_all_kinds_are_exported_and_imported_over_http_in_each_of_their_formats(tmp_path: Path) -> None:
    with (
        serving(str(tiny_scene(tmp_path)), tmp_path / "data") as served,
        httpx2.Client(base_url=f"{served.url}/api/v1") as api,
    ):
        kinds = {one["kind"]: one["formats"] for one in api.get("/documents").json()["items"]}
        assert kinds.keys() == EXAMPLES.keys()
        assert set(kinds["moody"]) == {"json", "signed"}
        for kind, formats in kinds.items():
            first = api.put(f"/documents/{kind}/first", json={"data": EXAMPLES[kind]})
            assert first.status_code == 201, first.text
            for format_, media_type in formats.items():
                text = api.get(f"/documents/{kind}/first/text", params={"format": format_})
                headers = {"Content-Type": media_type}
                copy = api.put(f"/documents/{kind}/copy {format_}/text", content=text.content, headers=headers)
                wrong = api.put(f"/documents/{kind}/wrong/text", content=text.content[:-3], headers=headers)

                assert (text.headers["Content-Type"], text.headers["ETag"]) == (media_type, first.headers["ETag"])
                assert copy.status_code == 201, copy.text
                assert copy.json()["data"] == first.json()["data"] == EXAMPLES[kind]
                assert (wrong.status_code, wrong.json()["faults"][0]["line"] > 0) == (422, True), wrong.text
            assert api.get(f"/documents/{kind}/wrong").status_code == 404
        unsigned = api.put("/documents/moody/x/text", content="{}", headers={"Content-Type": "application/x-signed"})
        foreign = api.put("/documents/tree/x/text", content="{}", headers={"Content-Type": "application/x-signed"})
    assert "it is not signed" in unsigned.text
    assert foreign.status_code == 415
