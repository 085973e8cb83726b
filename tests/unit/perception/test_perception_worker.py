"""The ports, answered by the worker process."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

from skiros_py.geometry import Pose
from skiros_py.perception.detector import detect
from skiros_py.perception.registration import register
from skiros_py.perception.worker import Open3dPerception
from skiros_py.ports.perception import Region, RegistrationRequest

if TYPE_CHECKING:
    from conftest import Studio


@pytest.fixture(scope="module")
def perception() -> Iterator[Open3dPerception]:
    perception = Open3dPerception()
    yield perception
    perception.close()


def test_importing_the_package_does_not_import_open3d() -> None:
    code = "import sys, skiros_py.perception.worker; sys.exit('open3d' in sys.modules)"

    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_worker_needs_no_viewer_and_no_machine_learning() -> None:
    code = (
        "import sys, skiros_py.perception.detector, skiros_py.perception.registration; "
        "assert not {'dash', 'plotly', 'sklearn', 'pandas', 'open3d'} & sys.modules.keys()"
    )

    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_plugin_in_the_same_process_has_all_of_open3d_and_the_same_types() -> None:
    code = (
        "from skiros_py.open3d import pybind\n"
        "import open3d\n"
        "assert open3d.geometry.PointCloud is pybind.geometry.PointCloud\n"
        "assert open3d.visualization.draw_plotly and open3d.ml\n"
    )

    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_worker_answers_what_the_functions_answer_after_the_declared_latency(
    studio: Studio, perception: Open3dPerception
) -> None:
    camera, rng = studio.over(0.0, 0.0, 0.94), np.random.default_rng(1)
    kit, guess = Pose.of(0.0, 0.0, 0.5, yaw=0.1), Pose.of(0.01, 0.01, 0.5)
    look = studio.look(
        [studio.table(0.5), studio.part("Starter", 0.03, 0.06, 0.5, 1.0)],
        camera,
        Region(Pose.of(0.0, 0.0, 0.5), (0.13, 0.20)),
        rng,
    )
    registration = RegistrationRequest(
        studio.shoot([studio.table(0.5), (studio.kit, kit)], camera, rng), camera, studio.kit, guess
    )

    seen = perception.detect(look)
    registered = perception.register(registration)

    assert seen.latency == registered.latency == pytest.approx(0.15)
    assert seen.result() == detect(look)
    assert registered.result() == register(registration)
