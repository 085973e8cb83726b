"""Arm motions in generated shelves, joint to joint and pose to pose, and inverse kinematics, beside other libraries.

Times are of the processor, in one run. Paths are judged by Coal at 1 mm on the meshes of the robot, sample by sample.
Peers come with the dependency group ``bench``; figures of one that is not installed are left out.
"""

from __future__ import annotations

import re
import sys
from argparse import ArgumentParser
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median, pstdev
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np
import pinocchio as pin
from arm_peers import installed, ompl_rrt_connect, ssik_branches, trac_ik
from shelves import GAP, MARGIN, Judge, Problem, problems
from table import Figure, duration, finish

from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.motion.pinocchio.arm_model import ArmModel, arm_model
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.motion.pinocchio.collision import CollisionScene, self_collision_pairs
from skiros_py.motion.pinocchio.kinematics import IkSolver
from skiros_py.motion.sampling import Est, Prm, RrtConnect
from skiros_py.plugins.loading import find_plugin
from skiros_py.ports.adapters import GivenPorts, InstalledPorts
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import GROUP, InverseKinematics
from skiros_py.ports.motion import Held, MotionPlan, MotionRequest, Obstacle, PoseMove, SamplingPlanner, SearchTask
from skiros_py.skills.cell_reader import read_cell
from skiros_py.station.worlds import open_world
from skiros_py.testing.conformance.cells import small_cell
from skiros_py.world.vocabulary import ROBOT

_RESTARTS = 50
_ALL = 10_000  # more solutions than any pose has
_SCENE = """@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
<https://w3id.org/skiros-py/scenes/alone> a owl:Ontology ; owl:imports <https://w3id.org/skiros-py/robots/{}> .
scene:floor_1 a sk:Floor . scene:unknown_location a sk:UnknownLocation .
"""


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """What became of one problem.

    Attributes:
        problem: The problem.
        planner: What found a motion; empty if nothing did.
        touched: What it touches by the judgement of Coal; empty for nothing.
        seconds: Time for the whole plan [s].
        first: Time to the first path of a search, reflexes before it included; None where there was no search [s].
        peer: Time of roboplan alone for the same search [s].
    """

    problem: Problem
    planner: str
    touched: str
    seconds: float
    first: float | None
    peer: float


class Watched:
    """A sampling planner that notes when it has found a path, and for what it was asked.

    Args:
        planner: The planner.
    """

    def __init__(self, planner: SamplingPlanner) -> None:
        self._planner = planner
        self.name = planner.name
        self.forget()

    def forget(self) -> None:
        """Forgets what it has noted."""
        self.found: float | None = None
        self.task: SearchTask | None = None

    def search(self, task: SearchTask) -> Sequence[Array] | None:
        """Searches."""
        path = self._planner.search(task)
        if self.found is None and path is not None:
            self.found, self.task = process_time(), task
        return path


def solve(motion: ArmMotion, watched: Watched, judge: Judge, problem: Problem, peer: SamplingPlanner | None) -> Solved:
    """Plans the motion of one problem, and judges it."""
    watched.forget()
    started = process_time()
    answer = motion.plan(problem.request(judge.arm))
    seconds = process_time() - started
    first = None if watched.found is None else watched.found - started
    planner, touched = "", ""
    if isinstance(answer, MotionPlan):
        planner, touched = answer.planners[0], judge.first_contact(answer.legs[0].positions, problem.obstacles)
    started = process_time()
    if peer is not None and watched.task is not None:
        peer.first_path(watched.task)  # type: ignore[attr-defined]
    said = touched or (planner and f"{planner}, {duration(seconds)}") or getattr(answer, "reason", "")
    print(f"shelf {problem.seed}, {problem.kind}: {said}", file=sys.stderr, flush=True)
    return Solved(problem, planner, touched, seconds, first, process_time() - started)


def shelf_figures(robot: RobotSpec, seeds: range, ompl_seconds: float) -> list[Figure]:
    """Plans motions in shelves."""
    drawn = list(problems(robot, seeds))
    watched, judge = Watched(_planner(robot, "rrt-connect")), Judge(robot)
    motion, peer = ArmMotion(robot, _ports(robot, watched)), _roboplan(robot)
    solved = [solve(motion, watched, judge, problem, peer) for problem in drawn]
    found = sum(bool(one.planner) for one in solved)
    touching = sum(bool(one.touched) for one in solved)
    figures = [_beside_ompl(robot, drawn, found, ompl_seconds)]
    figures.append(Figure("  of them touching something by Coal at 1 mm", str(touching), "0", not touching))
    for way in sorted({one.planner for one in solved}):
        count = sum(one.planner == way for one in solved)
        figures.append(Figure(f"  by {way or 'nothing'}", f"{count} of {len(solved)}"))
    for kind in ("joint", "pose"):
        times = [one.seconds for one in solved if one.problem.kind == kind]
        beside = _numeric_plans(robot, drawn) if kind == "pose" else ""
        figures.append(Figure(f"  whole plan, {kind} to {kind}, median", duration(median(times)), compared=beside))
    searched = [one for one in solved if one.problem.kind == "joint" and one.first is not None]
    first = median(one.first for one in searched if one.first is not None)
    what = "  first path, joint to joint, no reflex, median"
    if peer is None:
        return [*figures, Figure(what, duration(first), compared="roboplan is not installed")]
    theirs = median(one.peer for one in searched)
    said, beside = f"{duration(first)} = {first / theirs:.2f} x", f"roboplan alone {duration(theirs)}"
    return [*figures, Figure(what, said, "<= 1.5 x", first <= 1.5 * theirs, beside)]


def _numeric_plans(robot: RobotSpec, drawn: Sequence[Problem]) -> str:
    """Returns how long plans to poses take with the numeric inverse kinematics; nothing where that is used anyway."""
    numeric = IkSolver(arm_model(robot, robot.of(ArmSpec)[0]))
    if isinstance(_solver(robot), IkSolver):
        return ""
    motion, times, found = ArmMotion(robot, _ports(robot, _planner(robot, "rrt-connect"), numeric)), [], 0
    for problem in (problem for problem in drawn if problem.kind == "pose"):
        started = process_time()
        found += isinstance(motion.plan(problem.request(_arm(robot))), MotionPlan)
        times.append(process_time() - started)
    return f"with numeric inverse kinematics {duration(median(times))}, {found} of {len(times)}"


def _ports(robot: RobotSpec, planner: SamplingPlanner, solver: InverseKinematics | None = None) -> GivenPorts:
    return GivenPorts({InverseKinematics: solver or _solver(robot), SamplingPlanner: planner})


def _solver(robot: RobotSpec) -> InverseKinematics:
    return InstalledPorts((robot,)).port(InverseKinematics, _arm(robot))


def _arm(robot: RobotSpec) -> str:
    return robot.of(ArmSpec)[0].id


def _planner(robot: RobotSpec, name: str) -> SamplingPlanner:
    named = replace(robot, adapters=((_arm(robot), (name,)),))
    return InstalledPorts((named,)).port(SamplingPlanner, _arm(robot))


def _roboplan(robot: RobotSpec) -> SamplingPlanner | None:
    planner = _planner(robot, "rrt-connect")
    return planner if hasattr(planner, "first_path") else None


def sampler_table(robot: RobotSpec, seeds: range, count: int) -> None:
    """Prints success and spread of each sampling planner on the same problems, with and without reflexes.

    Args:
        robot: The robot.
        seeds: Seeds of shelf problems. A part is brought over a compartment of a kit, too.
        count: Number of seeds of each planner.
    """
    requests = {f"shelf {one.seed}, {one.kind}": one.request(_arm(robot)) for one in problems(robot, seeds)}
    requests["into a kit"] = _into_kit(robot)
    planners: dict[str, SamplingPlanner] = {"rrt-connect": _planner(robot, "rrt-connect")}
    planners |= {"rrt-connect in Python": RrtConnect(), "prm": Prm(), "est": Est()}
    motions = {name: ArmMotion(robot, _ports(robot, one), reflexes=False) for name, one in planners.items()}
    reflexes = ArmMotion(robot)
    row = "{:18}  {:22}  {:>9}  {:>15}  {:>15}  {}"
    print(row.format("problem", "planner", "found", "motion [s]", "time [s]", "with reflexes"))
    for name, request in requests.items():
        plan = reflexes.plan(request)
        reflex = plan.planners[0] if isinstance(plan, MotionPlan) else ""
        same = "the same" if reflex not in ("joint interpolation", "straight line") else f"{count} of {count}, {reflex}"
        for planner, motion in motions.items():
            lengths, times = [], []
            for seed in range(count):
                started = process_time()
                answer = motion.plan(replace(request, seed=seed))
                times.append(process_time() - started)
                if isinstance(answer, MotionPlan):
                    lengths.append((len(answer.legs[0].positions) - 1) / 200.0)
            ways, took = _spread(lengths), _spread(times)
            print(row.format(name, planner, f"{len(lengths)} of {count}", ways, took, same), flush=True)


def _spread(values: list[float]) -> str:
    return f"{median(values):.2f} ± {pstdev(values):.2f}" if values else "-"


def _into_kit(robot: RobotSpec) -> MotionRequest:
    """Returns the approach to a compartment of a kit on a table, with a part in the hand."""
    walls = [Primitive("box", (0.3, 0.006, 0.04), Pose((0.0, y, 0.02))) for y in (-0.147, 0.0, 0.147)]
    walls += [Primitive("box", (0.006, 0.3, 0.04), Pose((x, 0.0, 0.02))) for x in (-0.147, 0.0, 0.147)]
    table = Obstacle("table", Solid.box(0.6, 0.8, 0.5), Pose((0.78, 0.0, 0.0)))
    kit = Obstacle("kit", Solid(tuple(walls)), Pose((0.68, 0.0, 0.5)))
    part = Held(Solid.box(0.06, 0.04, 0.05), Pose.of(0.0, 0.0, 0.03, roll=np.pi))
    goal = PoseMove(Pose.of(0.753, 0.073, 0.58, roll=np.pi))
    home = robot.of(ArmSpec)[0].home
    return MotionRequest(_arm(robot), home, Pose(), ((goal,),), (table, kit), part, 0.04)


def _beside_ompl(robot: RobotSpec, drawn: list[Problem], found: int, seconds: float) -> Figure:
    what, said = "shelf problems solved", f"{found} of {len(drawn)}"
    if installed("ompl") is None:
        return Figure(what, said, compared="ompl is not installed")
    arm = arm_model(robot, robot.of(ArmSpec)[0])
    pairs, peers = self_collision_pairs(arm), 0
    for problem in drawn:
        checker = CollisionScene(arm, pairs, Pose(), problem.obstacles, None, GAP).checker(MARGIN)
        ends = problem.start, problem.goal
        peers += ompl_rrt_connect(checker, (arm.lower, arm.upper), ends, seconds)
    return Figure(what, said, f">= {peers}", found >= peers, f"OMPL's RRT-Connect in {seconds:g} s: {peers}")


def ik_figures(robot: RobotSpec, count: int) -> list[Figure]:
    """Solves poses that postures within the limits have, from the home posture."""
    spec = robot.of(ArmSpec)[0]
    arm = arm_model(robot, spec)
    rng, home = np.random.default_rng(77), np.array(spec.home)
    targets = [arm.tip_pose(rng.uniform(arm.lower, arm.upper)).homogeneous for _ in range(count)]
    solver, draws = _solver(robot), np.random.default_rng(0)

    def ours(target: Array, seed: Array) -> Array | None:
        tries = (
            solver.solve(target, seed if n == 0 else draws.uniform(arm.lower, arm.upper)) for n in range(_RESTARTS)
        )
        return next((found for found in tries if found is not None), None)

    solved, times = _timed(arm, targets, home, ours)
    share = solved / count
    figures = [Figure(f"inverse kinematics, {count} poses", f"{share:.1%}", ">= 99.8 %", share >= 0.998)]
    figures.append(Figure("  mean, 95 %", f"{duration(float(np.mean(times)))}, {duration(np.percentile(times, 95))}"))
    figures += _branch_figures(robot, targets)
    peer = trac_ik(robot, 0.05)
    if peer is None:
        return [*figures, Figure("  median", duration(median(times)), compared="pytracik is not installed")]
    theirs, peer_times = _timed(arm, targets, home, peer)
    ratio = median(times) / median(peer_times)
    beside = f"TRAC-IK {duration(median(peer_times))}, {theirs / count:.1%}"
    return [*figures, Figure("  median", f"{duration(median(times))} = {ratio:.2f} x", "<= 2 x", ratio <= 2.0, beside)]


def _branch_figures(robot: RobotSpec, targets: list[Array]) -> list[Figure]:
    """Finds all branches of poses; nothing for an arm that is solved numerically."""
    arm, solver, peer = arm_model(robot, robot.of(ArmSpec)[0]), _solver(robot), ssik_branches(robot)
    if isinstance(solver, IkSolver) or peer is None:
        return []
    home, limits, rng = np.array(arm.spec.home), (arm.lower, arm.upper), np.random.default_rng(0)
    numeric = IkSolver(arm)
    ways: tuple[Callable[[Array], Sequence[object]], ...] = (
        lambda target: solver.branches(target, home, limits, rng, count=_ALL),
        peer,
        lambda target: numeric.branches(target, home, limits, rng),
    )
    times: list[list[float]] = [[] for _ in ways]
    counts: list[list[int]] = [[] for _ in ways]
    for number, way in enumerate(ways):  # one after the other, each with its own code in the processor's cache
        for target in targets:
            started = process_time()
            found = way(target)
            times[number].append(process_time() - started)
            counts[number].append(len(found))
    (ours, theirs, slow), many = map(median, times), [f"{median(some):g}" for some in counts]
    beside = f"ssik {duration(theirs)}, {many[1]}; numeric {duration(slow)}, {many[2]}"
    figures = [Figure("  all branches, median number", many[0])]
    said = f"{duration(ours)} = {ours / theirs:.2f} x"
    return [*figures, Figure("  all branches, median", said, "<= 1 x", ours <= theirs, beside)]


def _timed(
    arm: ArmModel, targets: list[Array], home: Array, solve: Callable[[Array, Array], Array | None]
) -> tuple[int, list[float]]:
    """Returns how many poses are solved within 1 mm and 0.01 rad, within the limits, and the time for each [s]."""
    good, times = 0, []
    for target in targets:
        started = process_time()
        posture = solve(target, home)
        times.append(process_time() - started)
        if posture is not None:
            error = pin.log6(arm.tip_pose(np.asarray(posture)).actInv(pin.SE3(target))).vector
            near = np.linalg.norm(error[:3]) < 0.001 and np.linalg.norm(error[3:]) < 0.01
            good += bool(near and np.all(posture >= arm.lower - 1e-6) and np.all(posture <= arm.upper + 1e-6))
    return good, times


def _installed_robot(name: str) -> RobotSpec:
    """Returns a robot as its distribution describes it."""
    with TemporaryDirectory() as directory:
        scene, model = Path(directory) / "alone.ttl", find_plugin(GROUP, name, kind="robot model")
        bases = re.findall(r"^scene:(base\w*) a ", model.individuals.read_text(encoding="utf-8"), re.MULTILINE)
        starts = (f'scene:{base} sk:pose "0 0 0 0 0 0"^^sk:poseLiteral .\n' for base in bases)
        scene.write_text(_SCENE.format(name) + "".join(starts), encoding="utf-8")
        world = open_world(str(scene))
        return read_cell(world, world.instances(ROBOT)).robots[0]


def main() -> int:
    """Runs the campaign."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=40, help="number of shelf problems")
    parser.add_argument("--first", type=int, default=0, help="seed of the first one")
    parser.add_argument("--poses", type=int, default=1000, help="number of poses for inverse kinematics")
    parser.add_argument("--ompl-seconds", type=float, default=60.0, help="time that OMPL is given for a problem")
    parser.add_argument("--samplers", type=int, default=0, help="only show the planners, with as many seeds each")
    parser.add_argument("--robot", metavar="NAME", help="robot model that is installed (default: the built-in one)")
    arguments = parser.parse_args()
    robot = small_cell(cameras=False).robots[0] if arguments.robot is None else _installed_robot(arguments.robot)
    if arguments.samplers:
        sampler_table(robot, range(arguments.first, arguments.first + arguments.seeds), arguments.samplers)
        return 0
    figures = ik_figures(robot, arguments.poses)
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    return finish("arm motion", figures + shelf_figures(robot, seeds, arguments.ompl_seconds))


if __name__ == "__main__":
    sys.exit(main())
