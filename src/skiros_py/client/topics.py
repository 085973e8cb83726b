"""The server's operations, one class per topic of the API; the same for both clients."""

from __future__ import annotations

import asyncio
import inspect
import time
from collections.abc import Awaitable, Callable, Iterator
from typing import Any, Generic, TypeVar, overload

from skiros_py.api.jobs import Job
from skiros_py.client.calls import (
    access,
    alarms,
    documents,
    elements,
    events,
    goals,
    jobs,
    modules,
    ontology,
    robots,
    scenes,
    simulation,
    tasks,
    webhooks,
    world,
)
from skiros_py.client.request import AsyncSender, Method, Sender, TookTooLong, Topic, Unreachable

_FIRST, _LONGEST = 0.05, 1.0
"""First and longest polling interval [s]."""
_OUTAGE = 60.0
"""How long the server may be unreachable, for example during a restart [s]."""


def is_over(job: Job) -> bool:
    """Returns whether a job is over, regardless of its outcome."""
    return job.outcome is not None


def wait_for(client: Sender, job: str, until: Callable[[Job], bool], timeout: float | None) -> Job:
    """Waits until a condition holds for a job; see ``Jobs.wait``."""
    looks = _Looks(job, timeout)
    for pause in looks:
        try:
            if until(found := looks.seen(client.send(jobs.get_job(job)))):
                return found
        except Unreachable as error:
            looks.missed(error)
        time.sleep(pause)
    raise looks.given_up()


async def wait_for_async(client: AsyncSender, job: str, until: Callable[[Job], bool], timeout: float | None) -> Job:
    """Waits like :func:`wait_for`, without blocking the event loop."""
    looks = _Looks(job, timeout)
    for pause in looks:
        try:
            if until(found := looks.seen(await client.send(jobs.get_job(job)))):
                return found
        except Unreachable as error:
            looks.missed(error)
        await asyncio.sleep(pause)
    raise looks.given_up()


class _Looks:
    """When to poll again, and when to give up."""

    def __init__(self, job: str, timeout: float | None) -> None:
        self._job = job
        self._timeout = timeout
        self._end = time.monotonic() + (float("inf") if timeout is None else timeout)
        self._heard = time.monotonic()
        self._last = "nothing is known of it"

    def __iter__(self) -> Iterator[float]:
        """Yields for each poll how long to wait after it [s]; there is one more poll at the very end."""
        pause = _FIRST
        while (left := self._end - time.monotonic()) > 0.0:
            yield min(pause, left)
            pause = min(1.5 * pause, _LONGEST)
        yield 0.0

    def seen(self, job: Job) -> Job:
        """Records the job as seen."""
        self._heard = time.monotonic()
        self._last = f"it is {job.state.text}{f': {job.detail}' if job.detail else ''}"
        return job

    def missed(self, error: Unreachable) -> None:
        """Records that there was no answer.

        Raises:
            Unreachable: There has been no answer for too long.
        """
        if time.monotonic() - self._heard > _OUTAGE:
            raise error

    def given_up(self) -> TookTooLong:
        """Returns the error with the job's last seen state."""
        return TookTooLong(f"job '{self._job}' did not come so far within {self._timeout:g} s: {self._last}")


C = TypeVar("C", bound=Sender | AsyncSender)


class Alarms(Topic[C]):
    """Conditions that stopped a robot or need the user."""

    list = Method(alarms.list_alarms)
    get = Method(alarms.get_alarm)
    acknowledge = Method(alarms.acknowledge_alarm)
    answer = Method(alarms.answer_alarm)


class Audit(Topic[C]):
    """The audit log: changes and refused requests."""

    list = Method(access.list_audit)


class Events(Topic[C]):
    """Past events, in pages; the client's :meth:`follow` streams new ones."""

    list = Method(events.list_events)
    state = Method(events.get_state)


class Keys(Topic[C]):
    """API keys."""

    list = Method(access.list_keys)
    create = Method(access.create_key)
    get = Method(access.get_key)
    revoke = Method(access.revoke_key)


class Session(Topic[C]):
    """The caller's own session."""

    get = Method(access.get_session)
    login = Method(access.login)
    logout = Method(access.logout)


class Station(Topic[C]):
    """All robots together."""

    stop = Method(robots.stop)
    get_stop = Method(robots.get_stop)
    reset = Method(robots.reset)


class Webhooks(Topic[C]):
    """Job notifications to other systems."""

    list = Method(webhooks.list_webhooks)
    create = Method(webhooks.create_webhook)
    get = Method(webhooks.get_webhook)
    change = Method(webhooks.change_webhook)
    delete = Method(webhooks.delete_webhook)
    ping = Method(webhooks.ping_webhook)
    deliveries = Method(webhooks.list_deliveries)
    dead_letters = Method(webhooks.list_dead_letters)
    redeliver = Method(webhooks.redeliver)


class World(Topic[C]):
    """The world as a whole."""

    get = Method(world.read_world)
    view = Method(world.read_view)
    tree = Method(world.read_tree)
    changes = Method(world.list_changes)
    change = Method(world.read_change)
    write = Method(world.write_transaction)
    undo = Method(world.undo_edit)


class Elements(Topic[C]):
    """The elements of the world and their relations."""

    list = Method(elements.list_elements)
    get = Method(elements.read_element)
    relations = Method(elements.list_relations)
    history = Method(elements.read_element_history)
    add = Method(elements.add_element)
    edit = Method(elements.change_element)
    remove = Method(elements.remove_element)
    relate = Method(elements.state_relation)
    unrelate = Method(elements.take_back_relation)


class Ontology(Topic[C]):
    """The classes, relations and properties of the world."""

    classes = Method(ontology.read_classes)
    get = Method(ontology.read_class)
    relations = Method(ontology.list_ontology_relations)
    properties = Method(ontology.list_ontology_properties)
    placements = Method(ontology.read_placements)


class Queries(Topic[C]):
    """SPARQL queries."""

    ask = Method(world.ask_question)


class Learned(Topic[C]):
    """Data taught to robots."""

    list = Method(world.list_learned)
    forget = Method(world.forget_learned)
    export = Method(world.export_learned)


class Locks(Topic[C]):
    """Edit locks on elements."""

    list = Method(world.list_locks)
    lock = Method(world.lock_elements)
    end = Method(world.end_locks)


class Jobs(Topic[C]):
    """Jobs: ordering, following, commanding."""

    order = Method(jobs.order_job)
    put = Method(jobs.put_job)
    list = Method(jobs.list_jobs)
    get = Method(jobs.get_job)
    response = Method(jobs.get_job_response)
    responses = Method(jobs.list_job_responses)
    capabilities = Method(jobs.get_capabilities)
    plan = Method(jobs.get_job_plan)
    trace = Method(jobs.get_job_trace)
    report = Method(jobs.get_job_report)
    replay = Method(jobs.get_job_replay)
    recording = Method(jobs.get_job_recording)
    transitions = Method(jobs.get_job_transitions)
    explanation = Method(jobs.get_job_explanation)
    start = Method(jobs.start_job)
    revoke_start = Method(jobs.revoke_start_of_job)
    pause = Method(jobs.pause_job)
    resume = Method(jobs.resume_job)
    stop = Method(jobs.stop_job)
    abort = Method(jobs.abort_job)
    cancel = Method(jobs.cancel_job)
    clear = Method(jobs.clear_job)
    remove = Method(jobs.remove_job)
    answer = Method(jobs.answer_job)

    @overload
    def wait(
        self: Jobs[Sender], job: str, *, until: Callable[[Job], bool] = is_over, timeout: float | None = None
    ) -> Job: ...
    @overload
    def wait(
        self: Jobs[AsyncSender], job: str, *, until: Callable[[Job], bool] = is_over, timeout: float | None = None
    ) -> Awaitable[Job]: ...
    def wait(
        self: Jobs[Any], job: str, *, until: Callable[[Job], bool] = is_over, timeout: float | None = None
    ) -> Job | Awaitable[Job]:
        """Waits until a condition holds for a job, also across server restarts, and returns the job.

        A job may wait for the user for long: ``until=lambda job: job.outcome or job.choices`` returns it then.

        Args:
            job: Its id.
            until: The condition; by default, that the job is over.
            timeout: How long to wait [s]; None for no limit.

        Raises:
            TookTooLong: It did not become true in time.
            ProblemError: There is no such job.
            Unreachable: The server has not answered for a minute.
        """
        waiting = wait_for_async if inspect.iscoroutinefunction(self.client.send) else wait_for
        return waiting(self.client, job, until, timeout)


class Goals(Topic[C]):
    """Goals: checking, and those stored with the scene."""

    check = Method(goals.check_goal)
    get = Method(goals.get_goals)
    put = Method(goals.put_goals)
    conditions = Method(goals.list_goal_conditions)


class Documents(Topic[C]):
    """Documents of all kinds: trees, sequences, goal templates."""

    kinds = Method(documents.list_document_kinds)
    list = Method(documents.list_documents)
    get = Method(documents.get_document)
    revisions = Method(documents.list_document_revisions)
    put = Method(documents.put_document)
    remove = Method(documents.remove_document)
    export = Method(documents.export_document)
    import_text = Method(documents.import_document)


class Previews(Topic[C]):
    """Goals that are planned but not executed."""

    ask = Method(goals.ask_preview)
    list = Method(goals.list_previews)
    get = Method(goals.get_preview)
    apply = Method(goals.apply_repair)


class Scenes(Topic[C]):
    """Scenes: those that can be loaded, and the current one."""

    list = Method(scenes.list_scenes)
    get = Method(scenes.get_scene)
    file = Method(scenes.get_scene_file)
    turtle = Method(scenes.get_scene_turtle)
    difference = Method(scenes.get_scene_difference)
    load = Method(scenes.load_scene)
    upload = Method(scenes.upload_scene)
    save = Method(scenes.save_scene)
    delete = Method(scenes.delete_scene)


class Simulation(Topic[C]):
    """The simulation: the ground truth, as opposed to the world model."""

    get = Method(simulation.get_simulation)
    bodies = Method(simulation.list_bodies)
    move_body = Method(simulation.move_body)
    remove_body = Method(simulation.remove_body)
    reset = Method(simulation.reset_simulation)
    set_pace = Method(simulation.set_pace)
    picture = Method(simulation.get_picture)


class Modules(Topic[C]):
    """Skills and primitives, run individually, and their managers."""

    managers = Method(modules.list_managers)
    open_manager = Method(modules.open_manager)
    close_manager = Method(modules.close_manager)
    list = Method(modules.list_modules)
    get = Method(modules.get_module)
    panel = Method(modules.show_panel)
    run = Method(modules.run_module)
    reset = Method(modules.reset_module)
    runs = Method(modules.list_module_runs)
    get_run = Method(modules.get_module_run)
    set_breakpoints = Method(modules.set_breakpoints)
    command = Method(modules.command_module_run)
    skills = Method(modules.list_skills)
    skill = Method(modules.get_skill)


class Plugins(Topic[C]):
    """Installed plug-ins and their faults."""

    list = Method(modules.list_plugins)
    faults = Method(modules.list_plugin_faults)


class Robots(Topic[C]):
    """Robots: models and state."""

    list = Method(robots.list_robots)
    get = Method(robots.get_robot)
    state = Method(robots.get_robot_state)
    model = Method(robots.get_robot_model)
    mesh = Method(robots.get_robot_mesh)


class Devices(Topic[C]):
    """Devices of any kind: readings, planned motions, looks, opening and closing, jogging and teaching."""

    list = Method(robots.list_devices)
    get = Method(robots.get_device)
    state = Method(robots.get_device_state)
    motion = Method(robots.get_device_motion)
    look = Method(robots.get_device_look)
    open = Method(robots.open_device)
    close = Method(robots.close_device)
    jog = Method(robots.jog_device)
    teach = Method(robots.teach_device)


class Signals(Topic[C]):
    """Signals of the cell: reading and setting."""

    list = Method(robots.list_signals)
    read = Method(robots.read_signals)
    set = Method(robots.set_signal)


class Tasks(Topic[C]):
    """Goals that are being pursued now."""

    list = Method(tasks.list_tasks)
    begin = Method(tasks.begin_task)
    get = Method(tasks.get_task)
    trace = Method(tasks.get_task_trace)
    command = Method(tasks.command_task)


class Topics(Generic[C]):
    """The server's operations, by topic.

    Attributes:
        alarms: Conditions that stopped a robot or need the user.
        audit: The audit log: changes and refused requests.
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
        robots: Robots: models, state, motions, looks.
        devices: Devices of any kind: readings, opening and closing, jogging and teaching.
        signals: Signals of the cell.
        tasks: Goals that are being pursued now.
    """

    def __init__(self, client: C) -> None:
        self.alarms = Alarms(client)
        self.audit = Audit(client)
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
