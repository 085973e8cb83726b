"""For those who keep the server running: its health and figures, not below ``/api/v1``, and its data directory."""

from __future__ import annotations

import shutil

from fastapi import APIRouter, Response
from prometheus_client import CONTENT_TYPE_LATEST, generate_latest

from skiros_py.api.server import Backup, BackupOrder, DataFinding, DataFindings, Health, Readiness
from skiros_py.server.access.audit import audit_findings
from skiros_py.server.access.roles import Admin, Anybody, Viewer
from skiros_py.server.problems import PROBLEMS, topic_router
from skiros_py.station.station import Station

router = APIRouter(tags=["operation"], generate_unique_id_function=lambda route: route.name)


@router.head("/healthz", include_in_schema=False)
@router.get("/healthz", responses={503: {"model": Health}})
async def get_health(act: Anybody) -> Health:
    """Check that the server is alive.

    Responds with 200 while the control cycle runs or the station is being opened, else with 503. Needs no key.
    """
    control, why = act.station.control, ""
    if control.fault is not None:
        why = "the station is not running: see the alarms"
    elif control.stuck_for() > _LONGEST_CYCLE:
        why = "the control cycle does not run"
    act.response.status_code = 503 if why else 200
    return Health(alive=not why, why=why)


_LONGEST_CYCLE = 5.0
"""Wall time without a control cycle after which the server counts as dead [s]."""


_LEAST_ROOM = 10 << 20
"""Room on the disk below which nothing is promised any more [bytes]."""


@router.head("/readyz", include_in_schema=False)
@router.get("/readyz", responses={503: {"model": Readiness}})
async def get_readiness(act: Anybody) -> Readiness:
    """Check that orders can be executed.

    Responds with 200 while the station runs, halted or not, and orders can be stored, else with 503. Needs no key.
    """
    why = _not_ready(act.station)
    act.response.status_code = 503 if why else 200
    return Readiness(ready=not why, halted=not why and bool(act.station.session.cycle.halted), why=why)


# Both are asynchronous: a health check must not wait for a place in the thread pool.


def _not_ready(station: Station) -> str:
    if not station.control.alive:
        return "the station is not open" if station.control.fault is None else "the station is not running"
    return "" if shutil.disk_usage(station.data).free > _LEAST_ROOM else "the disk is full: no order could be kept"


@router.get("/metrics", response_class=Response, responses=PROBLEMS)
def get_metrics(act: Viewer) -> Response:
    """Get the metrics for Prometheus.

    Returns the metrics of the server in the text format of Prometheus.
    """
    return Response(generate_latest(act.services.metrics.registry), media_type=CONTENT_TYPE_LATEST)


data_router = topic_router("operation", "/data")


@data_router.get("/findings")
def check_data(act: Admin) -> DataFindings:
    """Check the data directory.

    Reads every file of the data directory, changes nothing, and returns what is wrong, where, and what to do.
    """
    found = act.station.files.check(audit_findings)
    return DataFindings(items=[DataFinding.view_of(one) for one in found])


@data_router.post("/backups", status_code=201)
def back_up_data(act: Admin, order: BackupOrder) -> Backup:
    """Back up the data directory.

    Copies the data directory into its folder `backups`, as it is at one moment; the response is sent when it is done.

    The copy is a data directory, which is checked before it is made. Move it to another disk.
    """
    folder, files = act.station.files.back_up(order.name)
    names = [str(file.relative_to(folder)) for file in files]
    return Backup(folder=str(folder), files=names, bytes=sum(file.stat().st_size for file in files))
