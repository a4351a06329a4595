"""Write and read bundles: frozen plans as folders or zip files."""

from __future__ import annotations

import hashlib
import json
import shutil
import tempfile
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from slipscale.analysis.preregistration.manifest import FORMAT, MANIFEST, STUDY, Manifest
from slipscale.faults import UserError
from slipscale.faults.validation import faults_in, sentences

ZIP = ".zip"
#: Fixed date for zip entries, the earliest that the format supports.
NO_DATE = (1980, 1, 1, 0, 0, 0)
LARGEST_BYTES = 200_000_000
#: Files that file managers create in folders; they are ignored.
OF_THE_SYSTEM = (".DS_Store", "Thumbs.db", "desktop.ini")


@dataclass(frozen=True, slots=True, kw_only=True)
class Bundle:
    """A frozen plan, read from a folder or a zip file.

    Parameters
    ----------
    name : str
        Name of the file or folder.
    manifest : Manifest
        The manifest, with a verified digest.
    study_text : str
        Text of the study file, with a verified digest.
    damaged : tuple of str
        One sentence for each changed, removed or added file, except the manifest and the study
        file.
    """

    name: str
    manifest: Manifest
    study_text: str
    damaged: tuple[str, ...]


def sha256(content: bytes) -> str:
    """Return the SHA-256 of a file's content, in hexadecimal."""
    return hashlib.sha256(content).hexdigest()


def write_bundle(out: Path, files: Mapping[str, bytes]) -> None:
    """Write a bundle to a zip file if the name ends in ``.zip``, otherwise to a folder.

    Raises
    ------
    UserError
        If the bundle already exists, or cannot be written.
    """
    refuse_taken(out)
    # Written to a temporary folder and then moved, so that an error leaves no incomplete bundle.
    with tempfile.TemporaryDirectory(prefix="slipscale-") as temporary:
        unfinished = Path(temporary) / out.name
        _write(unfinished, files)
        try:
            out.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(unfinished, out)
        except OSError as error:
            raise UserError(
                "--out {out}: cannot be written ({reason})", out=out, reason=error.strerror
            ) from None


def _write(path: Path, files: Mapping[str, bytes]) -> None:
    if path.suffix == ZIP:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in sorted(files.items()):
                archive.writestr(zipfile.ZipInfo(name, NO_DATE), content)
        return
    for name, content in sorted(files.items()):
        file = path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)


def refuse_taken(out: Path) -> None:
    """Raise `UserError` if the path already exists: a plan is frozen only once."""
    if out.exists():
        raise UserError(
            "--out {out}: already exists; a plan is frozen only once, so choose a new name", out=out
        )


def read_bundle(path: Path) -> Bundle:
    """Return a frozen plan.

    Raises
    ------
    UserError
        If the path is not a bundle, the bundle is truncated, or its manifest or study was changed.
    """
    if not path.exists():
        raise UserError("--plan {path}: no such file or folder", path=path)
    files = _of_folder(path) if path.is_dir() else _of_zip(path)
    if MANIFEST not in files:
        raise UserError(
            "--plan {path}: not a bundle from slipscale study freeze; {manifest} is missing",
            path=path,
            manifest=MANIFEST,
        )
    manifest = _manifest(path, files.pop(MANIFEST))
    listed = {file.path: file.sha256 for file in manifest.files}
    if STUDY not in files or sha256(files[STUDY]) != listed.get(STUDY):
        raise UserError(
            "--plan {path}: {study} is missing or is not the frozen file (its SHA-256 differs),"
            " so nothing can be compared with the plan",
            path=path,
            study=STUDY,
        )
    return Bundle(
        name=path.name,
        manifest=manifest,
        study_text=files[STUDY].decode("utf-8"),
        damaged=(
            *(f"{name} is missing from the bundle." for name in listed if name not in files),
            *(
                f"{name} has changed since it was frozen: its SHA-256 differs."
                for name, content in files.items()
                if name in listed and sha256(content) != listed[name]
            ),
            *(f"{name} was added to the bundle." for name in files if name not in listed),
        ),
    )


def _manifest(path: Path, content: bytes) -> Manifest:
    try:
        manifest = json.loads(content)
        if isinstance(manifest, dict) and manifest.get("format", FORMAT) != FORMAT:
            raise UserError(
                "--plan {path}: its format is {format}, but this version of Slipscale reads "
                "format {known_format}",
                path=path,
                format=repr(manifest["format"]),
                known_format=FORMAT,
            )
        found = Manifest.model_validate(manifest)
    except (ValueError, RecursionError) as error:
        reason = "it is not JSON" if not isinstance(error, ValidationError) else _first(error)
        raise UserError(
            "--plan {path}: {manifest} was damaged or edited ({reason}); use the bundle that "
            "was deposited",
            path=path,
            manifest=MANIFEST,
            reason=reason,
        ) from None
    if found.computed_digest() != found.digest:
        raise UserError(
            "--plan {path}: {manifest} was edited after it was frozen (its SHA-256 differs from"
            " the one it states); use the bundle that was deposited",
            path=path,
            manifest=MANIFEST,
        )
    return found


def _first(error: ValidationError) -> str:
    return sentences(faults_in(error), lambda _: 0)[0].whole


def _of_folder(path: Path) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    try:
        for file in sorted(path.rglob("*")):
            if file.is_file() and file.name not in OF_THE_SYSTEM:
                name = file.relative_to(path).as_posix()
                _refuse_large(path, name, file.stat().st_size)
                found[name] = file.read_bytes()
    except OSError as error:
        raise UserError(
            "--plan {file}: {reason}", file=error.filename or path, reason=error.strerror
        ) from None
    return found


def _of_zip(path: Path) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    try:
        with zipfile.ZipFile(path) as archive:
            for entry in archive.infolist():
                if not entry.is_dir():
                    _refuse_large(path, entry.filename, entry.file_size)
                    found[entry.filename] = archive.read(entry)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise UserError(
            "--plan {path}: not a bundle, or truncated or damaged ({error}); expected a folder "
            "or a zip file from slipscale study freeze",
            path=path,
            error=error,
        ) from None
    except OSError as error:
        raise UserError(
            "--plan {path}: {reason}", path=path, reason=error.strerror or error
        ) from None
    return found


def _refuse_large(path: Path, name: str, size_bytes: int) -> None:
    if size_bytes > LARGEST_BYTES:
        raise UserError(
            "--plan {path}: {name} is too large for a file in a plan ({size_bytes} bytes)",
            path=path,
            name=name,
            size_bytes=size_bytes,
        )
