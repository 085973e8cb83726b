"""Claims about inverse kinematics in closed form."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Array, Pose
from skiros_py.motion.pinocchio.analytic import AnalyticKinematics, analytic_kinematics
from skiros_py.motion.pinocchio.arm_model import RevoluteChain, arm_model
from skiros_py.motion.pinocchio.kinematics import IkSolver
from skiros_py.ports.adapters import InstalledPorts
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import InverseKinematics

X, Y, Z = np.eye(3)
SHAPES = {
    # axes, and where each joint is seen from the one before: a random length along x, y and z where it is not zero
    "three parallel joints": ((Z, Y, Y, Y, Z, Y), ("z", "y", "xz", "xz", "yz", "yz"), "yz"),
    "spherical wrist": ((Z, Y, Y, X, Y, X), ("z", "x", "z", "xz", "", ""), "x"),
    "spherical shoulder and wrist": ((Z, Y, Z, Y, Z, Y, Z), ("z", "", "", "z", "", "z", ""), "z"),
    "spherical shoulder": ((Z, Y, Z, -Y, Z, -Y, -Z), ("z", "", "z", "x", "-xz", "", "x"), "z"),
}
WIDE = 2.0 * np.pi


class Never(InverseKinematics):
    """A numeric search that finds nothing."""

    def __init__(self) -> None:
        self.asked = 0

    def solve(self, target: Array, seed: Array, **_options: object) -> Array | None:
        self.asked += 1
        return None


def shifted(along: str, lengths: list[float]) -> Array:
    """Returns a translation."""
    step = {axis: length for axis, length in zip("xyz", lengths, strict=True) if axis in along}
    sign = -1.0 if along.startswith("-") else 1.0
    return Pose((sign * step.get("x", 0.0), step.get("y", 0.0), step.get("z", 0.0))).matrix()


@st.composite
def chains(draw: st.DrawFn) -> RevoluteChain:
    """Draws an arm of one of the usual kinds, of any lengths, standing anywhere, with a tip turned anyhow."""
    axes, places, tool = SHAPES[draw(st.sampled_from(sorted(SHAPES)))]
    length, angle = st.floats(0.1, 0.5).map(lambda x: round(x, 3)), st.floats(-3.0, 3.0)
    some = [draw(length) for _ in range(3)]
    placements = []
    for along in places:
        # what goes back along x is what went there before: such elbows are symmetric
        some = some if along.startswith("-") else [draw(length) for _ in range(3)]
        placements.append(shifted(along, some))
    placements[0] = Pose.of(draw(length), draw(length), 0.0, yaw=draw(angle)).matrix() @ placements[0]
    turned = Pose.of(0.0, 0.0, 0.0, roll=draw(angle), pitch=draw(st.floats(-1.5, 1.5))).matrix()
    placements.append(shifted(tool, [draw(length) for _ in range(3)]) @ turned)
    upper = np.array([draw(st.sampled_from([2.5, 3.1])) for _ in axes])
    upper[draw(st.integers(0, len(axes) - 1))] = WIDE  # one joint that turns twice: every one doubles the solutions
    return RevoluteChain(np.array(placements), np.array(axes), -upper, upper)


def tip(chain: RevoluteChain, q: Array) -> Array:
    """Returns the pose of the tip, by Rodrigues' formula."""
    pose = np.eye(4)
    for placement, axis, angle in zip(chain.placements, chain.axes, q, strict=False):
        cross, turned = np.cross(np.eye(3), axis), np.eye(4)
        turned[:3, :3] = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
        pose = pose @ placement @ turned
    return pose @ chain.placements[-1]


def known(chain: RevoluteChain, seed: int) -> Array:
    """Returns joint angles within the limits."""
    return np.random.default_rng(seed).uniform(0.95 * chain.lower, 0.95 * chain.upper)


def solver_of(chain: RevoluteChain) -> AnalyticKinematics:
    solver = analytic_kinematics(chain, Never())
    assert solver is not None
    return solver


def branches(
    solver: InverseKinematics, chain: RevoluteChain, target: Array, reference: Array, count: int
) -> list[Array]:
    return solver.branches(target, reference, (chain.lower, chain.upper), np.random.default_rng(0), count=count)


many = settings(max_examples=40, deadline=None, phases=(Phase.explicit, Phase.reuse, Phase.generate, Phase.shrink))


@many
@given(chains(), st.integers(0, 1000))
def test_all_branches_reach_the_pose_within_the_limits_and_are_distinct(chain: RevoluteChain, seed: int) -> None:
    q = known(chain, seed)

    found = branches(solver_of(chain), chain, tip(chain, q), np.zeros(len(q)), 10_000)

    assert found
    assert max(np.abs(tip(chain, one) - tip(chain, q)).max() for one in found[::7]) < 1e-5
    assert (chain.lower <= found).all()
    assert (found <= chain.upper).all()
    assert min((np.abs(found[n + 1 :] - one).max(axis=1).min() for n, one in enumerate(found[:-1])), default=1.0) > 1e-4
    away = [float(np.linalg.norm(one)) for one in found]
    assert away == sorted(away)


@many
@given(chains(), st.integers(0, 1000))
def test_the_known_joint_angles_of_six_joints_are_among_all_branches(chain: RevoluteChain, seed: int) -> None:
    assume(len(chain.axes) == 6)
    q = known(chain, seed)
    assume(all(abs(np.sin(q[joint])) > 0.05 for joint in (2, 4)))  # stretched arm or wrist: a continuum

    found = branches(solver_of(chain), chain, tip(chain, q), q, 10_000)

    assert np.abs(found[0] - q).max() < 1e-4


@many
@given(chains(), st.integers(0, 1000), st.integers(1, 8))
def test_of_all_branches_a_number_is_taken_the_nearest_one_first(chain: RevoluteChain, seed: int, count: int) -> None:
    q, solver = known(chain, seed), solver_of(chain)
    reference = known(chain, seed + 1)
    every = branches(solver, chain, tip(chain, q), reference, 10_000)

    some = branches(solver, chain, tip(chain, q), reference, count)

    assert 1 <= len(some) <= count
    np.testing.assert_array_equal(some[0], every[0])
    assert all(any(np.array_equal(one, other) for other in every) for one in some)
    again = branches(solver_of(chain), chain, tip(chain, q), reference, count)
    np.testing.assert_array_equal(some, again)


def test_joints_that_turn_twice_have_all_windings() -> None:
    chain = arm_of("three parallel joints", WIDE)
    q = np.array([0.3, -1.0, 1.2, 0.4, 0.9, -0.5])

    found = branches(solver_of(chain), chain, tip(chain, q), q - WIDE * (q > 0.0), 10_000)

    wound = q - WIDE * (q > 0.0)
    np.testing.assert_allclose(found[0], wound, atol=1e-6)
    assert len(found) % 2**6 == 0


def test_tighter_limits_than_those_of_the_arm_are_kept() -> None:
    chain = arm_of("three parallel joints", 3.1)
    q = np.array([0.3, -1.0, 1.2, 0.4, 0.9, -0.5])
    limits = q - 0.5, q + 0.5

    found = solver_of(chain).branches(tip(chain, q), q, limits, np.random.default_rng(0), count=100)

    assert len(found) == 1
    np.testing.assert_allclose(found[0], q, atol=1e-6)


def test_a_pose_without_a_solution_in_closed_form_is_left_to_the_numeric_search() -> None:
    chain, never = arm_of("spherical wrist", 3.1), Never()
    solver = analytic_kinematics(chain, never)
    assert solver is not None
    away = Pose((9.0, 0.0, 0.0)).matrix()

    assert branches(solver, chain, away, np.zeros(6), 6) == []
    assert never.asked == 50


def test_an_arm_without_a_closed_form_has_none() -> None:
    chain = arm_of("spherical wrist", 3.1)
    bent = RevoluteChain(
        chain.placements @ Pose.of(0.01, 0.02, 0.03, roll=0.3, pitch=0.2).matrix(), chain.axes, chain.lower, chain.upper
    )
    short = RevoluteChain(chain.placements[1:], chain.axes[1:], chain.lower[1:], chain.upper[1:])

    assert analytic_kinematics(None, Never()) is None
    assert analytic_kinematics(bent, Never()) is None
    assert analytic_kinematics(short, Never()) is None


def test_what_is_worked_out_is_kept_and_worked_out_again_if_the_file_is_damaged(tmp_path: Path) -> None:
    chain = arm_of("spherical shoulder", 2.5)
    q = known(chain, 3)
    first = analytic_kinematics(chain, Never(), tmp_path)
    (file,) = tmp_path.iterdir()
    written = file.stat().st_mtime_ns
    kept = analytic_kinematics(chain, Never(), tmp_path)
    assert file.stat().st_mtime_ns == written
    file.write_bytes(b"no numbers")
    damaged = analytic_kinematics(chain, Never(), tmp_path)

    assert first is not None
    for one in (kept, damaged):
        assert one is not None
        np.testing.assert_array_equal(one.all_branches(tip(chain, q)), first.all_branches(tip(chain, q)))


def test_the_built_in_arm_is_solved_in_its_own_frames(robot: RobotSpec) -> None:
    arm = arm_model(robot, robot.of(ArmSpec)[0])
    assert arm.chain is not None
    solver = analytic_kinematics(arm.chain, IkSolver(arm))
    assert solver is not None
    rng, missed, worst = np.random.default_rng(5), 0, 0.0
    for _ in range(1000):
        target = arm.tip_pose(rng.uniform(arm.lower, arm.upper)).homogeneous
        found = solver.all_branches(target)
        missed += not len(found)
        worst = max([worst, *(np.abs(arm.tip_pose(np.array(q)).homogeneous - target).max() for q in found)])

    assert missed == 0
    assert worst < 1e-6


@pytest.mark.parametrize(
    ("named", "kind"),
    [((), IkSolver), ((("arm", ("analytic-kinematics",)),), AnalyticKinematics)],
    ids=["any", "named"],
)
def test_the_closed_form_is_used_by_arms_that_name_it(
    robot: RobotSpec, named: tuple[tuple[str, tuple[str, ...]], ...], kind: type
) -> None:
    asked = replace(robot, adapters=named)

    assert isinstance(InstalledPorts((asked,)).port(InverseKinematics, "arm"), kind)


def arm_of(shape: str, turn: float) -> RevoluteChain:
    """Returns an arm of one kind with lengths that are all different."""
    axes, places, tool = SHAPES[shape]
    lengths = [[0.11 + 0.03 * n, 0.13 + 0.02 * n, 0.4 - 0.02 * n] for n in range(len(places) + 1)]
    if "-xz" in places:
        lengths[places.index("-xz")][0] = lengths[places.index("-xz") - 1][0]
    placements = [shifted(along, some) for along, some in zip((*places, tool), lengths, strict=True)]
    upper = np.full(len(axes), turn)
    return RevoluteChain(np.array(placements), np.array(axes), -upper, upper)
