"""The server's operations, one class per topic of the API; the same for both clients."""

from __future__ import annotations

from typing import Generic

from skiros_py.client.operation import C
from skiros_py.client.topics.cell import Alarms, Devices, Modules, Plugins, Robots, Signals, Simulation, Station
from skiros_py.client.topics.server import Audit, Data, Events, Keys, Session, Webhooks
from skiros_py.client.topics.work import Documents, Goals, Jobs, Previews, Tasks
from skiros_py.client.topics.world import Elements, Learned, Locks, Ontology, Queries, Scenes, World

__all__ = ["Topics"]


class Topics(Generic[C]):
    """The server's operations, by topic.

    Attributes:
        alarms: Conditions that stopped a robot or need the user.
        audit: The audit log: changes and refused requests.
        data: The data directory of the server.
        events: Past events, in pages; the client's :meth:`follow` streams new ones.
        keys: API keys.
        session: The caller's own session.
        station: All robots together.
        webhooks: Job notifications to other systems.
        world: The world as a whole.
        elements: The elements of the world and their relations.
        ontology: The classes, relations and properties of the world.
        queries: SPARQL queries.
        learned: Data taught to robots.
        locks: Edit locks on elements.
        jobs: Jobs: ordering, following, commanding.
        goals: Goals: checking, and those stored with the scene.
        documents: Documents of all kinds: trees, sequences, goal templates.
        previews: Goals that are planned but not executed.
        scenes: Scenes: those that can be loaded, and the current one.
        simulation: The simulation: the ground truth, as opposed to the world model.
        modules: Skills and primitives, run individually, and their managers.
        plugins: Installed plug-ins and their faults.
        robots: Robots: models and state.
        devices: Devices of any kind: readings, planned motions, observations, opening, closing, jogging, teaching.
        signals: Signals of the cell.
        tasks: Goals that are being pursued now.
    """

    def __init__(self, client: C) -> None:
        self.alarms = Alarms(client)
        self.audit = Audit(client)
        self.data = Data(client)
        self.events = Events(client)
        self.keys = Keys(client)
        self.session = Session(client)
        self.station = Station(client)
        self.webhooks = Webhooks(client)
        self.world = World(client)
        self.elements = Elements(client)
        self.ontology = Ontology(client)
        self.queries = Queries(client)
        self.learned = Learned(client)
        self.locks = Locks(client)
        self.jobs = Jobs(client)
        self.goals = Goals(client)
        self.documents = Documents(client)
        self.previews = Previews(client)
        self.scenes = Scenes(client)
        self.simulation = Simulation(client)
        self.modules = Modules(client)
        self.plugins = Plugins(client)
        self.robots = Robots(client)
        self.devices = Devices(client)
        self.signals = Signals(client)
        self.tasks = Tasks(client)
