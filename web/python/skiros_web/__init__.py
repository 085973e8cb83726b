"""The web user interface of skiros-py, as built pages: the server finds them by their entry point."""

import os
from pathlib import Path

__all__ = ["PAGES"]

PAGES = Path(os.environ.get("SKIROS_WEB_PAGES") or Path(__file__).parent / "pages")
"""Folder of the built pages: ``index.html``, ``assets/`` and their compressed neighbours.

Who works on them has another build tried by naming its folder in ``SKIROS_WEB_PAGES``.
"""
