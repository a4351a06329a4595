"""Cache finished shards in a folder, so that no shard is computed twice.

Each shard is written atomically to its own file, so a killed run leaves no incomplete files. The
file contains the shard's settings and a SHA-256 of the content. If a file was truncated, edited or
copied from another analysis, its shard is computed again.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

from slipscale.analysis.planning.power.outcome import Outcome
from slipscale.analysis.planning.power.shard import VERSION, Shard
from slipscale.faults import UserError

MARK = "slipscale-power.json"


class ShardCache:
    """Cache of finished shards in a folder.

    Parameters
    ----------
    folder : Path
        Cache folder, which is created if it does not exist.

    Raises
    ------
    UserError
        If the folder cannot be created or written, or contains the cache of another version.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        mark = folder / MARK
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if not mark.exists():
                _write(mark, json.dumps({"version": VERSION}))
            version: object = json.loads(mark.read_text(encoding="utf-8"))
        except OSError as error:
            raise UserError(
                "--cache {folder}: {reason}", folder=folder, reason=error.strerror
            ) from None
        except ValueError:
            version = None
        if version != {"version": VERSION}:
            raise UserError(
                "--cache {folder}: the folder contains shards from another version of "
                "Slipscale; expected a new folder, or a folder from this version",
                folder=folder,
            )

    def path(self, shard: Shard) -> Path:
        """Return the path of a shard's file."""
        return self.folder / f"{shard.digest}.json"

    def get(self, shard: Shard) -> Outcome | None:
        """Return the stored outcome of a shard, or None if its file is missing or invalid."""
        try:
            text = self.path(shard).read_text(encoding="utf-8")
            digest, _, body = text.partition("\n")
            if hashlib.sha256(body.encode()).hexdigest() != digest:
                return None
            data = json.loads(body)
            if data["shard"] != json.loads(json.dumps(shard.identity)):
                return None
            return Outcome.from_json(data["outcome"])
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def put(self, shard: Shard, outcome: Outcome) -> None:
        """Store the outcome of a shard.

        Raises
        ------
        UserError
            If the file cannot be written.
        """
        body = json.dumps({"shard": shard.identity, "outcome": outcome.as_json()}, indent=1)
        try:
            _write(self.path(shard), f"{hashlib.sha256(body.encode()).hexdigest()}\n{body}")
        except OSError as error:
            raise UserError(
                "--cache {folder}: cannot be written ({reason}); the existing shards are "
                "complete: free some space and run the same command again",
                folder=self.folder,
                reason=error.strerror,
            ) from None


def _write(path: Path, text: str) -> None:
    """Write a file atomically."""
    unfinished = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        unfinished.write_text(text, encoding="utf-8")
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
