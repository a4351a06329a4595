"""The status line at the top of every page: laboratory, study, plate, session, disk and backup."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.hardware.address import is_mock

if TYPE_CHECKING:
    from slipscale.experiments.lab.console.page_texts import Words
    from slipscale.experiments.lab.console.state import Snapshot

LOW_GB = 1.0  # a run needs only a few megabytes, but a nearly full disk also causes other failures


def strip(found: Snapshot, t: Words, lab: str) -> list[tuple[str, str, str]]:
    """Return the status line's entries as (label, value, status) tuples."""
    live, status = found.live, found.live.status if found.live else None
    session = t("strip.running", label=live.label) if live else t("strip.none")
    if live and status and status.state in ("paused", "fault"):
        session += f" · {t(f'live.{status.state}')}"
    low = found.free_gb is not None and found.free_gb < LOW_GB
    missing = found.without_backup
    backup = t("strip.no_backup") if missing is None else t("strip.backed_up")
    return [
        ("laboratory", lab, ""),
        ("study", found.study.title if found.study else found.defaults.study, ""),
        ("plate", found.defaults.plate, "warn" if is_mock(found.defaults.plate) else ""),
        ("session", session, "bad" if status and status.state == "fault" else ""),
        (
            "disk",
            t("strip.free", gb=t.decimal(f"{found.free_gb}")) if found.free_gb else "–",
            "bad" * low,
        ),
        (
            "backup",
            t("strip.missing", count=missing) if missing else backup,
            "warn" * bool(missing),
        ),
    ]
