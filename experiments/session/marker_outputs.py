"""Marker outputs: Lab Streaming Layer, serial trigger boxes and parallel ports.

Tested with a Lab Streaming Layer receiver, a pseudo-terminal and a simulated port, but not yet with
a real trigger box or parallel port.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from slipscale.experiments.session.markers import Event, MarkerOutput, Markers
from slipscale.faults import UserError
from slipscale.faults.extras import how_to_install

# A recorder that samples at 500 Hz captures a 5 ms pulse in two samples.
PULSE_S = 0.005
STREAM = "Slipscale"
# By default, liblsl prints its sockets in the operator's terminal. Level -1 shows only warnings and
# errors.
QUIET = "[log]\nlevel = -1\n"


class LabStream:
    """A Lab Streaming Layer marker stream with two channels: the event name and the trial.

    Parameters
    ----------
    argument : str
        The stream name; an empty string selects the default, `STREAM`.
    """

    def __init__(self, argument: str) -> None:
        try:
            import pylsl
        except ImportError:
            raise UserError("--markers lsl: {remedy}", remedy=how_to_install("pylsl")) from None
        except (RuntimeError, OSError) as error:
            raise UserError(
                "--markers lsl: liblsl cannot be loaded ({error})", error=error
            ) from None
        with suppress(AttributeError, RuntimeError):  # pylsl or liblsl before 1.17
            pylsl.set_config_content(QUIET)
        stream = argument or STREAM
        self.name = f"lsl:{stream}"
        info = pylsl.StreamInfo(
            stream, "Markers", 2, pylsl.IRREGULAR_RATE, pylsl.cf_string, f"slipscale-{stream}"
        )
        channels = info.desc().append_child("channels")
        for label in ("event", "trial"):
            channels.append_child("channel").append_child_value("label", label)
        self._outlet: Any = pylsl.StreamOutlet(info)

    def send(self, event: Event, trial: int | None) -> None:
        """Push one sample. Its trial field is empty between trials."""
        self._outlet.push_sample([event.name.lower(), "" if trial is None else str(trial)])

    def close(self) -> None:
        """Close the stream."""
        self._outlet = None


class SerialTrigger:
    """A serial trigger box, to which each event code is sent as one byte, followed by a zero byte.

    Parameters
    ----------
    argument : str
        The port.
    """

    def __init__(self, argument: str) -> None:
        import serial

        self.name = f"serial:{argument}"
        try:
            self._line = serial.Serial(argument, 115_200, write_timeout=0.1)
        except (OSError, ValueError) as error:
            raise UserError(
                "--markers {name}: cannot be opened ({error}); expected serial:PORT, a trigger "
                "box that no other program uses",
                name=self.name,
                error=error,
            ) from None

    def send(self, event: Event, _trial: int | None) -> None:
        """Send one pulse of 5 ms, and wait until it is over."""
        self._line.write(bytes([event]))
        time.sleep(PULSE_S)
        self._line.write(b"\x00")

    def close(self) -> None:
        """Set all output lines to zero and close the port."""
        with suppress(OSError):
            self._line.write(b"\x00")
        self._line.close()


class ParallelTrigger:
    """A parallel port, whose eight data pins are set using PsychoPy.

    Parameters
    ----------
    argument : str
        The port address in PsychoPy's notation: ``0x378``, ``/dev/parport0``.
    """

    def __init__(self, argument: str) -> None:
        self.name = f"parallel:{argument}"
        wanted: str | int = argument
        with suppress(ValueError):
            wanted = int(argument, 0)
        try:
            from psychopy.parallel import ParallelPort

            self._port: Any = ParallelPort(wanted)
            self._port.setData(0)
        except Exception as error:  # noqa: BLE001 - each system's driver raises its own errors
            raise UserError(
                "--markers {name}: cannot be opened ({error}); expected parallel:ADDRESS, such "
                "as parallel:0x378 or parallel:/dev/parport0",
                name=self.name,
                error=error,
            ) from None

    def send(self, event: Event, _trial: int | None) -> None:
        """Send one pulse of 5 ms, and wait until it is over."""
        self._port.setData(int(event))
        time.sleep(PULSE_S)
        self._port.setData(0)

    def close(self) -> None:
        """Set all pins to zero."""
        with suppress(OSError):
            self._port.setData(0)


OUTPUTS: dict[str, Callable[[str], MarkerOutput]] = {
    "lsl": LabStream,
    "serial": SerialTrigger,
    "parallel": ParallelTrigger,
}
NEED_AN_ARGUMENT = ("serial", "parallel")


@contextmanager
def open_markers(specs: Sequence[str]) -> Iterator[Markers]:
    """Open the specified outputs, and close them on exit from the context.

    Parameters
    ----------
    specs : sequence of str
        ``lsl``, ``lsl:NAME``, ``serial:PORT``, ``parallel:ADDRESS``.

    Raises
    ------
    UserError
        If an output does not exist, is specified twice or cannot be opened.
    """
    outputs: list[MarkerOutput] = []
    try:
        for spec in specs:
            kind, _, argument = spec.partition(":")
            if kind not in OUTPUTS or (kind in NEED_AN_ARGUMENT and not argument):
                raise UserError(
                    "--markers {spec}: expected lsl, lsl:NAME, serial:PORT or parallel:ADDRESS",
                    spec=spec,
                )
            if specs.count(spec) > 1:
                raise UserError("--markers {spec}: named more than once", spec=spec)
            outputs.append(OUTPUTS[kind](argument))
        yield Markers(outputs)
    finally:
        for output in outputs:
            output.close()
