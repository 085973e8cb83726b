"""Skill managers, modules and skills, as the API shows them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from skiros_py.api import modules as api
from skiros_py.catalogue import Surveyed
from skiros_py.execution.skill_manager import SkillManager
from skiros_py.planning.problem.task import Capability
from skiros_py.skills.behaviour import Behaviour, nodes_of
from skiros_py.skills.conditions import Condition
from skiros_py.skills.outcome import Failure
from skiros_py.skills.parameters import Kind, Output, Param
from skiros_py.skills.parameters.values import as_json, as_shown, schema
from skiros_py.skills.skill import RunnableDocument, Skill
from skiros_py.skills.surroundings import owner
from skiros_py.station.modules.runs import ModuleRun, Round
from skiros_py.station.session import Session

# ---------------------------------------------------------------------- managers and modules


def managers(session: Session) -> list[api.ManagerInfo]:
    """Describes all skill managers; to be called in the control thread."""
    return [manager(session, one) for _, one in sorted(session.managers.items())]


def manager(session: Session, manager: SkillManager) -> api.ManagerInfo:
    """Describes a skill manager."""
    element = session.world.element(manager.agent) if session.world.has(manager.agent) else None
    offered = set(manager.descriptions)
    return api.ManagerInfo.view_of(
        manager,
        label=element.label if element else "",
        type=element.type if element else "",
        robot=_place(session, manager.agent).robot,
        skills=sorted(offered),
        primitives=[name for name in manager.modules if manager.info(name).kind == "primitive"],
        running=[api.RunningInfo(module=name, status=run.status) for name, run in sorted(manager.running.items())],
    )


def _place(session: Session, agent: str) -> api.ModulePlace:
    there = session.world.has(agent)
    return api.ModulePlace(agent=agent, robot=(owner(session.world, agent) or "") if there else "")


def modules(session: Session) -> list[api.ModuleSummary]:
    """Describes every module once, with the subsystems that can run it; to be called in the control thread."""
    able: dict[str, list[SkillManager]] = {}
    for _, manager in sorted(session.managers.items()):
        for name in (*manager.modules, *manager.documents):
            able.setdefault(name, []).append(manager)
    return [
        api.ModuleSummary.view_of(ones[0].info(name), agents=[_place(session, one.agent) for one in ones])
        for name, ones in sorted(able.items())
    ]


def module(manager: SkillManager, name: str) -> api.ModuleDetails:
    """Describes one module of a manager.

    Raises:
        UnknownName: It has none with this name.
    """
    info = manager.info(name)
    ways = manager.skills[name] if info.kind == "skill" else ()
    description = ways[0].description if ways else None
    document = manager.document(name)
    return api.ModuleDetails.view_of(
        info,
        agent=manager.agent,
        parameters=_parameters(info.params),
        outputs=[_output(output) for output in info.outputs],
        pre=_conditions(description.pre if description else ()),
        hold=_conditions(description.hold if description else ()),
        post=_conditions(description.post if description else ()),
        implementations=[_document(document)] if document is not None else [_implementation(way) for way in ways],
    )


def _parameters(params: Iterable[Param]) -> list[api.ModuleParameter]:
    return [
        api.ModuleParameter.view_of(
            param,
            type=param.type_name,
            kind=param.kind.value,
            required=param.kind.is_required,
            planning=param.kind is Kind.PLANNING,
            default=as_json(param, param.default),
            json_schema=schema(param),
        )
        for param in params
    ]


def _output(output: Output) -> api.ModuleOutput:
    typed = schema(output.param) if output.type else {}
    return api.ModuleOutput.view_of(output, type=output.param.type_name, json_schema=typed)


def _conditions(conditions: Iterable[Condition]) -> list[api.SkillCondition]:
    return [
        api.SkillCondition.view_of(one, text=str(one), words=one.type.help, word=one.type.name) for one in conditions
    ]


def _implementation(way: Skill) -> api.Implementation:
    return api.Implementation.view_of(
        way, driver=way.driver or "", when=_conditions(way.when), nodes=_nodes(way.parts), edges=_edges(way.parts)
    )


def _document(document: RunnableDocument) -> api.Implementation:
    revision, parts = str(document.revision), {"body": document.behaviour}
    return api.Implementation(
        label=f"revision {revision}",
        version=revision,
        driver="",
        order=0,
        requires=[],
        when=[],
        nodes=_nodes(parts),
        edges=_edges(parts),
    )


def _nodes(parts: Mapping[str, Behaviour]) -> list[api.BodyNode]:
    return [
        api.BodyNode.view_of(
            node.behaviour, path=node.path, module=next((call.module for call in node.behaviour.uses().calls), "")
        )
        for part, root in parts.items()
        for node in nodes_of(root, part)
    ]


def _edges(parts: Mapping[str, Behaviour]) -> list[api.BodyEdge]:
    drawn = (edge for part, root in parts.items() for node in nodes_of(root, part) for edge in node.edges)
    return [*(api.BodyEdge(source="", target=part, label="") for part in parts), *map(api.BodyEdge.view_of, drawn)]


# ---------------------------------------------------------------------- skills


def skills(session: Session) -> list[api.SkillInfo]:
    """Describes the skills offered now; to be called in the control thread."""
    return [_skill(session, one) for one in sorted(session.tasks.capabilities, key=lambda one: one.skill.name)]


def _skill(session: Session, capability: Capability) -> api.SkillInfo:
    skill = capability.skill
    return api.SkillInfo.view_of(
        skill,
        parameters=_parameters(skill.params),
        needs=_conditions(skill.needs),
        pre=_conditions(skill.pre),
        hold=_conditions(skill.hold),
        post=_conditions(skill.post),
        agents=[_place(session, agent) for agent in capability.agents],
    )


# ---------------------------------------------------------------------- runs


def run_info(run: ModuleRun, *, in_full: bool = True) -> api.ModuleRunInfo:
    """Describes a run; callable in any thread; without ``in_full``, omits its progress reports and changes."""
    progress, changes = (tuple(run.progress), tuple(run.changes)) if in_full else ((), ())
    return api.ModuleRunInfo.view_of(
        run,
        agent=run.wish.agent,
        module=run.wish.module,
        by=run.wish.by,
        given=run.wish.given,
        repeat=run.wish.repeat,
        started=run.wall,
        arguments={param.key: as_shown(param, run.values.get(param.key)) for param in run.params},
        breakpoints=sorted(run.breakpoints),
        rounds=[_round(one) for one in tuple(run.rounds)],
        progress=[api.ModuleProgress.view_of(one, run=one.id, status=one.status.value) for one in progress],
        changes=[change.as_json() for change in changes],
    )


def _round(one: Round) -> api.ModuleRound:
    match one.outcome:
        case Failure(reason=text, code=code):
            return api.ModuleRound.view_of(one, success=False, code=code, text=text)
        case outcome:
            return api.ModuleRound.view_of(one, success=True, code=1, text=outcome.message)


# ---------------------------------------------------------------------- plug-ins


def plugin(one: Surveyed) -> api.PluginInfo:
    """Describes an entry point."""
    entry, own = one.entry, one.entry.distribution
    return api.PluginInfo.view_of(
        entry, distribution=own.name, version=own.version, object=entry.value, works=one.works, faults=one.faults
    )
