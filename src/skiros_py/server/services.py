"""Everything that routes reach: the running station, and what the server itself keeps."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from types import TracebackType
from typing import Annotated, Literal, Self

from fastapi import Depends, Request
from platformdirs import user_cache_path

from skiros_py.server.access.audit import AuditLog
from skiros_py.server.access.doorkeeper import Doorkeeper
from skiros_py.server.access.keys import KeyStore
from skiros_py.server.access.setup import set_up_access
from skiros_py.server.events.streams import Streams
from skiros_py.server.logs import job_events_logged
from skiros_py.server.metrics import Metrics
from skiros_py.server.settings import ServerSettings
from skiros_py.server.simulation import Simulation
from skiros_py.server.webhooks.office import WebhookOffice
from skiros_py.server.webhooks.setup import open_office
from skiros_py.server.webhooks.store import WebhookStore
from skiros_py.station.alarms.alarms import Alarms
from skiros_py.station.alarms.sources import AlarmSources
from skiros_py.station.control import ControlThread, OpenSession
from skiros_py.station.documents import TOLD, Document, DocumentStore
from skiros_py.station.events.event import Kind
from skiros_py.station.events.live import LiveState
from skiros_py.station.events.log import EventLog
from skiros_py.station.events.sources import EventSources
from skiros_py.station.halt_mark import HaltMark
from skiros_py.station.jobs.waiting import JobDesk
from skiros_py.station.modules.runs import ModuleRuns
from skiros_py.station.queries import Queries
from skiros_py.station.recordings.jobs import JobRecordings
from skiros_py.station.robots.looks import Looks
from skiros_py.station.robots.models import RobotModels
from skiros_py.station.robots.motions import Motions
from skiros_py.station.runnable import RunnableDocuments
from skiros_py.station.scenes.scenes import SceneShelf
from skiros_py.station.scenes.stage import SceneStage
from skiros_py.station.session import Session
from skiros_py.station.simulation.bodies import Bodies
from skiros_py.station.stops import Stops
from skiros_py.station.tasks.book import TaskBook
from skiros_py.station.tasks.previews import Previews

__all__ = ["Services", "ServicesDep"]


class Services:
    """What one server is made of. Start it, and close it, or use it in a ``with``.

    Whatever belongs to one session is set up anew with each of them, by listeners of the control thread.

    Args:
        opening: Opens the session.
        data: The data directory.
        settings: How the server is set up.

    Attributes:
        settings: How the server is set up.
        data: The data directory.
        keys: Who may come in; from :meth:`start` on.
        doorkeeper: Finds out who makes a request; from :meth:`start` on.
        audit: Who changed what, and who was refused; from :meth:`start` on.
        control: Runs the session.
        events: What happens.
        streams: Who listens to it.
        looks: What the cameras saw last.
        motions: What the robots are about to do.
        live: What the robots do at this moment.
        recordings: The recordings of jobs.
        alarms: What stopped a robot, or waits for a person.
        stops: Halts and resets everything.
        modules: What was started by itself, apart from tasks.
        tasks: What is or was under way, for jobs and beside them.
        documents: What the server keeps beside world and jobs, such as goal templates; from :meth:`start` on.
        runnable: Documents that robots run; from :meth:`start` on, those of the present session.
        desk: Where jobs are waited for.
        previews: Goals that are planned and not done.
        metrics: Figures for those who watch the server.
        queries: Answers questions in SPARQL.
        robot_models: What the robots look like.
        scenes: Scenes that can be loaded.
        stage: Where scenes are read beside the live world.
        bodies: Has bodies of a simulation follow what people write.
        simulation: What only a simulated world can be asked for.
        webhooks: Who else is told of jobs, and what became of that; from :meth:`start` on.
    """

    def __init__(self, opening: OpenSession, data: Path, settings: ServerSettings) -> None:
        self.settings = settings
        self.data = data
        self.keys: KeyStore
        self.doorkeeper: Doorkeeper
        self.audit: AuditLog
        self.control = ControlThread(opening)
        self.events = EventLog(settings.kept_events)
        job_events_logged(self.events)
        self.streams = Streams(self.events, settings.streams, lambda caller: self.doorkeeper.still(caller))
        self.alarms = Alarms(self.events)
        self.stops = Stops(self.control, self.events, HaltMark(data / "halted.json"))
        self.looks = Looks()
        self.motions = Motions()
        self.live = LiveState(self.looks, self.motions, lambda: self.streams.ending)
        self.modules = ModuleRuns(self.events.epoch)
        self.tasks = TaskBook()
        for part in (
            self.stops,  # the first: a stop that was asked for meanwhile holds before anything else
            self.looks,
            self.motions,
            self.live,
            self.modules,
            self.tasks,
            EventSources(self.events, self.tasks, self.modules),
            AlarmSources(self.alarms, self.control),
        ):
            self.control.on_open(part.open)
            self.control.on_close(part.close)
        self.recordings = JobRecordings(data / "recordings")
        self.control.on_open(self.recordings.open)
        self.control.on_close(self.recordings.close_session)
        self.documents: DocumentStore
        self.runnable: RunnableDocuments
        self.desk = JobDesk(settings.open_jobs)
        self.control.on_open(self.desk.open)
        self.control.on_open(self._offer_documents)
        self.previews = Previews()
        self.control.on_close(self.previews.forget)
        self.metrics = Metrics(self.control, self.events)
        self.webhooks: WebhookStore
        self._office: WebhookOffice | None = None
        self.control.on_open(lambda session: _ignore(session.jobs.subscribe(lambda _job: self.send_webhooks())))
        self.queries = Queries(self.control)
        self.robot_models = RobotModels(user_cache_path("skiros-py") / "models")
        self.scenes = SceneShelf(data / "scenes")
        self.stage = SceneStage()
        self.control.on_close(self.stage.forget)
        self.bodies = Bodies(self.control, self.alarms)
        self.simulation = Simulation(self.control, self.bodies)
        self._stack = ExitStack()

    @property
    def session(self) -> Session:
        """The session; while it is being opened anew, that is waited for.

        Raises:
            Busy: There is none, and there will be none soon.
        """
        return self.control.session

    def start(self) -> None:
        """Opens the session and runs it.

        Raises:
            SkirosError: It cannot be opened.
        """
        try:
            self.keys, self.doorkeeper, self.audit = set_up_access(self.settings, self.data, self._stack)
            self._stack.callback(self.recordings.close)
            self._stack.callback(self.robot_models.close)
            self._stack.callback(self.control.close)
            self.stops.restore()
            self.control.start()  # which takes the data directory, so that no other server has its files open
            self._stack.callback(self.desk.close)
            self._stack.callback(self.previews.close)
            self.documents = self._stack.enter_context(closing(DocumentStore(self.data / "server.db", self._document)))
            self.runnable = RunnableDocuments(self.documents, self.session)
            self.webhooks, self._office = open_office(self, self._stack)
        except BaseException:
            self.close()
            raise

    def send_webhooks(self) -> None:
        """Tells that there may be something to be sent; quick, and for any thread."""
        if self._office is not None:
            self._office.wake()

    def _offer_documents(self, session: Session) -> None:
        """Has the documents run in a session that was opened anew; the first one is opened before they are."""
        if hasattr(self, "documents"):
            self.runnable = RunnableDocuments(self.documents, session)

    def _document(self, what: Literal["written", "removed"], document: Document) -> None:
        """Tells those who listen what became of a document; what it says is read where it is kept.

        Other kinds are notes of the server to itself, such as under which name the present scene was saved.
        """
        if document.kind not in TOLD:
            return
        data = {"kind": document.kind, "name": document.name, "version": document.version}
        self.events.append(Kind.DOCUMENT, what, document.name, data=data)

    def on_close(self, callback: Callable[[], object]) -> None:
        """Has something done when the server ends."""
        self._stack.callback(callback)

    def close(self) -> None:
        """Stops everything and ends all that was started; may be called twice."""
        self._stack.close()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _ignore(_ending: object) -> None:
    """For subscriptions that end with what they are to."""


async def _services(request: Request) -> Services:  # not in the thread pool: a stop must not wait for a place there
    services: Services = request.app.state.services
    return services


ServicesDep = Annotated[Services, Depends(_services)]
"""For routes: everything there is."""
