"""Modules: skill managers, what they can run, runs, plug-ins, and the documents that robots run."""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field

from skiros_py.api.wire import Answer, Items, Moment, Request

_LONGEST_KEY = 100
_MOST_ARGUMENTS = 50
_MOST_ROUNDS = 1000
_MOST_BREAKPOINTS = 100

_LONGEST = 20_000

Key = Annotated[str, Field(max_length=_LONGEST_KEY)]


def _sound(values: dict[str, Any]) -> dict[str, Any]:
    """Refuses what JSON does not carry back: endless numbers, broken characters; and what is longer than any form."""
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


class ModulePlace(Answer):
    """Where a module can be run."""

    agent: str = Field(examples=["arm_1"])
    """Id of the subsystem."""
    robot: str = Field(examples=["robot_1"])
    """Id of its robot."""


class ModuleSummary(Answer):
    """A module, for people who choose one."""

    name: str = Field(examples=["pick"])
    """Its name."""
    kind: Literal["skill", "primitive", "document"] = Field(examples=["skill"])
    """What it is."""
    help: str = Field(examples=["Picks a part from a storage place."])
    """One sentence."""
    version: str = Field(examples=["1.0.0"])
    """Version of the first implementation."""
    agents: list[ModulePlace]
    """The subsystems that can run it."""


class ModuleParameter(Answer):
    """One parameter, with all that a form needs."""

    key: str = Field(examples=["Object"])
    """Its name."""
    type: str = Field(examples=["sk:Manipulatable"])
    """Class of the element it takes, or type of its value."""
    kind: str = Field(examples=["online"])
    """Who specifies it: online, offline, optional, hardware, config or planning."""
    help: str = Field(examples=["The part."])
    """One sentence."""
    unit: str = Field(examples=["m"])
    """Unit of a number; empty where it has none."""
    required: bool
    """True where the module does not run before it is specified or inferred."""
    planning: bool
    """True where it is inferred and forms do not show it."""
    default: Any = Field(None, examples=[None])
    """Value if none is given."""
    json_schema: dict[str, Any]
    """JSON schema of its value; `class` names the class of an element."""


class ModuleOutput(Answer):
    """A value that a module finds out."""

    name: str = Field(examples=["answer"])
    """Its name; bodies and documents write it with `Out`."""
    type: str = Field(examples=["text"])
    """Class of the element, or type of the value; empty where it is not declared (documents)."""
    unit: str = Field(examples=["m"])
    """Unit of a number; empty where it has none."""
    help: str = Field(examples=["What the person chose."])
    """Its meaning."""
    json_schema: dict[str, Any]
    """JSON schema of the value; empty where its type is not declared."""


class SkillCondition(Answer):
    """A condition of a skill, over its parameters."""

    text: str = Field(examples=["ObjectAtLocation(Object, Container)"])
    """As planners and logs write it."""
    words: str = Field(examples=["The object is at the location."])
    """What the word means, in a sentence."""
    word: str = Field(examples=["ObjectAtLocation"])
    """Its name."""
    arguments: list[str] = Field(examples=[["Object", "Container"]])
    """Keys of parameters."""
    negated: bool
    """True where it must not hold."""


class BodyNode(Answer):
    """One node of what a skill does."""

    path: str = Field(examples=["body/0/2"])
    """Names it; in events the module's path stands before it."""
    kind: str = Field(examples=["do"])
    """Kind of behaviour."""
    title: str = Field(examples=["move_arm(arm=Arm)"])
    """For people."""
    module: str = Field(examples=["move_arm"])
    """The module that it calls; empty for none."""


class BodyEdge(Answer):
    """An arrow between two nodes of what a skill does."""

    source: str = Field(examples=["body"])
    """Path of a node; empty for the skill."""
    target: str = Field(examples=["body/0"])
    """Path of a node; empty for the skill."""
    label: str = Field(examples=[""])
    """What is written on it; may be empty."""


class Implementation(Answer):
    """One way to do a skill."""

    label: str = Field(examples=["by vision"])
    """Its name among the ways; may be empty."""
    version: str = Field(examples=["1.0.0"])
    """Its version."""
    driver: str = Field(examples=["fake"])
    """Kind of cell it is for; empty for all that are no fake."""
    order: int = Field(examples=[0])
    """Ways are tried by this number."""
    requires: list[str] = Field(examples=[["sk:Camera"]])
    """Classes of devices that the robot must have."""
    when: list[SkillCondition]
    """Further conditions under which it can be used."""
    nodes: list[BodyNode]
    """What it does, from the top."""
    edges: list[BodyEdge]
    """The arrows between the nodes."""


class ModuleDetails(Answer):
    """A module of one subsystem: all that is known before it runs."""

    agent: str = Field(examples=["arm_1"])
    """Id of the subsystem."""
    name: str = Field(examples=["pick"])
    """Its name."""
    kind: Literal["skill", "primitive", "document"] = Field(examples=["skill"])
    """What it is."""
    help: str = Field(examples=["Picks a part from a storage place."])
    """One sentence."""
    version: str = Field(examples=["1.0.0"])
    """Version of the first implementation."""
    parameters: list[ModuleParameter]
    """Its parameters."""
    outputs: list[ModuleOutput]
    """The values that its outcome has; none of a skill."""
    pre: list[SkillCondition]
    """What must hold before it starts; none for a primitive."""
    hold: list[SkillCondition]
    """What must hold while it runs."""
    post: list[SkillCondition]
    """What holds after it."""
    implementations: list[Implementation]
    """Ways of doing it, in the order of trying."""


class SkillInfo(Answer):
    """A skill as people and planners see it, apart from how it is done."""

    name: str = Field(examples=["pick"])
    """Its name."""
    help: str = Field(examples=["Picks a part from a storage place."])
    """One sentence."""
    agent: str = Field(examples=["Arm"])
    """Key of the parameter that is the subsystem doing it."""
    agent_class: str = Field(examples=["sk:Arm"])
    """Class of that subsystem."""
    target: str = Field(examples=["Object"])
    """Key of the parameter that it is done to."""
    duration: float | None = Field(examples=[6])
    """How long it takes as a rule [s]; null if unknown."""
    parameters: list[ModuleParameter]
    """Its parameters."""
    needs: list[SkillCondition]
    """All that must hold before: parameters as described, then `pre`."""
    pre: list[SkillCondition]
    """What must hold before it starts."""
    hold: list[SkillCondition]
    """What must hold while it runs."""
    post: list[SkillCondition]
    """What holds after it: its effects."""
    agents: list[ModulePlace]
    """Who offers it now."""


class PanelRequest(Request):
    """With what a module would be run."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"arguments": {}}]})

    arguments: Arguments = Field(default_factory=dict, examples=[{"Object": "starter_1"}])
    """Value by parameter key."""


class RunModule(PanelRequest):
    """With what a module is run, and how often."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"arguments": {}, "repeat": 1}]})

    repeat: int = Field(1, ge=1, le=_MOST_ROUNDS)
    """How often it is done, one after the other."""
    breakpoints: Breakpoints = Field(default_factory=tuple, description=_BREAKPOINTS, examples=[["body/1"]])


class SetBreakpoints(Request):
    """Where a run is paused."""

    paths: Breakpoints = Field(description=_BREAKPOINTS, examples=[["body/1"]])


class PanelRow(Answer):
    """One condition, as things are now."""

    kind: str = Field(examples=["pre"])
    """pre, hold or post."""
    condition: str = Field(examples=["EmptyHanded(Gripper)"])
    """In words."""
    holds: bool | None = Field(examples=[True])
    """Null where a parameter is still open."""
    why: list[str] = Field(examples=[[]])
    """Why not, a line a reason."""


class PanelInfo(Answer):
    """What a module would be run with now, and which of its conditions hold."""

    ready: bool
    """True when everything is specified and every precondition holds."""
    arguments: dict[str, Any]
    """What is specified or inferred, by key; null where it is open."""
    inferred: dict[str, str]
    """Why this value, for inferred ones."""
    missing: dict[str, str]
    """Why a parameter stays open."""
    conditions: list[PanelRow]
    """Its conditions; none for a primitive."""


class ModuleProgress(Answer):
    """One message of a module that runs, or of a part of it."""

    time: float = Field(examples=[12.5])
    """Run time [s]."""
    module: str = Field(examples=["move_arm"])
    """Which module."""
    kind: str = Field(examples=["primitive"])
    """skill or primitive."""
    status: str = Field(examples=["running"])
    """started, running, preempted, terminated, error or event."""
    code: int = Field(examples=[1])
    """Progress code; negative for an error."""
    text: str = Field(examples=["leg 1 of 2"])
    """For people."""
    agent: str = Field(examples=["arm_1"])
    """Subsystem that runs it."""
    caller: str = Field(examples=[""])
    """Module that it is part of; empty for the one that was started."""
    run: str = Field(examples=["r12"])
    """Id of the run that it is of."""
    parent: str = Field(examples=["r9"])
    """Id of the run that this is part of; empty for none."""
    path: str = Field(examples=["pick/body/0/2"])
    """Which node: module that was started, part, keys."""
    event: str = Field(examples=[""])
    """Name of the event that it announced; empty for none."""
    value: Any = Field(None, examples=[None])
    """Value of that event."""


class ModuleRound(Answer):
    """How it ended once."""

    success: bool
    """Whether it worked."""
    code: int = Field(examples=[1])
    """1 where it worked, else the error's code."""
    text: str = Field(examples=["at pallet_a"])
    """What came of it, or why it failed."""
    start: float = Field(examples=[12.5])
    """Run time [s]."""
    end: float = Field(examples=[18.0])
    """Run time [s]."""


class ModuleRunInfo(Answer):
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
    """What it does, or how it ended."""
    started: Moment = Field(examples=["2026-11-21T13:22:56.120Z"])
    """When."""
    given: dict[str, Any]
    """The arguments that were given."""
    arguments: dict[str, Any]
    """All arguments, with what was inferred."""
    repeat: int = Field(examples=[1])
    """How often it shall be done."""
    breakpoints: list[str] = Field(examples=[["tree:tidy up/body/1"]])
    """Nodes before which it is paused."""
    done: int = Field(examples=[1])
    """How often it has ended."""
    succeeded: int = Field(examples=[1])
    """How often it worked."""
    cut_off: bool = False
    """Whether the last round was cancelled by a stop: it says nothing of the module."""
    rounds: list[ModuleRound]
    """How it ended each time; of very many the last 100."""
    progress: list[ModuleProgress]
    """What it reported; of very many the last 500."""
    changes: list[dict[str, Any]]
    """What it wrote into the world; of very many the last 100."""


ModuleRuns = Items[ModuleRunInfo]
"""Runs, newest first."""


class PluginFaultInfo(Answer):
    """A fault of a plug-in; it does not affect others."""

    name: str = Field(examples=["drive"])
    """Name of the entry point."""
    group: str = Field(examples=["skiros.skills"])
    """Group of the entry point."""
    distribution: str = Field(examples=["skiros-skills 0.1.0"])
    """What brings it, with its version."""
    reason: str = Field(examples=["ModuleNotFoundError: No module named 'cv2'"])
    """What is wrong."""
    origin: str = Field(examples=["drive.py"])
    """File that it is in; empty where unknown."""
    traceback: str = Field(examples=[""])
    """Where it was raised; empty where nothing was."""


class PluginInfo(Answer):
    """One entry point."""

    name: str = Field(examples=["drive"])
    """Its name."""
    group: str = Field(examples=["skiros.skills"])
    """Its group."""
    distribution: str = Field(examples=["skiros-skills"])
    """What brings it."""
    version: str = Field(examples=["0.1.0"])
    """Version of that."""
    object: str = Field(examples=["skiros_skills.drive:DRIVE"])
    """What it names."""
    works: bool
    """True where nothing is wrong with it."""
    faults: list[PluginFaultInfo]
    """What is wrong with it."""


class Plugins(Answer):
    """What is installed."""

    items: list[PluginInfo]
    """All entry points, by group and name."""
    others: list[PluginFaultInfo]
    """Faults that belong to none of them."""
