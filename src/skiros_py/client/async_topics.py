"""The parts of an asynchronous client, one for each topic of the API."""

from __future__ import annotations

from skiros_py.client.call import SendsLater, awaiting
from skiros_py.client.calls import (
    alarms,
    audit,
    elements,
    events,
    goals,
    jobs,
    keys,
    learned,
    locks,
    modules,
    ontology,
    plugins,
    previews,
    queries,
    robot_models,
    robots,
    scenes,
    sequences,
    session,
    simulation,
    tasks,
    templates,
    view,
    webhooks,
    world,
)
from skiros_py.client.calls import (
    stop as stops,
)
from skiros_py.client.waiting import JobWaitingLater

__all__ = [
    "Alarms",
    "Audit",
    "Elements",
    "Events",
    "Goals",
    "Jobs",
    "Keys",
    "Learned",
    "Locks",
    "Modules",
    "Ontology",
    "Plugins",
    "Previews",
    "Queries",
    "Robots",
    "Scenes",
    "Sequences",
    "Session",
    "Simulation",
    "Station",
    "Tasks",
    "Templates",
    "Topics",
    "Webhooks",
    "World",
]


class _Part:
    def __init__(self, client: SendsLater) -> None:
        self.client = client


class Alarms(_Part):
    """What stopped a robot, or waits for a person."""

    list = awaiting(alarms.list_alarms)
    get = awaiting(alarms.get_alarm)
    acknowledge = awaiting(alarms.acknowledge_alarm)
    answer = awaiting(alarms.answer_alarm)


class Audit(_Part):
    """Who changed what, and who was refused."""

    list = awaiting(audit.list_audit)


class Events(_Part):
    """What happened, in pages; :meth:`follow` of the client follows what happens."""

    list = awaiting(events.list_events)
    state = awaiting(events.get_state)


class Keys(_Part):
    """Who may come in."""

    list = awaiting(keys.list_keys)
    create = awaiting(keys.create_key)
    get = awaiting(keys.get_key)
    revoke = awaiting(keys.revoke_key)


class Session(_Part):
    """The caller's own session."""

    get = awaiting(session.get_session)
    login = awaiting(session.login)
    logout = awaiting(session.logout)


class Station(_Part):
    """All robots at once."""

    stop = awaiting(stops.stop)
    get_stop = awaiting(stops.get_stop)
    reset = awaiting(stops.reset)


class Webhooks(_Part):
    """Which other systems are told of jobs."""

    list = awaiting(webhooks.list_webhooks)
    create = awaiting(webhooks.create_webhook)
    get = awaiting(webhooks.get_webhook)
    change = awaiting(webhooks.change_webhook)
    delete = awaiting(webhooks.delete_webhook)
    ping = awaiting(webhooks.ping_webhook)
    deliveries = awaiting(webhooks.list_deliveries)
    dead_letters = awaiting(webhooks.list_dead_letters)
    redeliver = awaiting(webhooks.redeliver)


class World(_Part):
    """The world as a whole."""

    get = awaiting(world.read_world)
    view = awaiting(view.read_view)
    tree = awaiting(world.read_tree)
    changes = awaiting(world.list_changes)
    change = awaiting(world.read_change)
    write = awaiting(world.write_transaction)
    undo = awaiting(world.undo_edit)


class Elements(_Part):
    """What there is, one by one, and how it is related."""

    list = awaiting(elements.list_elements)
    get = awaiting(elements.read_element)
    relations = awaiting(elements.list_relations)
    history = awaiting(elements.read_element_history)
    add = awaiting(elements.add_element)
    edit = awaiting(elements.change_element)
    remove = awaiting(elements.remove_element)
    relate = awaiting(elements.state_relation)
    unrelate = awaiting(elements.take_back_relation)


class Ontology(_Part):
    """What there can be."""

    classes = awaiting(ontology.read_classes)
    get = awaiting(ontology.read_class)
    relations = awaiting(ontology.list_ontology_relations)
    properties = awaiting(ontology.list_ontology_properties)
    placements = awaiting(ontology.read_placements)


class Queries(_Part):
    """Questions in SPARQL."""

    ask = awaiting(queries.ask_question)


class Learned(_Part):
    """What robots were taught."""

    list = awaiting(learned.list_learned)
    forget = awaiting(learned.forget_learned)
    export = awaiting(learned.export_learned)


class Locks(_Part):
    """Who keeps others from editing what."""

    list = awaiting(locks.list_locks)
    lock = awaiting(locks.lock_elements)
    end = awaiting(locks.end_locks)


class Jobs(JobWaitingLater, _Part):
    """Orders: given, followed, commanded."""

    order = awaiting(jobs.order_job)
    put = awaiting(jobs.put_job)
    list = awaiting(jobs.list_jobs)
    get = awaiting(jobs.get_job)
    response = awaiting(jobs.get_job_response)
    responses = awaiting(jobs.list_job_responses)
    capabilities = awaiting(jobs.get_capabilities)
    plan = awaiting(jobs.get_job_plan)
    trace = awaiting(jobs.get_job_trace)
    report = awaiting(jobs.get_job_report)
    replay = awaiting(jobs.get_job_replay)
    transitions = awaiting(jobs.get_job_transitions)
    explanation = awaiting(jobs.get_job_explanation)
    start = awaiting(jobs.start_job)
    revoke_start = awaiting(jobs.revoke_start_of_job)
    pause = awaiting(jobs.pause_job)
    resume = awaiting(jobs.resume_job)
    stop = awaiting(jobs.stop_job)
    abort = awaiting(jobs.abort_job)
    cancel = awaiting(jobs.cancel_job)
    clear = awaiting(jobs.clear_job)
    remove = awaiting(jobs.remove_job)
    answer = awaiting(jobs.answer_job)


class Goals(_Part):
    """Goals: checked, and those that go with the scene."""

    check = awaiting(goals.check_goal)
    get = awaiting(goals.get_goals)
    put = awaiting(goals.put_goals)
    conditions = awaiting(goals.list_goal_conditions)


class Templates(_Part):
    """Named goals with parameters."""

    list = awaiting(templates.list_goal_templates)
    get = awaiting(templates.get_goal_template)
    put = awaiting(templates.put_goal_template)
    remove = awaiting(templates.remove_goal_template)


class Previews(_Part):
    """Goals that are planned and not done."""

    ask = awaiting(previews.ask_preview)
    list = awaiting(previews.list_previews)
    get = awaiting(previews.get_preview)
    apply = awaiting(previews.apply_repair)


class Scenes(_Part):
    """Scenes: those that can be loaded, and the present one."""

    list = awaiting(scenes.list_scenes)
    get = awaiting(scenes.get_scene)
    file = awaiting(scenes.get_scene_file)
    turtle = awaiting(scenes.get_scene_turtle)
    difference = awaiting(scenes.get_scene_difference)
    load = awaiting(scenes.load_scene)
    upload = awaiting(scenes.upload_scene)
    save = awaiting(scenes.save_scene)
    delete = awaiting(scenes.delete_scene)


class Simulation(_Part):
    """The simulation: what really is, apart from what is believed."""

    get = awaiting(simulation.get_simulation)
    bodies = awaiting(simulation.list_bodies)
    move_body = awaiting(simulation.move_body)
    remove_body = awaiting(simulation.remove_body)
    reset = awaiting(simulation.reset_simulation)
    set_pace = awaiting(simulation.set_pace)
    picture = awaiting(simulation.get_picture)


class Modules(_Part):
    """Skills and primitives by themselves, and who runs them."""

    managers = awaiting(modules.list_managers)
    list = awaiting(modules.list_modules)
    get = awaiting(modules.get_module)
    panel = awaiting(modules.show_panel)
    run = awaiting(modules.run_module)
    reset = awaiting(modules.reset_module)
    runs = awaiting(modules.list_module_runs)
    get_run = awaiting(modules.get_module_run)
    command = awaiting(modules.command_module_run)
    skills = awaiting(modules.list_skills)
    skill = awaiting(modules.get_skill)


class Plugins(_Part):
    """Plug-ins that are installed, and their faults."""

    list = awaiting(plugins.list_plugins)
    faults = awaiting(plugins.list_plugin_faults)


class Robots(_Part):
    """Robots: looked at, moved by hand, taught."""

    list = awaiting(robots.list_robots)
    get = awaiting(robots.get_robot)
    state = awaiting(robots.get_robot_state)
    model = awaiting(robot_models.get_robot_model)
    mesh = awaiting(robot_models.get_robot_mesh)
    motion = awaiting(robots.get_robot_motion)
    look = awaiting(robots.get_look)
    jog = awaiting(robots.jog_robot)
    teach = awaiting(robots.teach_robot)
    home = awaiting(robots.home_robot)


class Sequences(_Part):
    """Sequences of steps that somebody puts together."""

    list = awaiting(sequences.list_sequences)
    create = awaiting(sequences.create_sequence)
    get = awaiting(sequences.get_sequence)
    delete = awaiting(sequences.delete_sequence)
    insert_step = awaiting(sequences.insert_step)
    change_step = awaiting(sequences.change_step)
    remove_step = awaiting(sequences.remove_step)
    move_step = awaiting(sequences.move_step)
    run = awaiting(sequences.run_sequence)


class Tasks(_Part):
    """Goals that are pursued at this moment."""

    list = awaiting(tasks.list_tasks)
    begin = awaiting(tasks.begin_task)
    get = awaiting(tasks.get_task)
    trace = awaiting(tasks.get_task_trace)
    command = awaiting(tasks.command_task)


class Topics:
    """What can be asked of a server, by topic.

    Attributes:
        alarms: What stopped a robot, or waits for a person.
        audit: Who changed what, and who was refused.
        events: What happened, in pages; :meth:`follow` of the client follows what happens.
        keys: Who may come in.
        session: The caller's own session.
        station: All robots at once.
        webhooks: Which other systems are told of jobs.
        world: The world as a whole.
        elements: What there is, one by one, and how it is related.
        ontology: What there can be.
        queries: Questions in SPARQL.
        learned: What robots were taught.
        locks: Who keeps others from editing what.
        jobs: Orders: given, followed, commanded.
        goals: Goals: checked, and those that go with the scene.
        templates: Named goals with parameters.
        previews: Goals that are planned and not done.
        scenes: Scenes: those that can be loaded, and the present one.
        simulation: The simulation: what really is, apart from what is believed.
        modules: Skills and primitives by themselves, and who runs them.
        plugins: Plug-ins that are installed, and their faults.
        robots: Robots: looked at, moved by hand, taught.
        sequences: Sequences of steps that somebody puts together.
        tasks: Goals that are pursued at this moment.
    """

    def __init__(self, client: SendsLater) -> None:
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
        self.templates = Templates(client)
        self.previews = Previews(client)
        self.scenes = Scenes(client)
        self.simulation = Simulation(client)
        self.modules = Modules(client)
        self.plugins = Plugins(client)
        self.robots = Robots(client)
        self.sequences = Sequences(client)
        self.tasks = Tasks(client)
