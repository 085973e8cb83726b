"""Modules: skill managers, what they can run, runs, plug-ins, and the documents that robots run."""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field

from skiros_py.api.wire import Answer, Moment, Page, Request, Sentence, Told

_LONGEST_KEY = 100
_MOST_ARGUMENTS = 50
_MOST_ROUNDS = 1000
_MOST_BREAKPOINTS = 100

_LONGEST = 20_000

Key = Annotated[str, Field(max_length=_LONGEST_KEY)]


def _sound(values: dict[str, Any]) -> dict[str, Any]:
    """Refuses values that JSON cannot represent (infinite numbers, lone surrogates), and those that are too long."""
    try:
        text = json.dumps(values, allow_nan=False, ensure_ascii=False)
        text.encode()
    except (ValueError, RecursionError) as error:
        raise ValueError(f"no value that can be written down again: {type(error).__name__}") from None
    if len(text) > _LONGEST:
        raise ValueError(f"at most {_LONGEST} characters of JSON, not {len(text)}")
    return values


Arguments = Annotated[dict[Key, Any], Field(max_length=_MOST_ARGUMENTS), AfterValidator(_sound)]
"""Values by parameter; omitted or null ones are inferred."""
Breakpoints = Annotated[
    tuple[Annotated[str, Field(min_length=1, max_length=500)], ...], Field(max_length=_MOST_BREAKPOINTS)
]
_BREAKPOINTS = "Paths of nodes of its implementation before which it is paused."
RunCommand = Literal["pause", "resume", "step", "stop"]
"""Commands to a run of a module or a task."""

ModuleRunStatus = Literal["running", "paused", "stopping", "stopped", "succeeded", "failed"]


class RunningInfo(Answer):
    """A module that runs now."""

    module: str = Field(examples=["pick"])
    """Name of the module."""
    status: str = Field(examples=["running"])
    """running, paused or stopping."""


class ManagerInfo(Answer):
    """A skill manager: what one subsystem of a robot can do."""

    agent: str = Field(examples=["arm_1"])
    """Id of the subsystem."""
    label: str = Field(examples=["arm 1"])
    """Its label."""
    type: str = Field(examples=["sk:Arm"])
    """Its class."""
    robot: str = Field(examples=["robot_1"])
    """Id of its robot; empty if it has none."""
    skills: list[str] = Field(examples=[["pick", "place"]])
    """The available skills; none while it is lost."""
    primitives: list[str] = Field(examples=[["move_arm"]])
    """The primitives whose hardware it has."""
    running: list[RunningInfo]
    """Its running modules."""
    lost: str = Field(examples=[""])
    """Why it is lost; empty if it is not."""


Managers = Page[ManagerInfo]
"""The skill managers."""


class ModulePlace(Answer):
    """Where a module can be run."""

    agent: str = Field(examples=["arm_1"])
    """Id of the subsystem."""
    robot: str = Field(examples=["robot_1"])
    """Id of its robot."""


class NamedModule(Answer):
    """A module."""

    name: str = Field(examples=["pick"])
    """Its name."""
    kind: Literal["skill", "primitive", "document"] = Field(examples=["skill"])
    """Its kind."""
    help: str = Field(examples=["Picks a part from a storage place."])
    """Description in one sentence."""
    version: str = Field(examples=["1.0.0"])
    """Version of the first implementation."""


class ModuleSummary(NamedModule):
    """A module, for people who choose one."""

    agents: list[ModulePlace]
    """The subsystems that can run it."""


Modules = Page[ModuleSummary]
"""All modules."""


class ModuleParameter(Answer):
    """One parameter, with the data that a form needs."""

    key: str = Field(examples=["Object"])
    """Its name."""
    type: str = Field(examples=["sk:Manipulatable"])
    """Class of the element it takes, or type of its value."""
    kind: str = Field(examples=["online"])
    """Who specifies it: online, offline, optional, hardware, config or planning."""
    help: str = Field(examples=["The part."])
    """Description in one sentence."""
    unit: str = Field(examples=["m"])
    """Unit of a number; empty if it has none."""
    required: bool
    """Whether the module runs only after it was specified or inferred."""
    planning: bool
    """Whether it is inferred and not shown in forms."""
    default: Any = Field(None, examples=[None])
    """Default value; null if there is none."""
    json_schema: dict[str, Any]
    """JSON schema of its value; `class` names the class of an element."""


class ModuleOutput(Answer):
    """A value that a module returns."""

    name: str = Field(examples=["answer"])
    """Its name; bodies and documents write it with `Out`."""
    type: str = Field(examples=["text"])
    """Class of the element, or type of the value; empty if it is not declared (documents)."""
    unit: str = Field(examples=["m"])
    """Unit of a number; empty if it has none."""
    help: str = Field(examples=["What the person chose."])
    """Its meaning."""
    json_schema: dict[str, Any]
    """JSON schema of the value; empty if its type is not declared."""


class SkillCondition(Answer):
    """A condition of a skill, over its parameters."""

    text: str = Field(examples=["ObjectAtLocation(Object, Container)"])
    """The condition as in plans and logs."""
    words: str = Field(examples=["The object is at the location."])
    """Meaning of the condition, in a sentence."""
    word: str = Field(examples=["ObjectAtLocation"])
    """Its name."""
    arguments: list[str] = Field(examples=[["Object", "Container"]])
    """Keys of the parameters that are its arguments."""
    negated: bool
    """Whether it must not hold."""


class BodyNode(Answer):
    """One node of a skill's body."""

    path: str = Field(examples=["body/0/2"])
    """Its path; in events it follows the path of the module."""
    kind: str = Field(examples=["do"])
    """Kind of behaviour."""
    title: str = Field(examples=["move_arm(arm=Arm)"])
    """Display text."""
    module: str = Field(examples=["move_arm"])
    """The module that it calls; empty if it calls none."""


class BodyEdge(Answer):
    """An edge between two nodes of a skill's body."""

    source: str = Field(examples=["body"])
    """Path of a node; empty for the skill."""
    target: str = Field(examples=["body/0"])
    """Path of a node; empty for the skill."""
    label: str = Field(examples=[""])
    """Its label; may be empty."""


class Implementation(Answer):
    """One implementation of a skill."""

    label: str = Field(examples=["by vision"])
    """Its name among the implementations; may be empty."""
    version: str = Field(examples=["1.0.0"])
    """Its version."""
    driver: str = Field(examples=["fake"])
    """The driver that it is for; empty for all except the fake."""
    order: int = Field(examples=[0])
    """Position in the order in which implementations are tried."""
    requires: list[str] = Field(examples=[["sk:Camera"]])
    """Classes of devices that the robot must have."""
    when: list[SkillCondition]
    """Additional conditions for its use."""
    nodes: list[BodyNode]
    """Nodes of its body, the root first."""
    edges: list[BodyEdge]
    """Edges of its body."""


class SkillTerms(Answer):
    """What a skill or primitive takes, requires and brings about."""

    parameters: list[ModuleParameter]
    """Its parameters."""
    pre: list[SkillCondition]
    """Preconditions; empty for a primitive."""
    hold: list[SkillCondition]
    """Hold conditions: they must hold while it runs."""
    post: list[SkillCondition]
    """Postconditions: its effects, which hold after it succeeded."""


class ModuleDetails(SkillTerms, NamedModule):
    """A module of one subsystem, as known before it runs."""

    agent: str = Field(examples=["arm_1"])
    """Id of the subsystem."""
    outputs: list[ModuleOutput]
    """Values of its outcome; empty for a skill."""
    implementations: list[Implementation]
    """Its implementations, in the order in which they are tried."""


class SkillInfo(SkillTerms):
    """A skill as seen by people and planners, without its implementations."""

    name: str = Field(examples=["pick"])
    """Its name."""
    help: str = Field(examples=["Picks a part from a storage place."])
    """Description in one sentence."""
    agent: str = Field(examples=["Arm"])
    """Key of the parameter for the subsystem that executes it."""
    agent_class: str = Field(examples=["sk:Arm"])
    """Class of that subsystem."""
    target: str = Field(examples=["Object"])
    """Key of the parameter for the element that it acts on."""
    duration: float | None = Field(examples=[6])
    """Typical duration [s]; null if unknown."""
    needs: list[SkillCondition]
    """All conditions before its start: those of the parameters, then `pre`."""
    agents: list[ModulePlace]
    """The subsystems that offer it now."""


Skills = Page[SkillInfo]
"""The available skills."""


class PanelRequest(Request):
    """Arguments with which a module would be run."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"arguments": {}}]})

    arguments: Arguments = Field(default_factory=dict, examples=[{"Object": "starter_1"}])
    """Values by parameter key."""


class RunModule(PanelRequest):
    """Arguments with which a module is run, and the number of rounds."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"arguments": {}, "repeat": 1}]})

    repeat: int = Field(1, ge=1, le=_MOST_ROUNDS)
    """Number of rounds, executed one after the other."""
    breakpoints: Breakpoints = Field(default_factory=tuple, description=_BREAKPOINTS, examples=[["body/1"]])


class SetBreakpoints(Request):
    """Breakpoints of a run."""

    paths: Breakpoints = Field(description=_BREAKPOINTS, examples=[["body/1"]])


class PanelRow(Answer):
    """One condition in the present state."""

    kind: str = Field(examples=["pre"])
    """pre, hold or post."""
    condition: str = Field(examples=["EmptyHanded(Gripper)"])
    """The condition, as text."""
    holds: bool | None = Field(examples=[True])
    """Whether it holds; null while a parameter has no value."""
    why: list[Sentence] = Field(examples=[[]])
    """Reasons why it does not hold."""


class PanelInfo(Told):
    """Arguments that a module would have now, and whether its conditions hold."""

    ready: bool
    """Whether all parameters have values and all preconditions hold."""
    arguments: dict[str, Any]
    """Specified and inferred values by parameter key; null for parameters without one."""
    inferred: dict[str, Sentence]
    """Reasons for inferred values, by parameter key."""
    missing: dict[str, Sentence]
    """Why a parameter has no value, by parameter key."""
    conditions: list[PanelRow]
    """Its conditions; empty for a primitive."""


class ModuleProgress(Answer):
    """A progress message of a running module, or of a part of it."""

    time: float = Field(examples=[12.5])
    """Run time [s]."""
    module: str = Field(examples=["move_arm"])
    """The module."""
    kind: str = Field(examples=["primitive"])
    """skill or primitive."""
    status: str = Field(examples=["running"])
    """started, running, preempted, terminated, error or event."""
    code: int = Field(examples=[1])
    """Progress code; negative for an error."""
    text: Sentence = Field(examples=["leg 1 of 2"])
    """Display text."""
    agent: str = Field(examples=["arm_1"])
    """Subsystem that runs it."""
    caller: str = Field(examples=[""])
    """The module that called it; empty for the one that was started."""
    run: str = Field(examples=["r12"])
    """Id of its run."""
    parent: str = Field(examples=["r9"])
    """Id of the parent run; empty if there is none."""
    path: str = Field(examples=["pick/body/0/2"])
    """Path of the node, from the module that was started."""
    event: str = Field(examples=[""])
    """Name of the announced event; empty if there is none."""
    value: Any = Field(None, examples=[None])
    """Value of that event."""


class ModuleRound(Answer):
    """Outcome of one round."""

    success: bool
    """Whether it succeeded."""
    code: int = Field(examples=[1])
    """1 if it succeeded, otherwise the error code."""
    text: Sentence = Field(examples=["at pallet_a"])
    """The result, or why it failed."""
    start: float = Field(examples=[12.5])
    """Run time [s]."""
    end: float = Field(examples=[18.0])
    """Run time [s]."""


class ModuleRunInfo(Told):
    """A module that was started from outside."""

    id: str = Field(examples=["3f2a9c1e-7"])
    """Id of the run."""
    agent: str = Field(examples=["arm_1"])
    """Subsystem that runs it."""
    module: str = Field(examples=["jog_joints"])
    """Name of the module."""
    by: str = Field(examples=["anna"])
    """Who started it."""
    status: ModuleRunStatus = Field(examples=["succeeded"])
    """Its status."""
    started: Moment = Field(examples=["2026-11-21T13:22:56.120Z"])
    """When it was started."""
    given: dict[str, Any]
    """The given arguments, by parameter key."""
    arguments: dict[str, Any]
    """All arguments, also inferred ones, by parameter key."""
    repeat: int = Field(examples=[1])
    """Number of requested rounds."""
    breakpoints: list[str] = Field(examples=[["tree:tidy up/body/1"]])
    """Paths of nodes before which it is paused."""
    done: int = Field(examples=[1])
    """Number of finished rounds."""
    succeeded: int = Field(examples=[1])
    """Number of successful rounds."""
    cut_off: bool = False
    """Whether the last round was cancelled by a stop, so that its outcome says nothing about the module."""
    rounds: list[ModuleRound]
    """Outcomes of the rounds: the last 100."""
    progress: list[ModuleProgress]
    """Its progress messages: the last 500."""
    changes: list[dict[str, Any]]
    """Its changes of the world: the last 100."""


ModuleRuns = Page[ModuleRunInfo]
"""Runs, newest first."""


class PluginFaultInfo(Answer):
    """A fault of a plug-in; it does not affect others."""

    name: str = Field(examples=["drive"])
    """Name of the entry point."""
    group: str = Field(examples=["skiros.skills"])
    """Group of the entry point."""
    distribution: str = Field(examples=["skiros-skills 0.1.0"])
    """Its distribution, with version."""
    reason: str = Field(examples=["ModuleNotFoundError: No module named 'cv2'"])
    """The fault, in a sentence."""
    origin: str = Field(examples=["drive.py"])
    """File of its module; empty if unknown."""
    traceback: str = Field(examples=[""])
    """The stack of the exception; empty if none was raised."""


class PluginInfo(Answer):
    """One entry point."""

    name: str = Field(examples=["drive"])
    """Its name."""
    group: str = Field(examples=["skiros.skills"])
    """Its group."""
    distribution: str = Field(examples=["skiros-skills"])
    """Its distribution."""
    version: str = Field(examples=["0.1.0"])
    """Version of the distribution."""
    object: str = Field(examples=["skiros_skills.drive:DRIVE"])
    """The object that it names."""
    works: bool
    """Whether it has no faults."""
    faults: list[PluginFaultInfo]
    """Its faults."""


PluginFaults = Page[PluginFaultInfo]
"""Faults of plug-ins."""


class Plugins(Page[PluginInfo]):
    """All installed entry points, by group and name."""

    others: list[PluginFaultInfo]
    """Faults that belong to no entry point."""
