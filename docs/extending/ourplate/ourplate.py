"""Driver for our plate, which answers "ok" to lines such as "A 1.200" on a serial port."""

from slipscale.backend import (
    GarbledReply,
    PlateDriver,
    PlateIdentity,
    PlateTimeout,
    Presentation,
    Readback,
    SerialLine,
    WrongDevice,
    opened,
)

RAMP_STEPS = 10
RAMP_S = 0.03
SETTLE_S = 0.01  # Seven time constants of a plate with Q = 130 at 31 kHz.
READS = 100  # SerialLine.read waits at most 10 ms, so the limit is 1 s.


class OurPlate(PlateDriver):
    """Driver for a plate with a serial port and without a sensor."""

    name = "ourplate"

    def __init__(self, port, *, clock, plate):
        super().__init__(clock=clock, plate=plate)  # Limits and files are options of --plate SPEC.
        self._port = port
        self._line = None
        self._level = 0.0

    def _connect(self):
        self._line = SerialLine(self._port)  # Opens the port exclusively; raises PlateFault.
        name = self._ask("?")
        if not name.startswith("ourplate"):
            raise WrongDevice(f"{self._port}: '{name}' answers")
        self._set(0.0)
        return PlateIdentity(manufacturer="us", model="ourplate", serial="1", firmware=name)

    def _drive(self, level):
        begun_s = self.clock.now()
        from_level = self._level
        for step in range(1, RAMP_STEPS + 1):
            self._set(from_level + (level - from_level) * step / RAMP_STEPS)
            self.clock.sleep(RAMP_S / RAMP_STEPS)
        self.clock.sleep(SETTLE_S)
        return Presentation(
            commanded_level=level,
            readback=self._read_back(),
            settled_by="wait",
            settle_time_s=self.clock.now() - begun_s,
        )

    def _read_back(self):
        # Our plate has no sensor, so it can only report the command.
        return Readback(level=self._level, kind="commanded", time_s=self.clock.now())

    def _silence(self):
        if self._line is not None:
            self._set(0.0)

    def _close(self):
        if self._line is not None:
            self._line.close()
            self._line = None

    def _set(self, level):
        answer = self._ask(f"A {level:.3f}")
        if answer != "ok":
            raise GarbledReply(f"{self._port}: '{answer}' instead of ok")
        self._level = level

    def _ask(self, text):
        self._line.write(text.encode() + b"\n")
        answer = b""
        for _ in range(READS):
            answer += self._line.read()
            if answer.endswith(b"\n"):
                return answer.decode().strip()
        raise PlateTimeout(f"{self._port}: no answer to '{text}'")


def open_plate(address, *, clock, seed):  # noqa: ARG001 - only a simulated plate uses the seed
    """Return the driver; `address` contains the port and options given after "ourplate:"."""
    # If your backend has its own options, pass them to `opened` as a third argument.
    port, _options, plate = opened(address, OurPlate.name)
    return OurPlate(port, clock=clock, plate=plate)
