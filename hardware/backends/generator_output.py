"""Control one output of a function generator, with readback of all settings.

Generators have no watchdog. After the first contact, the output is assumed to be on until the
generator confirms that it is off. If the connection is lost, the driver tries several times to
reopen it and to switch the output off.

A reset, a preset or a key on the front panel can change fixed settings: a load setting of 50 Ω
doubles the voltage, and modulation halves it. The fixed settings are therefore verified before and
after each presentation.
"""

from __future__ import annotations

import math

from slipscale.hardware.backends.generator_dialects import (
    DIALECTS,
    KEYSIGHT,
    Dialect,
    FixedSetting,
    Item,
    VoltageRange,
    dialect_of,
    is_on,
    number,
    words_of,
)
from slipscale.hardware.backends.generator_line import Line
from slipscale.hardware.clock import Clock
from slipscale.hardware.errors import (
    GarbledReply,
    PlateFault,
    PlateRefused,
    StillVibrating,
    WrongDevice,
)
from slipscale.hardware.records import PlateIdentity

AGREEMENT = 1e-3  # relative tolerance of settings that are read back
REOPENINGS, REOPENING_PAUSE_S = 3, 0.5  # attempts to switch the output off after a lost connection


class GeneratorOutput:
    """Output channel of a generator. Voltages are in V peak to peak at the generator.

    Parameters
    ----------
    line : Line
    channel : int
        Output channel, 1 or 2.
    chosen : Dialect or None
        Commands for this make of generator. If None, the make is identified with ``*IDN?``.
    """

    def __init__(self, line: Line, channel: int, chosen: Dialect | None) -> None:
        self.line = line
        self.channel = channel
        self.dialect = chosen or KEYSIGHT  # Set when the generator is identified.
        self._chosen = chosen
        self.range: VoltageRange | None = None  # of the identified model
        self._may_be_on = False  # until the generator is identified
        self._out_of_reach = False  # A failure to switch the output off was reported.

    def prepare(self, largest_vpp: float) -> PlateIdentity:
        """Identify the generator, switch its output off, and write the fixed settings.

        Parameters
        ----------
        largest_vpp : float
            Largest voltage that will be set; it determines the attenuator setting.

        Raises
        ------
        WrongDevice
            If no generator answers, or if its make is unknown.
        PlateRefused
            If the generator does not keep a setting.
        """
        identity = self.identify()
        found, made = self.dialect, self.dialect.range_of(identity.model)
        self.range, self._may_be_on = made, True
        self.switch_off()
        self.line.write("*CLS")
        for each in found.fixed:
            self.write(each.item, each.value)
            self._require(each)
        if found.attenuator:
            self.set(found.voltage_vpp, min(largest_vpp, made.largest_vpp))
            self.write(found.attenuator.item, found.attenuator.value)
            self._require(found.attenuator)
        self.set(found.voltage_vpp, made.smallest_vpp)
        self._no_errors()
        return identity

    def identify(self) -> PlateIdentity:
        """Ask for the make of the generator. Raises `WrongDevice` if it is unknown."""
        resource = self.line.resource
        fields = self.line.ask("*IDN?").split(",")
        if len(fields) != len(PlateIdentity.__slots__):
            raise WrongDevice(
                "{resource}: the device '{identity}' is not a generator",
                resource=resource,
                identity=",".join(fields),
                level_free=False,
            )
        found = self._chosen or dialect_of(fields[0], fields[1])
        if found is None:
            raise WrongDevice(
                "{resource}: '{manufacturer} {model}' is not a known generator; use dialect=... "
                "with one of: {dialects}",
                resource=resource,
                manufacturer=fields[0],
                model=fields[1],
                dialects=", ".join(DIALECTS),
            )
        self.dialect = found
        return PlateIdentity(
            manufacturer=fields[0], model=fields[1], serial=fields[2], firmware=fields[3]
        )

    @property
    def smallest_vpp(self) -> float:
        """Smallest voltage that the generator's model can output, in V peak to peak."""
        return (self.range or self.dialect.range_of("")).smallest_vpp

    def verify(self) -> None:
        """Check that all fixed settings are unchanged. Raises `PlateRefused`."""
        dialect = self.dialect
        for each in (*dialect.fixed, *([dialect.attenuator] if dialect.attenuator else [])):
            self._require(each)

    def _require(self, setting: FixedSetting) -> None:
        value = self._ask(setting.item)
        if not setting.holds(value):
            raise PlateRefused(
                "{resource}: {command} returns {value}, but {set_value} was set; the "
                "generator was reset, was changed at its front panel, or does not keep the "
                "setting",
                resource=self.line.resource,
                command=self._command(setting.item.ask),
                value=value,
                set_value=setting.value,
            )

    def switch_on(self) -> None:
        """Switch the output on."""
        self._may_be_on = True
        self.write(self.dialect.output, self.dialect.on)

    def switch_off(self) -> None:
        """Switch the output off, and check that it is off. Raises `PlateFault`."""
        self.write(self.dialect.output, self.dialect.off)
        if self.is_on():
            raise PlateRefused(
                "{resource}: the output is still on after it was switched off",
                resource=self.line.resource,
                level_free=True,
            )
        self._may_be_on = self._out_of_reach = False

    def end(self, machine: Clock) -> None:
        """Switch the output off if it may be on, and reopen the connection if necessary.

        Raises
        ------
        StillVibrating
            If the output could not be switched off even after the connection was reopened several
            times.
        """
        if not self.line.opened and not self._may_be_on:
            return
        try:
            self.switch_off()
        except PlateFault as fault:
            if not self._may_be_on:
                raise
            self._reopen_and_switch_off(fault, machine)

    def _reopen_and_switch_off(self, fault: PlateFault, machine: Clock) -> None:
        """Reopen the connection up to `REOPENINGS` times until the output is off."""
        reopenings = 1 if self._out_of_reach else REOPENINGS
        for attempt in range(reopenings):
            if attempt:
                machine.sleep(REOPENING_PAUSE_S)
            try:
                self.line.release()
                self.line.open()
                self.switch_off()
            except PlateFault:
                continue
            return
        self._out_of_reach, reason = True, fault.blinded().message
        raise StillVibrating(
            "{resource}: the output could not be switched off ({reason}; the connection was "
            "reopened {reopenings} times), so the plate may still vibrate",
            resource=self.line.resource,
            reason=reason,
            reopenings=reopenings,
        ) from fault

    def set(self, item: Item, value: float) -> None:
        """Write a setting, read it back, and raise any error that the generator reports."""
        self.write(item, f"{value:.6f}")
        self._no_errors()
        self.expect(item, value)

    def expect(self, item: Item, value: float) -> None:
        """Raise `PlateRefused` unless a setting has the expected value."""
        answer = self.number(item)
        step = self.range.resolution_vpp if self.range and item is self.dialect.voltage_vpp else 0.0
        if not math.isclose(answer, value, rel_tol=AGREEMENT, abs_tol=step):
            raise PlateRefused(
                "{resource}: {command} returns {answer:g}, but {value:g} was set",
                resource=self.line.resource,
                command=self._command(item.ask),
                answer=answer,
                value=value,
            )

    def is_on(self) -> bool:
        """Return whether the output is on."""
        value = self._ask(self.dialect.output)
        on = is_on(value)
        if on is None:
            raise GarbledReply(
                "{resource}: the answer '{value}' to {command} cannot be read",
                resource=self.line.resource,
                value=value,
                command=self._command(self.dialect.output.ask),
            )
        return on

    def number(self, item: Item) -> float:
        """Query a numeric setting."""
        text = self._ask(item)
        value = number(text)
        if math.isnan(value):
            raise GarbledReply(
                "{resource}: the answer '{text}' to {command} cannot be read",
                resource=self.line.resource,
                text=text,
                command=self._command(item.ask),
            )
        return value

    def write(self, item: Item, value: str) -> None:
        """Write a setting without checking the result."""
        self.line.write(self._command(item.write, value))

    def _ask(self, item: Item) -> str:
        query = self._command(item.ask)
        answer = self.line.ask(query)
        value = item.read(answer)
        if value is None:
            raise GarbledReply(
                "{resource}: the answer '{answer}' to {query} cannot be read",
                resource=self.line.resource,
                answer=answer,
                query=query,
            )
        return value

    def _no_errors(self) -> None:
        if self.dialect.error is None:
            return
        code, _, text = self.line.ask(self.dialect.error).partition(",")
        if code.strip("+ ") != "0":
            raise PlateRefused(
                "{resource}: the generator reports error {code}, {text}",
                resource=self.line.resource,
                code=code,
                text=text,
            )

    def _command(self, template: str, value: str = "") -> str:
        return template.format(value=value, **words_of(self.dialect, self.channel))
