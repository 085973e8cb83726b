"""The parts of a blocking client, one for each topic of the API."""

from __future__ import annotations

from skiros_py.client.call import Sends, blocking
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
from skiros_py.client.waiting import JobWaiting

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
    def __init__(self, client: Sends) -> None:
        self.client = client


class Alarms(_Part):
    """What stopped a robot, or waits for a person."""

    list = blocking(alarms.list_alarms)
    get = blocking(alarms.get_alarm)
    acknowledge = blocking(alarms.acknowledge_alarm)
    answer = blocking(alarms.answer_alarm)


class Audit(_Part):
    """Who changed what, and who was refused."""

    list = blocking(audit.list_audit)


class Events(_Part):
    """What happened, in pages; :meth:`follow` of the client follows what happens."""

    list = blocking(events.list_events)
    state = blocking(events.get_state)


class Keys(_Part):
    """Who may come in."""

    list = blocking(keys.list_keys)
    create = blocking(keys.create_key)
    get = blocking(keys.get_key)
    revoke = blocking(keys.revoke_key)


class Session(_Part):
    """The caller's own session."""

    get = blocking(session.get_session)
    login = blocking(session.login)
    logout = blocking(session.logout)


class Station(_Part):
    """All robots at once."""

    stop = blocking(stops.stop)
    get_stop = blocking(stops.get_stop)
    reset = blocking(stops.reset)


class Webhooks(_Part):
    """Which other systems are told of jobs."""

    list = blocking(webhooks.list_webhooks)
    create = blocking(webhooks.create_webhook)
    get = blocking(webhooks.get_webhook)
    change = blocking(webhooks.change_webhook)
    delete = blocking(webhooks.delete_webhook)
    ping = blocking(webhooks.ping_webhook)
    deliveries = blocking(webhooks.list_deliveries)
    dead_letters = blocking(webhooks.list_dead_letters)
    redeliver = blocking(webhooks.redeliver)


class World(_Part):
    """The world as a whole."""

    get = blocking(world.read_world)
    view = blocking(view.read_view)
    tree = blocking(world.read_tree)
    changes = blocking(world.list_changes)
    change = blocking(world.read_change)
    write = blocking(world.write_transaction)
    undo = blocking(world.undo_edit)


class Elements(_Part):
    """What there is, one by one, and how it is related."""

    list = blocking(elements.list_elements)
    get = blocking(elements.read_element)
    relations = blocking(elements.list_relations)
    history = blocking(elements.read_element_history)
    add = blocking(elements.add_element)
    edit = blocking(elements.change_element)
    remove = blocking(elements.remove_element)
    relate = blocking(elements.state_relation)
    unrelate = blocking(elements.take_back_relation)


class Ontology(_Part):
    """What there can be."""

    classes = blocking(ontology.read_classes)
    get = blocking(ontology.read_class)
    relations = blocking(ontology.list_ontology_relations)
    properties = blocking(ontology.list_ontology_properties)
    placements = blocking(ontology.read_placements)


class Queries(_Part):
    """Questions in SPARQL."""

    ask = blocking(queries.ask_question)


class Learned(_Part):
    """What robots were taught."""

    list = blocking(learned.list_learned)
    forget = blocking(learned.forget_learned)
    export = blocking(learned.export_learned)


class Locks(_Part):
    """Who keeps others from editing what."""

    list = blocking(locks.list_locks)
    lock = blocking(locks.lock_elements)
    end = blocking(locks.end_locks)


class Jobs(JobWaiting, _Part):
    """Orders: given, followed, commanded."""

    order = blocking(jobs.order_job)
    put = blocking(jobs.put_job)
    list = blocking(jobs.list_jobs)
    get = blocking(jobs.get_job)
    response = blocking(jobs.get_job_response)
    responses = blocking(jobs.list_job_responses)
    capabilities = blocking(jobs.get_capabilities)
    plan = blocking(jobs.get_job_plan)
    trace = blocking(jobs.get_job_trace)
    report = blocking(jobs.get_job_report)
    replay = blocking(jobs.get_job_replay)
    transitions = blocking(jobs.get_job_transitions)
    explanation = blocking(jobs.get_job_explanation)
    start = blocking(jobs.start_job)
    revoke_start = blocking(jobs.revoke_start_of_job)
    pause = blocking(jobs.pause_job)
    resume = blocking(jobs.resume_job)
    stop = blocking(jobs.stop_job)
    abort = blocking(jobs.abort_job)
    cancel = blocking(jobs.cancel_job)
    clear = blocking(jobs.clear_job)
    remove = blocking(jobs.remove_job)
    answer = blocking(jobs.answer_job)


class Goals(_Part):
    """Goals: checked, and those that go with the scene."""

    check = blocking(goals.check_goal)
    get = blocking(goals.get_goals)
    put = blocking(goals.put_goals)
    conditions = blocking(goals.list_goal_conditions)


class Templates(_Part):
    """Named goals with parameters."""

    list = blocking(templates.list_goal_templates)
    get = blocking(templates.get_goal_template)
    put = blocking(templates.put_goal_template)
    remove = blocking(templates.remove_goal_template)


class Previews(_Part):
    """Goals that are planned and not done."""

    ask = blocking(previews.ask_preview)
    list = blocking(previews.list_previews)
    get = blocking(previews.get_preview)
    apply = blocking(previews.apply_repair)


class Scenes(_Part):
    """Scenes: those that can be loaded, and the present one."""

    list = blocking(scenes.list_scenes)
    get = blocking(scenes.get_scene)
    file = blocking(scenes.get_scene_file)
    turtle = blocking(scenes.get_scene_turtle)
    difference = blocking(scenes.get_scene_difference)
    load = blocking(scenes.load_scene)
    upload = blocking(scenes.upload_scene)
    save = blocking(scenes.save_scene)
    delete = blocking(scenes.delete_scene)


class Simulation(_Part):
    """The simulation: what really is, apart from what is believed."""

    get = blocking(simulation.get_simulation)
    bodies = blocking(simulation.list_bodies)
    move_body = blocking(simulation.move_body)
    remove_body = blocking(simulation.remove_body)
    reset = blocking(simulation.reset_simulation)
    set_pace = blocking(simulation.set_pace)
    picture = blocking(simulation.get_picture)


class Modules(_Part):
    """Skills and primitives by themselves, and who runs them."""

    managers = blocking(modules.list_managers)
    list = blocking(modules.list_modules)
    get = blocking(modules.get_module)
    panel = blocking(modules.show_panel)
    run = blocking(modules.run_module)
    reset = blocking(modules.reset_module)
    runs = blocking(modules.list_module_runs)
    get_run = blocking(modules.get_module_run)
    command = blocking(modules.command_module_run)
    skills = blocking(modules.list_skills)
    skill = blocking(modules.get_skill)


class Plugins(_Part):
    """Plug-ins that are installed, and their faults."""

    list = blocking(plugins.list_plugins)
    faults = blocking(plugins.list_plugin_faults)


class Robots(_Part):
    """Robots: looked at, moved by hand, taught."""

    list = blocking(robots.list_robots)
    get = blocking(robots.get_robot)
    state = blocking(robots.get_robot_state)
    model = blocking(robot_models.get_robot_model)
    mesh = blocking(robot_models.get_robot_mesh)
    motion = blocking(robots.get_robot_motion)
    look = blocking(robots.get_look)
    jog = blocking(robots.jog_robot)
    teach = blocking(robots.teach_robot)
    home = blocking(robots.home_robot)


class Sequences(_Part):
    """Sequences of steps that somebody puts together."""

    list = blocking(sequences.list_sequences)
    create = blocking(sequences.create_sequence)
    get = blocking(sequences.get_sequence)
    delete = blocking(sequences.delete_sequence)
    insert_step = blocking(sequences.insert_step)
    change_step = blocking(sequences.change_step)
    remove_step = blocking(sequences.remove_step)
    move_step = blocking(sequences.move_step)
    run = blocking(sequences.run_sequence)


class Tasks(_Part):
    """Goals that are pursued at this moment."""

    list = blocking(tasks.list_tasks)
    begin = blocking(tasks.begin_task)
    get = blocking(tasks.get_task)
    trace = blocking(tasks.get_task_trace)
    command = blocking(tasks.command_task)


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

    def __init__(self, client: Sends) -> None:
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
