"""The sources of position and force of a run: which, opened, and told in its journal."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from slipscale.faults import UserError
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.contact.registry import NONE, open_source
from slipscale.hardware.contact.source import QUANTITIES, Surroundings

if TYPE_CHECKING:
    from collections.abc import Mapping

    from slipscale.experiments.journal.record import Record
    from slipscale.experiments.study.model import Study
    from slipscale.hardware.contact.source import ContactSource, Kind
    from slipscale.hardware.driver import PlateDriver
    from slipscale.hardware.plate_file import PlateFile

SIMULATED = "simulated"
NEED_A_PARTICIPANT = ("mouse", SIMULATED)
TRIED_S = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactSpecs:
    """Which sources a run uses.

    Parameters
    ----------
    position, force : str or None
        A SPEC; "none" for no source; None where nobody said so.
    """

    position: str | None = None
    force: str | None = None

    def otherwise(self, other: ContactSpecs) -> ContactSpecs:
        """Return these, and another's where nobody said."""
        return ContactSpecs(
            position=other.position if self.position is None else self.position,
            force=other.force if self.force is None else self.force,
        )

    @property
    def used(self) -> dict[Kind, str]:
        """The SPECs of the sources that there are."""
        both: dict[Kind, str | None] = {"position": self.position, "force": self.force}
        return {kind: spec for kind, spec in both.items() if spec and spec != NONE}


NOT_NAMED = ContactSpecs()


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedSource:
    """A source and the SPEC that it was opened by."""

    spec: str
    source: ContactSource


def of_study(study: Study) -> ContactSpecs:
    """Return the sources that a study names."""
    return ContactSpecs(position=study.plate.position or None, force=study.plate.force or None)


def of_plate(file: PlateFile | None) -> ContactSpecs:
    """Return the sources that a plate's file names."""
    wiring = file.wiring if file else None
    return ContactSpecs(position=wiring.position, force=wiring.force) if wiring else NOT_NAMED


def simulated(specs: ContactSpecs) -> ContactSpecs:
    """Return the simulated sources in place of the named ones that measure.

    Raises
    ------
    UserError
        One names a device that is no simulated finger's.
    """
    found: dict[Kind, str] = {}
    for kind, spec in specs.used.items():
        name = spec.partition(":")[0]
        found[kind] = spec if name in (SIMULATED, "scripted") else SIMULATED
    return ContactSpecs(position=found.get("position"), force=found.get("force"))


def of_records(records: list[Record]) -> ContactSpecs:
    """Return the sources that a run was last on."""
    last = [r.data for r in records if r.kind in ("header", "resume")][-1]
    told = last.get("contact") or {}
    specs = {kind: str(told[kind]["spec"]) if kind in told else NONE for kind in QUANTITIES}
    return ContactSpecs(position=specs["position"], force=specs["force"])


def open_sources(
    specs: ContactSpecs, surroundings: Surroundings, stack: ExitStack
) -> dict[Kind, NamedSource]:
    """Return the sources, connected until the stack closes.

    Raises
    ------
    UserError
        A SPEC is wrong, or names a source that does not work here.
    SensorFault
        A device does not answer.
    """
    opened: dict[Kind, NamedSource] = {}
    for kind, spec in specs.used.items():
        source = stack.enter_context(open_source(kind, spec, surroundings))
        opened[kind] = NamedSource(spec=spec, source=source)
    return opened


def try_sources(specs: ContactSpecs, seed: int) -> list[str]:
    """Connect the sources, look for a while at what they tell, and say so, a sentence each."""
    # The window's pointer is there when the window is; a simulated finger with its participant.
    later = {k: s for k, s in specs.used.items() if s.partition(":")[0] in NEED_A_PARTICIPANT}
    now = ContactSpecs(
        position=NONE if "position" in later else specs.position,
        force=NONE if "force" in later else specs.force,
    )
    clock = SystemClock()
    with ExitStack() as stack:
        opened = open_sources(now, Surroundings(clock=clock, seed=seed), stack)
        for each in opened.values():
            each.source.begin()
        clock.sleep(TRIED_S)
        told = [f"{kind}: {_readings(each.source)}" for kind, each in opened.items()]
    return told + [f"{kind}: {spec}, not to be tried without a session" for kind, spec in
                   later.items()]  # fmt: skip


def _readings(source: ContactSource) -> str:
    """Return how often a source was read, and its last reading."""
    samples = source.take()
    if not samples:
        return "no finger on the plate"
    pairs = zip(source.quantities, samples[-1].values, strict=True)
    last = ", ".join(f"{name} {value:.3g}" for name, value in pairs)
    return f"{len(samples) / TRIED_S:.0f} readings a second, the last {last}"


def require_virtual(specs: ContactSpecs) -> None:
    """Raise `UserError` unless the sources named on a pilot's command line are simulated."""
    for kind, spec in specs.used.items():
        if spec.partition(":")[0] not in (SIMULATED, "scripted"):
            raise UserError(f"--{kind} {spec}: a pilot runs in virtual time; expected {SIMULATED}")


def describe_contact(sources: Mapping[Kind, NamedSource], plate: PlateDriver) -> dict[str, Any]:
    """Return what the journal says of the sources; nothing where there are none."""
    if not sources:
        return {}
    told: dict[str, Any] = {
        kind: {"spec": each.spec, **each.source.describe()} for kind, each in sources.items()
    }
    if "position" in sources:
        follows = plate.follow_lag_s is not None
        told["textures"] = "follow the finger" if follows else "for an assumed speed"
        told["texture_lag_s"] = plate.follow_lag_s
    return {"contact": told}
