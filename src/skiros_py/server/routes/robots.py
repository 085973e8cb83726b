"""Routes: robots, and moving and teaching them by hand."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from fastapi import APIRouter, Body, Path, Response

from skiros_py.api.looks import Look, RobotMotion
from skiros_py.api.modules import ModuleRunInfo
from skiros_py.api.robots import HomeRobot, Jog, RobotInfo, RobotReading, Teach
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import found
from skiros_py.server.routes.modules import location_of
from skiros_py.server.services import Services, ServicesDep
from skiros_py.station.modules.views import run_info
from skiros_py.station.robots import robots

__all__ = ["router"]

router = APIRouter(tags=["robots"])

Id = Annotated[str, Path(max_length=200)]
_ALL_ARMS = HomeRobot(arm=None)
_LESSONS = {"grasp": "teach_grasp", "driving-pose": "teach_driving_pose", "placing-pose": "teach_placing_pose"}


@router.get("/robots", summary="List the robots", dependencies=[needs(Role.VIEWER)])
def list_robots(services: ServicesDep) -> list[RobotInfo]:
    """What each robot is made of: base, arms with joint limits, grippers, cameras."""
    session = services.session
    return [robots.info(session, robot) for robot in session.spec.robots]


@router.get("/robots/{id}", summary="Describe a robot", dependencies=[needs(Role.VIEWER)])
def get_robot(id: Id, services: ServicesDep) -> RobotInfo:  # noqa: A002 - as the address says it
    """What one robot is made of."""
    session = services.session
    with found():
        return robots.info(session, robots.robot_of(session, id))


@router.get("/robots/{id}/state", summary="See where a robot is", dependencies=[needs(Role.VIEWER)])
def get_robot_state(id: Id, services: ServicesDep) -> RobotReading:  # noqa: A002
    """Joints, tool, fingers and base as they are now; poses are what localisation says."""
    session = services.session
    with found():
        return robots.reading(session, robots.robot_of(session, id))


@router.get("/robots/{id}/motion", summary="See where a robot is about to go", dependencies=[needs(Role.VIEWER)])
def get_robot_motion(id: Id, services: ServicesDep) -> RobotMotion:  # noqa: A002
    """The ways that were planned for its base and arms, until they stand at the end or whoever planned has ended.

    The `motions` of the station's state say when there is something new.
    """
    with found():
        return services.motions.motion(robots.robot_of(services.session, id))


@router.get(
    "/robots/{id}/cameras/{camera}/look", summary="See what a camera saw last", dependencies=[needs(Role.VIEWER)]
)
def get_look(id: Id, camera: Id, services: ServicesDep) -> Look:  # noqa: A002
    """The last picture that something was to be made out in: as points in the map, with what was made out.

    The `looks` of the station's state say when there is a new one.
    """
    with found():
        return services.looks.look(robots.robot_of(services.session, id), camera)


@router.post("/robots/{id}/jog", status_code=202, summary="Move by hand", dependencies=[needs(Role.ENGINEER)])
def jog_robot(id: Id, request: Jog, services: ServicesDep, caller: CallerDep, response: Response) -> ModuleRunInfo:  # noqa: A002
    """Moves joints, tool, base or fingers by a little, where nothing is touched; follow the run that is answered.

    Refused (409) while anything is under way on that robot. Where the way is not free, the run fails and says why.
    """
    with found():
        robot = robots.robot_of(services.session, id)
    module, arguments = robots.jog(robot, request)
    return _start(services, id, module, arguments, caller.name, response)


@router.post("/robots/{id}/teach", status_code=202, summary="Teach here", dependencies=[needs(Role.ENGINEER)])
def teach_robot(id: Id, request: Teach, services: ServicesDep, caller: CallerDep, response: Response) -> ModuleRunInfo:  # noqa: A002
    """Has the robot learn from how it stands now: a grasp, where to stand at a place, how to put things down."""
    return _start(services, id, _LESSONS[request.what], request.arguments, caller.name, response)


@router.post("/robots/{id}/home", status_code=202, summary="Bring arms home", dependencies=[needs(Role.ENGINEER)])
def home_robot(
    id: Id,  # noqa: A002
    services: ServicesDep,
    caller: CallerDep,
    response: Response,
    request: Annotated[HomeRobot, Body()] = _ALL_ARMS,
) -> ModuleRunInfo:
    """Brings one arm or all into the travelling posture, around everything, and opens empty grippers."""
    arguments = {} if request.arm is None else {"arm": request.arm}
    return _start(services, id, "home", {"robot": id, **arguments}, caller.name, response)


def _start(
    services: Services, id_: str, module: str, arguments: Mapping[str, Any], by: str, response: Response
) -> ModuleRunInfo:
    with found():
        robots.robot_of(services.session, id_)
    run = services.control.call(
        lambda session: robots.start_by_hand(
            session, services.modules, robots.robot_of(session, id_), module, arguments, by
        )
    )
    response.headers["Location"] = location_of(run)
    return run_info(run)
