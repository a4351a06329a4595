"""Fuzz plate files, which must be opened and have valid limits, or be rejected with a message."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from random import Random
from unittest import mock

from slipscale.faults import RigError, UserError
from slipscale.hardware import plate_file
from slipscale.hardware.calibration.record import to_toml
from slipscale.hardware.plate_file import Identity, Wiring, new_plate, open_plate_file, sign
from tests.fuzzing.calibrations import TODAY, whole_calibration
from tests.fuzzing.changes import changed_file
from tests.fuzzing.kind import Case, Kind

CALIBRATION = "calibration.toml"


def _prepared(folder: Path) -> Callable[[Random], Case]:
    (folder / CALIBRATION).write_text(to_toml(whole_calibration()), encoding="utf-8")
    path = folder / "plate.toml"
    new_plate(Identity(name="desk"), Wiring(backend="mock"), path)
    # Uncomment the examples of the optional parts, as a user would.
    text = re.sub(r"^# (?=\[|\w+ = )", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    path.write_text(text, encoding="utf-8")
    sign(path, today=TODAY)
    whole = path.read_text(encoding="utf-8")

    def drawn(random: Random) -> Case:
        content = changed_file(random, whole)
        how = random.choice(("as it is", "signed", "signed by a program"))
        return Case(name=path.name, content=content, use=lambda: _use(path, content, how))

    return drawn


def _use(path: Path, content: bytes, how: str) -> bool:
    path.write_bytes(content)
    checksum = plate_file.checksum if how != "signed by a program" else lambda _: mock.ANY
    try:
        if how == "signed":
            sign(path, beyond_by="a test", today=TODAY)
        with mock.patch.object(plate_file, "checksum", checksum):
            plate, calibration = open_plate_file(path)
            limits = plate.plate_limits()
            if calibration:
                calibration.narrow(limits)
    except (UserError, RigError) as error:
        return not str(error)
    if not (limits.level > 0 and plate.summary()):
        raise AssertionError(f"{limits}")
    return True


KIND = Kind(title="plate files", prepared=_prepared)
