"""The station: all use cases of a running cell, shared by command line, library and server."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path
from typing import Literal, Self

from platformdirs import user_cache_path

from skiros_py.errors import FileError
from skiros_py.recording.reader import JOBS
from skiros_py.station.alarms.alarms import Alarms
from skiros_py.station.alarms.sources import AlarmSources
from skiros_py.station.control import ControlThread, OpenSession
from skiros_py.station.data_files import DataFiles
from skiros_py.station.document_store import Document, DocumentStore
from skiros_py.station.documents import DocumentService
from skiros_py.station.events.live import LiveState
from skiros_py.station.events.log import EventLog, Kind
from skiros_py.station.events.sources import EventSources
from skiros_py.station.jobs.goals import GoalService
from skiros_py.station.jobs.jobs import JobService, JobWaiter
from skiros_py.station.modules.modules import ModuleService, PluginService
from skiros_py.station.modules.runs import ModuleRuns
from skiros_py.station.recordings.runs import JobRecordings
from skiros_py.station.robots.asked import Motions, Observations
from skiros_py.station.robots.devices import DeviceService, SignalService
from skiros_py.station.robots.models import RobotModels
from skiros_py.station.robots.robots import RobotService
from skiros_py.station.scenes.scenes import SceneStore
from skiros_py.station.scenes.service import SceneService
from skiros_py.station.session import Session
from skiros_py.station.simulation.simulation import Simulation
from skiros_py.station.stops import HaltMark, Stops
from skiros_py.station.tasks.previews import PreviewService
from skiros_py.station.tasks.tasks import TaskService
from skiros_py.station.world.elements import ElementService
from skiros_py.station.world.ontology import OntologyService, Queries
from skiros_py.station.world.world import WorldService
from skiros_py.world.journal.data_directory import make_folder


class Station:
    """A running cell with its use cases, for several callers at once. Use it in a ``with``.

    A control thread steps its :class:`~skiros_py.station.session.Session`, and opens another one when a scene is loaded
    or after a fault. The method ``open`` of each part that belongs to a session attaches the part to it, and names what
    detaches it when the session is closed.

    Args:
        opening: Opens the session.
        data: The data directory.
        events: Number of events kept for replay.
        open_jobs: Maximum number of open jobs.

    Attributes:
        data: The data directory.
        files: Checks and copies it.
        control: Runs the session.
        alarms, devices, documents, elements, goals, jobs, modules, ontology, plugins, previews, recordings, robots,
            scenes, signals, simulation, stops, tasks, world: The use cases, by topic.
        events: The log of events.
        live: The current state of the robots.
        observations: The last observations of the cameras.
        motions: The planned motions of devices.
        document_store: The stored documents, while it runs.
        module_runs: Active and recent runs of modules.
        unreadable: The records of each file that were left out because they cannot be read, by name.
        scene_store: The files of scenes.
        robot_models: Visual models of the robots.
        query_worker: Answers SPARQL queries in processes that may be killed.
        waiter: Lets callers wait for jobs.
    """

    def __init__(self, opening: OpenSession, data: Path, *, events: int = 20_000, open_jobs: int = 50_000) -> None:
        self.data = data
        self.files = DataFiles(data)
        self.control = ControlThread(opening)
        self.events = EventLog(events)
        self.alarms = Alarms(self.events, lambda: self.session)
        self.unreadable: list[Mapping[str, FileError]] = []
        self.stops = Stops(self.control, self.events, HaltMark(data / "halted.json"))
        self.observations = Observations()
        self.motions = Motions()
        self.live = LiveState(self.observations, self.motions)
        self.module_runs = ModuleRuns(self.events.epoch)
        self.tasks = TaskService(self)
        self.document_store: DocumentStore
        self.waiter = JobWaiter(open_jobs)
        self.query_worker = Queries()
        self.robot_models = RobotModels(user_cache_path("skiros-py") / "models")
        self.scene_store = SceneStore(data / "scenes")
        self.simulation = Simulation(self.control, self.alarms)
        self.documents = DocumentService(self)
        self.devices = DeviceService(self)
        self.signals = SignalService(self)
        self.elements = ElementService(self)
        self.goals = GoalService(self)
        self.jobs = JobService(self)
        self.modules = ModuleService(self)
        self.ontology = OntologyService(self)
        self.plugins = PluginService(self)
        self.previews = PreviewService(self)
        self.robots = RobotService(self)
        self.scenes = SceneService(self)
        self.world = WorldService(self)
        self.recordings = JobRecordings(data / JOBS, lambda: self.session.jobs)
        for attach in (
            self.stops.open,  # first: a stop requested meanwhile takes effect before anything else
            self.query_worker.open,
            self.observations.open,
            self.motions.open,
            self.live.open,
            self.module_runs.open,
            self.tasks.open,  # before the events, which name the job of each task
            partial(EventSources, self.events, self.tasks, self.module_runs),
            partial(AlarmSources, self.alarms, self.control, self.unreadable),
            self.waiter.open,
            self.scenes.open,
            self.simulation.open,
            self.documents.open,
            self.previews.open,
            self.recordings.open,
        ):
            self.control.on_open(attach)

    @property
    def session(self) -> Session:
        """The session; while it is being reopened, this waits for it.

        Raises:
            Busy: There is none, and none is being opened.
        """
        return self.control.session

    def make_folder(self) -> None:
        """Creates the data directory if it is missing.

        Raises:
            FileError: It cannot be created.
        """
        make_folder(self.data)

    def _note(self, what: Literal["written", "removed"], document: Document) -> None:
        """Announces a change of a document, not its content."""
        data = {"kind": document.kind, "name": document.name, "version": document.version}
        self.events.append(Kind.DOCUMENT, what, document.name, data=data)

    def __enter__(self) -> Self:
        """Opens the session and runs it.

        Raises:
            SkirosError: It cannot be opened.
        """
        with ExitStack() as stack:
            stack.callback(self.recordings.close)
            self.make_folder()
            stack.callback(self.robot_models.close)
            stack.callback(self.control.close)
            self.stops.restore()
            self.control.start()  # locks the data directory, so that no other program has its files open
            self.jobs.start_intake()
            stack.callback(self.jobs.close)
            stack.callback(self.waiter.close)
            stack.callback(self.previews.close)
            self.document_store = stack.enter_context(closing(DocumentStore(self.data / "server.db", self._note)))
            self.unreadable.append(self.document_store.unreadable)
            self.control.call(self.documents.open)
            self._close = stack.pop_all().close
        return self

    def __exit__(self, *_: object) -> None:
        """Stops everything and closes all parts."""
        self._close()
