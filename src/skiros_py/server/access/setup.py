"""Opens what the gate needs."""

from __future__ import annotations

from contextlib import ExitStack, closing
from pathlib import Path

from skiros_py.server.access.audit import AuditLog
from skiros_py.server.access.authenticator import Authenticator, check_access
from skiros_py.server.access.file import open_access
from skiros_py.server.access.keys import KeyStore
from skiros_py.server.settings import ServerSettings


def set_up_access(settings: ServerSettings, data: Path, stack: ExitStack) -> tuple[KeyStore, Authenticator, AuditLog]:
    """Opens the keys and the audit log of a data directory.

    Args:
        settings: How the server is set up.
        data: The data directory.
        stack: Closes them at the end.

    Raises:
        UsageError: Other machines could reach the server, and there is no key to come in with.
        FileError: The file cannot be opened or made, or is damaged.
    """
    keys = stack.enter_context(closing(KeyStore(data)))
    check_access(settings, keys)
    # A connection of its own: a request that asks for its key never waits for what is being written.
    audit = AuditLog(open_access(data), besides=keys.keep_uses)
    stack.callback(audit.close)
    audit.start()
    return keys, Authenticator(settings, keys), audit
