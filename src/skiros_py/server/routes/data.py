"""Routes: the data directory, checked and copied while the server runs."""

from __future__ import annotations

from skiros_py.api.server import Backup, BackupOrder, DataFinding, DataFindings
from skiros_py.server.access.audit import audit_findings
from skiros_py.server.access.roles import Admin
from skiros_py.server.problems import topic_router

router = topic_router("operation", "/data")


@router.get("/findings")
def check_data(act: Admin) -> DataFindings:
    """Check the data directory.

    Reads every file of the data directory, changes nothing, and returns what is wrong, where, and what to do.
    """
    found = act.station.files.check(audit_findings)
    return DataFindings(items=[DataFinding.view_of(one) for one in found])


@router.post("/backups", status_code=201)
def back_up_data(act: Admin, order: BackupOrder) -> Backup:
    """Back up the data directory.

    Copies the data directory into its folder `backups`, as it is at one moment; the response is sent when it is done.

    The copy is a data directory, which is checked before it is made. Move it to another disk.
    """
    folder, files = act.station.files.back_up(order.name)
    names = [str(file.relative_to(folder)) for file in files]
    return Backup(folder=str(folder), files=names, bytes=sum(file.stat().st_size for file in files))
