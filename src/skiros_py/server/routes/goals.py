"""Routes: goals. They are read and checked; what orders them is a job."""

from __future__ import annotations

import hashlib
from typing import Annotated

from fastapi import APIRouter, Query, Response

from skiros_py.api.goals import CheckedGoal, ConditionWords, GoalOrder, GoalTexts, SceneGoals
from skiros_py.errors import StaleVersion, UsageError
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.etags import NEEDS_VERSION, VersionDep, etag, require_version, tagged
from skiros_py.server.job_faults import job_faults
from skiros_py.server.routes.job_access import TemplatesDep
from skiros_py.server.services import Services, ServicesDep
from skiros_py.skills.conditions.reads import ReadingView
from skiros_py.station.jobs.goal_checks import checked_goal, condition_words
from skiros_py.station.jobs.orders import texts_of
from skiros_py.station.jobs.texts import goal_texts
from skiros_py.world.change import Writer

__all__ = ["router"]

router = APIRouter(tags=["goals"])


@router.post("/goals/check", summary="Check a goal", dependencies=[needs(Role.VIEWER, mes=True)])
def check_goal(order: GoalOrder, services: ServicesDep, templates: TemplatesDep) -> CheckedGoal:
    """Says how a goal is understood, and whether each condition holds now, and why not; nothing is ordered."""
    session = services.session
    version, state = session.world.state()
    view = ReadingView(state, session.world.sensors)  # one state of the world, with what devices say now
    with job_faults():
        return checked_goal(texts_of(order, templates), view, version, session.catalogue.conditions)


@router.get("/goals", summary="The goals of the scene", dependencies=[needs(Role.VIEWER, mes=True)], responses=tagged())
def get_goals(services: ServicesDep, response: Response) -> SceneGoals:
    """Shows the goals that go with the scene; they are pursued by nobody unless they are ordered as a job."""
    return _shown(services, response)


@router.put(
    "/goals",
    summary="Replace the goals of the scene",
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION | tagged(),
)
def put_goals(
    body: GoalTexts, services: ServicesDep, caller: CallerDep, version: VersionDep, response: Response
) -> SceneGoals:
    """Replaces the goals that go with the scene; `If-Match` names the version that was seen."""
    world = services.session.world
    seen = world.goals
    require_version(version, _version(seen))
    with job_faults():
        texts = goal_texts(body.goals)
        services.session.parse(texts)
    with world.transaction(caller.name, "the goals of the scene", writer=Writer.PERSON, holder=caller.holder) as tx:
        if world.goals != seen:
            raise StaleVersion("the goals of the scene were changed meanwhile: look again")
        tx.set_goals(texts)
    return _shown(services, response)


@router.get("/goals/conditions", summary="The words of goals", dependencies=[needs(Role.VIEWER, mes=True)])
def list_goal_conditions(
    services: ServicesDep,
    every: Annotated[
        bool, Query(alias="all", description="Also those that no present robot can do anything for.")
    ] = False,
) -> ConditionWords:
    """Lists the words that the present robots can fulfil, with the classes of their arguments."""
    session = services.session
    capabilities = services.control.call(lambda now: now.tasks.capabilities)
    words = condition_words(session.catalogue.conditions, capabilities, session.world.ontology)
    return ConditionWords(conditions=tuple(word for word in words if every or word.skills))


def _shown(services: Services, response: Response) -> SceneGoals:
    session = services.session
    goals = session.world.goals
    response.headers["ETag"] = etag(_version(goals))
    try:
        session.parse(goals)
    except UsageError as error:
        return SceneGoals(goals=goals, fault=str(error))
    return SceneGoals(goals=goals)


def _version(goals: tuple[str, ...]) -> int:
    """Returns a number that stands for the texts: the version of the world changes with every other thing."""
    return int.from_bytes(hashlib.sha256(repr(goals).encode()).digest()[:6])
