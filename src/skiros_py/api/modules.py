"""Modules: skill managers, what they can run, runs, plug-ins, and the documents that robots run."""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field

from skiros_py.api.wire import Answer, Moment, Request

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
"""Value by parameter key; what is left out, or null, is inferred."""
Breakpoints = Annotated[
    tuple[Annotated[str, Field(min_length=1, max_length=500)], ...], Field(max_length=_MOST_BREAKPOINTS)
]
_BREAKPOINTS = "Paths of nodes of its implementation before which it is paused."
ModuleRunStatus = Literal["running", "paused", "stopping", "stopped", "succeeded", "failed"]


class RunningInfo(Answer):
    """A module that runs now."""

    module: str = Field(description="Name of the module.", examples=["pick"])
    status: str = Field(description="running, paused or stopping.", examples=["running"])


class ManagerInfo(Answer):
    """A skill manager: what one subsystem of a robot can do."""

    agent: str = Field(description="Id of the subsystem.", examples=["arm_1"])
    label: str = Field(description="Its name for people.", examples=["arm 1"])
    type: str = Field(description="Its class.", examples=["sk:Arm"])
    robot: str = Field(description="Id of its robot; empty where it belongs to none.", examples=["robot_1"])
    skills: list[str] = Field(description="The skills it offers; none while it is lost.", examples=[["pick", "place"]])
    primitives: list[str] = Field(description="The primitives whose hardware it has.", examples=[["move_arm"]])
    running: list[RunningInfo] = Field(description="What it runs now.")
    lost: str = Field(description="Why it is lost; empty if it is not.", examples=[""])


class ModulePlace(Answer):
    """Where a module can be run."""

    agent: str = Field(description="Id of the subsystem.", examples=["arm_1"])
    robot: str = Field(description="Id of its robot.", examples=["robot_1"])


class ModuleSummary(Answer):
    """A module, for people who choose one."""

    name: str = Field(description="Its name.", examples=["pick"])
    kind: Literal["skill", "primitive", "document"] = Field(description="What it is.", examples=["skill"])
    help: str = Field(description="One sentence.", examples=["Picks a part from a storage place."])
    version: str = Field(description="Version of the first implementation.", examples=["1.0.0"])
    agents: list[ModulePlace] = Field(description="Who can run it.")


class ModuleParameter(Answer):
    """One parameter, with all that a form needs."""

    key: str = Field(description="Its name.", examples=["Object"])
    type: str = Field(description="Class of the element it takes, or type of its value.", examples=["sk:Manipulatable"])
    kind: str = Field(
        description="Who specifies it: online, offline, optional, hardware, config or planning.", examples=["online"]
    )
    help: str = Field(description="One sentence.", examples=["The part."])
    unit: str = Field(description="Unit of a number; empty where it has none.", examples=["m"])
    required: bool = Field(description="True where the module does not run before it is specified or inferred.")
    planning: bool = Field(description="True where it is inferred and forms do not show it.")
    default: Any = Field(None, description="Value if none is given.", examples=[None])
    json_schema: dict[str, Any] = Field(description="JSON schema of its value; `class` names the class of an element.")


class SkillCondition(Answer):
    """A condition of a skill, over its parameters."""

    text: str = Field(description="As planners and logs write it.", examples=["ObjectAtLocation(Object, Container)"])
    words: str = Field(description="What the word means, in a sentence.", examples=["The object is at the location."])
    word: str = Field(description="The word.", examples=["ObjectAtLocation"])
    arguments: list[str] = Field(description="Keys of parameters.", examples=[["Object", "Container"]])
    negated: bool = Field(description="True where it must not hold.")


class BodyNode(Answer):
    """One node of what a skill does."""

    path: str = Field(description="Names it; in events the module's path stands before it.", examples=["body/0/2"])
    kind: str = Field(description="Kind of behaviour.", examples=["do"])
    title: str = Field(description="For people.", examples=["move_arm(arm=Arm)"])
    module: str = Field(description="The module that it calls; empty for none.", examples=["move_arm"])


class BodyEdge(Answer):
    """An arrow between two nodes of what a skill does."""

    source: str = Field(description="Path of a node; empty for the skill.", examples=["body"])
    target: str = Field(description="Path of a node; empty for the skill.", examples=["body/0"])
    label: str = Field(description="What is written on it; may be empty.", examples=[""])


class Implementation(Answer):
    """One way to do a skill."""

    label: str = Field(description="Its name among the ways; may be empty.", examples=["by vision"])
    version: str = Field(description="Its version.", examples=["1.0.0"])
    driver: str = Field(description="Kind of cell it is for; empty for all that are no fake.", examples=["fake"])
    order: int = Field(description="Ways are tried by this number.", examples=[0])
    requires: list[str] = Field(description="Classes of devices that the robot must have.", examples=[["sk:Camera"]])
    when: list[SkillCondition] = Field(description="Further conditions under which it can be used.")
    nodes: list[BodyNode] = Field(description="What it does, from the top.")
    edges: list[BodyEdge] = Field(description="The arrows between the nodes.")


class ModuleDetails(Answer):
    """A module of one subsystem: all that is known before it runs."""

    agent: str = Field(description="Id of the subsystem.", examples=["arm_1"])
    name: str = Field(description="Its name.", examples=["pick"])
    kind: Literal["skill", "primitive", "document"] = Field(description="What it is.", examples=["skill"])
    help: str = Field(description="One sentence.", examples=["Picks a part from a storage place."])
    version: str = Field(description="Version of the first implementation.", examples=["1.0.0"])
    parameters: list[ModuleParameter] = Field(description="Its parameters.")
    pre: list[SkillCondition] = Field(description="What must hold before it starts; none for a primitive.")
    hold: list[SkillCondition] = Field(description="What must hold while it runs.")
    post: list[SkillCondition] = Field(description="What holds after it.")
    implementations: list[Implementation] = Field(description="Ways of doing it, in the order of trying.")


class SkillInfo(Answer):
    """A skill as people and planners see it, apart from how it is done."""

    name: str = Field(description="Its name.", examples=["pick"])
    help: str = Field(description="One sentence.", examples=["Picks a part from a storage place."])
    agent: str = Field(description="Key of the parameter that is the subsystem doing it.", examples=["Arm"])
    agent_class: str = Field(description="Class of that subsystem.", examples=["sk:Arm"])
    target: str = Field(description="Key of the parameter that it is done to.", examples=["Object"])
    duration: float | None = Field(description="How long it takes as a rule [s]; null if unknown.", examples=[6])
    parameters: list[ModuleParameter] = Field(description="Its parameters.")
    needs: list[SkillCondition] = Field(description="All that must hold before: parameters as described, then `pre`.")
    pre: list[SkillCondition] = Field(description="What must hold before it starts.")
    hold: list[SkillCondition] = Field(description="What must hold while it runs.")
    post: list[SkillCondition] = Field(description="What holds after it: its effects.")
    agents: list[ModulePlace] = Field(description="Who offers it now.")


class PanelRequest(Request):
    """With what a module would be run."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"arguments": {}}]})

    arguments: Arguments = Field(
        default_factory=dict, description="Value by parameter key.", examples=[{"Object": "starter_1"}]
    )


class RunModule(PanelRequest):
    """With what a module is run, and how often."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"arguments": {}, "repeat": 1}]})

    repeat: int = Field(1, ge=1, le=_MOST_ROUNDS, description="How often it is done, one after the other.")
    breakpoints: Breakpoints = Field(default_factory=tuple, description=_BREAKPOINTS, examples=[["body/1"]])


class SetBreakpoints(Request):
    """Where a run is paused."""

    paths: Breakpoints = Field(description=_BREAKPOINTS, examples=[["body/1"]])


class PanelRow(Answer):
    """One condition, as things are now."""

    kind: str = Field(description="pre, hold or post.", examples=["pre"])
    condition: str = Field(description="In words.", examples=["EmptyHanded(Gripper)"])
    holds: bool | None = Field(description="Null where a parameter is still open.", examples=[True])
    why: list[str] = Field(description="Why not, a line a reason.", examples=[[]])


class PanelInfo(Answer):
    """What a module would be run with now, and which of its conditions hold."""

    ready: bool = Field(description="True when everything is specified and every precondition holds.")
    arguments: dict[str, Any] = Field(description="What is specified or inferred, by key; null where it is open.")
    inferred: dict[str, str] = Field(description="Why this value, for inferred ones.")
    missing: dict[str, str] = Field(description="Why a parameter stays open.")
    conditions: list[PanelRow] = Field(description="Its conditions; none for a primitive.")


class ModuleProgress(Answer):
    """One message of a module that runs, or of a part of it."""

    time: float = Field(description="Run time [s].", examples=[12.5])
    module: str = Field(description="Which module.", examples=["move_arm"])
    kind: str = Field(description="skill or primitive.", examples=["primitive"])
    status: str = Field(description="started, running, preempted, terminated, error or event.", examples=["running"])
    code: int = Field(description="Progress code; negative for an error.", examples=[1])
    text: str = Field(description="For people.", examples=["leg 1 of 2"])
    agent: str = Field(description="Subsystem that runs it.", examples=["arm_1"])
    caller: str = Field(description="Module that it is part of; empty for the one that was started.", examples=[""])
    run: str = Field(description="Id of the run that it is of.", examples=["r12"])
    parent: str = Field(description="Id of the run that this is part of; empty for none.", examples=["r9"])
    path: str = Field(description="Which node: module that was started, part, keys.", examples=["pick/body/0/2"])
    event: str = Field(description="Name of the event that it announced; empty for none.", examples=[""])
    value: Any = Field(None, description="Value of that event.", examples=[None])


class ModuleRound(Answer):
    """How it ended once."""

    success: bool = Field(description="Whether it worked.")
    code: int = Field(description="1 where it worked, else the error's code.", examples=[1])
    text: str = Field(description="What came of it, or why it failed.", examples=["at pallet_a"])
    start: float = Field(description="Run time [s].", examples=[12.5])
    end: float = Field(description="Run time [s].", examples=[18.0])


class ModuleRunInfo(Answer):
    """A module that was started from outside."""

    id: str = Field(description="Id of the run.", examples=["3f2a9c1e-7"])
    agent: str = Field(description="Subsystem that runs it.", examples=["arm_1"])
    module: str = Field(description="Name of the module.", examples=["jog_joints"])
    by: str = Field(description="Who started it.", examples=["anna"])
    status: ModuleRunStatus = Field(description="What it does, or how it ended.", examples=["succeeded"])
    started: Moment = Field(description="When.", examples=["2026-11-21T13:22:56.120Z"])
    given: dict[str, Any] = Field(description="The arguments that were given.")
    arguments: dict[str, Any] = Field(description="All arguments, with what was inferred.")
    repeat: int = Field(description="How often it shall be done.", examples=[1])
    breakpoints: list[str] = Field(description="Nodes before which it is paused.", examples=[["tree:tidy up/body/1"]])
    done: int = Field(description="How often it has ended.", examples=[1])
    succeeded: int = Field(description="How often it worked.", examples=[1])
    cut_off: bool = Field(
        default=False, description="Whether the last round was broken off by a stop: it says nothing of the module."
    )
    rounds: list[ModuleRound] = Field(description="How it ended each time; of very many the last 100.")
    progress: list[ModuleProgress] = Field(description="What it reported; of very many the last 500.")
    changes: list[dict[str, Any]] = Field(description="What it wrote into the world; of very many the last 100.")


class ModuleRuns(Answer):
    """Runs, the youngest first."""

    items: list[ModuleRunInfo] = Field(description="The runs, without progress and changes.")


class PluginFaultInfo(Answer):
    """A fault of a plug-in; it does not affect others."""

    name: str = Field(description="Name of the entry point.", examples=["drive"])
    group: str = Field(description="Group of the entry point.", examples=["skiros.skills"])
    distribution: str = Field(description="What brings it, with its version.", examples=["skiros-skills 0.1.0"])
    reason: str = Field(description="What is wrong.", examples=["ModuleNotFoundError: No module named 'cv2'"])
    origin: str = Field(description="File that it is in; empty where unknown.", examples=["drive.py"])
    traceback: str = Field(description="Where it was raised; empty where nothing was.", examples=[""])


class PluginInfo(Answer):
    """One entry point."""

    name: str = Field(description="Its name.", examples=["drive"])
    group: str = Field(description="Its group.", examples=["skiros.skills"])
    distribution: str = Field(description="What brings it.", examples=["skiros-skills"])
    version: str = Field(description="Version of that.", examples=["0.1.0"])
    object: str = Field(description="What it names.", examples=["skiros_skills.drive:DRIVE"])
    works: bool = Field(description="True where nothing is wrong with it.")
    faults: list[PluginFaultInfo] = Field(description="What is wrong with it.")


class Plugins(Answer):
    """What is installed."""

    items: list[PluginInfo] = Field(description="All entry points, by group and name.")
    others: list[PluginFaultInfo] = Field(description="Faults that belong to none of them.")


_DOCUMENTS_LONGEST = 200_000


def _plain(value: Any) -> Any:
    """Refuses what JSON does not carry back, and what nobody would draw."""
    try:
        text = json.dumps(value, allow_nan=False, ensure_ascii=False)
        text.encode()
    except (ValueError, RecursionError) as error:
        raise ValueError(f"no value that can be written down again: {type(error).__name__}") from None
    if len(text) > _DOCUMENTS_LONGEST:
        raise ValueError(f"at most {_DOCUMENTS_LONGEST} characters of JSON, not {len(text)}")
    return value


class PaletteNode(Answer):
    """A node that an editor offers."""

    kind: str = Field(description="What it is called in a document.", examples=["wait"])
    help: str = Field(description="One sentence.", examples=["Lets so many seconds of run time pass."])
    fields: dict[str, str] = Field(description="Its fields with their types.", examples=[{"seconds": "float"}])


class DocumentKindInfo(Answer):
    """A kind of document."""

    kind: str = Field(description="Its name.", examples=["tree"])
    formats: tuple[str, ...] = Field(description="Text formats of import and export.", examples=[["json"]])
    palette: tuple[PaletteNode, ...] = Field(description="The nodes that an editor offers.")


class DocumentKinds(Answer):
    """All kinds of documents."""

    kinds: tuple[DocumentKindInfo, ...] = Field(description="By name.")


class DocumentContent(Request):
    """What a document says."""

    data: Annotated[dict[str, Any], AfterValidator(_plain)] = Field(
        description="The document, as its kind wants it.", examples=[{"type": "wait", "seconds": 1}]
    )


class DocumentInfo(Answer):
    """A document as it is kept."""

    kind: str = Field(description="Its kind.", examples=["tree"])
    id: str = Field(description="Its id among those of its kind.", examples=["tidy up"])
    revision: int = Field(description="Its revision, as in its ETag; it is kept with each run.", examples=[7])
    module: str = Field(description="The module that runs it.", examples=["tree:tidy up"])
    data: dict[str, Any] = Field(description="What it says.")


class Documents(Answer):
    """The documents of a kind, or the revisions of one."""

    documents: tuple[DocumentInfo, ...] = Field(description="By id; revisions the oldest first.")
