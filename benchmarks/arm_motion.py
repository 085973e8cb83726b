"""Arm motions in generated shelves, joint to joint and pose to pose, and inverse kinematics, beside other libraries.

Times are of the processor, in one run. Paths are judged by Coal at 1 mm on the meshes of the robot, sample by sample.
Peers come with the dependency group ``bench``; figures of one that is not installed are left out.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import process_time

import numpy as np
import pinocchio as pin
from arm_peers import installed, ompl_rrt_connect, trac_ik
from shelves import GAP, MARGIN, Judge, Problem, problems
from table import Figure, duration, finish

from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Array, Pose
from skiros_py.motion.pinocchio.arm_model import ArmModel, arm_model
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.motion.pinocchio.collision import CollisionScene, self_collision_pairs
from skiros_py.motion.pinocchio.kinematics import IkSolver
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import MotionPlan
from skiros_py.testing.conformance.cells import small_cell

_RESTARTS = 50


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """What became of one problem.

    Attributes:
        problem: The problem.
        found: Whether a motion was found.
        touched: What it touches by the judgement of Coal; empty for nothing.
        seconds: Time for the whole plan [s].
    """

    problem: Problem
    found: bool
    touched: str
    seconds: float


def solve(motion: ArmMotion, judge: Judge, problem: Problem, arm: str) -> Solved:
    """Plans the motion of one problem, and judges it."""
    started = process_time()
    answer = motion.plan(problem.request(arm))
    seconds = process_time() - started
    found = isinstance(answer, MotionPlan)
    touched = judge.first_contact(answer.legs[0].positions, problem.obstacles) if isinstance(answer, MotionPlan) else ""
    said = touched or (f"found in {duration(seconds)}" if isinstance(answer, MotionPlan) else answer.reason)
    print(f"shelf {problem.seed}, {problem.kind}: {said}", file=sys.stderr, flush=True)
    return Solved(problem, found, touched, seconds)


def shelf_figures(robot: RobotSpec, seeds: range, ompl_seconds: float) -> list[Figure]:
    """Plans motions in shelves."""
    drawn = list(problems(robot, seeds))
    motion, judge, arm = ArmMotion(robot), Judge(robot), robot.of(ArmSpec)[0]
    solved = [solve(motion, judge, problem, arm.id) for problem in drawn]
    found = sum(one.found for one in solved)
    touching = sum(bool(one.touched) for one in solved)
    figures = [_beside_ompl(robot, drawn, found, ompl_seconds)]
    figures.append(Figure("  of them touching something by Coal at 1 mm", str(touching), "0", not touching))
    figures.append(Figure("  whole plan, median", duration(median(one.seconds for one in solved))))
    return figures


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
    solver, draws = IkSolver(arm), np.random.default_rng(0)

    def ours(target: Array, seed: Array) -> Array | None:
        tries = (
            solver.solve(target, seed if n == 0 else draws.uniform(arm.lower, arm.upper)) for n in range(_RESTARTS)
        )
        return next((found for found in tries if found is not None), None)

    solved, times = _timed(arm, targets, home, ours)
    share = solved / count
    figures = [Figure(f"inverse kinematics, {count} poses", f"{share:.1%}", ">= 99.8 %", share >= 0.998)]
    figures.append(Figure("  mean, 95 %", f"{duration(float(np.mean(times)))}, {duration(np.percentile(times, 95))}"))
    peer = trac_ik(robot, 0.05)
    if peer is None:
        return [*figures, Figure("  median", duration(median(times)), compared="pytracik is not installed")]
    theirs, peer_times = _timed(arm, targets, home, peer)
    ratio = median(times) / median(peer_times)
    beside = f"TRAC-IK {duration(median(peer_times))}, {theirs / count:.1%}"
    return [*figures, Figure("  median", f"{duration(median(times))} = {ratio:.2f} x", "<= 2 x", ratio <= 2.0, beside)]


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


def main() -> int:
    """Runs the campaign."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=40, help="number of shelf problems")
    parser.add_argument("--first", type=int, default=0, help="seed of the first one")
    parser.add_argument("--poses", type=int, default=1000, help="number of poses for inverse kinematics")
    parser.add_argument("--ompl-seconds", type=float, default=60.0, help="time that OMPL is given for a problem")
    arguments = parser.parse_args()
    robot = small_cell(cameras=False).robots[0]
    figures = ik_figures(robot, arguments.poses)
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    return finish("arm motion", figures + shelf_figures(robot, seeds, arguments.ompl_seconds))


if __name__ == "__main__":
    sys.exit(main())
