"""Run the compiled firmware with the interface of the emulated board.

The C++ core in hardware/firmware is built as a library and runs in this process with a simulated
plate. The driver can thus be tested with the real firmware (`slipscale plate emulate --firmware
LIBRARY`).
"""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
from pathlib import Path

from slipscale.faults import UserError
from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.plate.twin import OFF, Drive, Twin

FIRMWARE = Path(__file__).parents[1] / "firmware"
FLAGS = ("-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
TOO_HOT_C = 75.0  # temperature reading with the fault "hot"
WATCHDOG_MS = 500.0
MILLISECONDS = 1 << 32  # The board's clock has 32 bits.

Drives = ctypes.CFUNCTYPE(None, ctypes.c_float, ctypes.c_float)
Does = ctypes.CFUNCTYPE(None)
Tells = ctypes.CFUNCTYPE(ctypes.c_float)


class PlateCalls(ctypes.Structure):
    """Callbacks for the electronics, as declared in board_library.cpp."""

    _fields_ = (
        ("drive", Drives),
        ("off", Does),
        ("amplitude_um_pp", Tells),
        ("resonance_hz", Tells),
        ("temperature_c", Tells),
    )


def build(folder: Path, *flags: str) -> Path:
    """Compile the firmware into a folder, and return the path of the library.

    Raises
    ------
    UserError
        If there is no C++ compiler, or compilation fails.
    """
    compiler = shutil.which("g++") or shutil.which("c++") or shutil.which("clang++")
    if compiler is None:
        raise UserError("firmware: no C++ compiler found, expected g++, c++ or clang++")
    library = folder / "libslipscale_plate.so"
    core = FIRMWARE / "slipscale_plate"
    sources = [FIRMWARE / "host" / "board_library.cpp", *sorted(core.glob("*.cpp"))]
    command: list[str | Path] = [
        compiler,
        *FLAGS,
        "-O1",
        "-shared",
        "-fPIC",
        *flags,
        "-I",
        core,
        *sources,
    ]
    done = subprocess.run([*command, "-o", library], capture_output=True, text=True, check=False)  # noqa: S603 - our own command
    if done.returncode:
        raise UserError(
            "firmware: {compiler} failed: {reason}", compiler=compiler, reason=done.stderr.strip()
        )
    return library


def load(library: Path) -> ctypes.CDLL:
    """Load a library made by `build`.

    Raises
    ------
    UserError
        If the file cannot be loaded, or does not contain the firmware.
    """
    try:
        code = ctypes.CDLL(str(library.resolve()))
        code.board_start.restype = ctypes.c_void_p
        code.board_start.argtypes = [
            ctypes.POINTER(PlateCalls),
            ctypes.c_float,
            ctypes.c_uint32,
            ctypes.c_uint32,
        ]
        code.board_receive.restype = ctypes.c_char_p
        code.board_receive.argtypes = [ctypes.c_void_p, ctypes.c_uint8, ctypes.c_uint32]
        code.board_tick.argtypes = [ctypes.c_void_p, ctypes.c_uint32]
        code.board_state.restype = ctypes.c_char_p
        amplitudes = (code.board_target_um_pp, code.board_due_um_pp)
        for each in amplitudes:
            each.restype = ctypes.c_float
        for each in (code.board_end, code.board_silence, code.board_state, *amplitudes):
            each.argtypes = [ctypes.c_void_p]
    except (OSError, AttributeError) as error:
        raise UserError(
            "firmware: {library} cannot be loaded ({error})", library=library, error=error
        ) from None
    return code


class CompiledBoard:
    """Board that runs the compiled firmware with a simulated plate.

    Parameters
    ----------
    twin : Twin
        Simulated plate.
    boot : int
        Boot number, which changes at every start.
    watchdog_ms : float
        Time without input after which the board silences the plate.
    code : ctypes.CDLL
        The library returned by `load`.
    """

    def __init__(
        self,
        twin: Twin,
        boot: int,
        watchdog_ms: float = WATCHDOG_MS,
        *,
        code: ctypes.CDLL,
    ) -> None:
        self.twin = twin
        self.hot = False
        self.busy = False  # The reference firmware is never busy.
        self._code = code
        self._now_s = 0.0
        self._line = b""
        self._closed = False  # whether the output stage is closed
        self._calls = PlateCalls(
            Drives(self._drive),
            Does(self._off),
            Tells(lambda: self.twin.measure_um_pp(self._now_s)),
            Tells(lambda: self.twin.conditions(self._now_s).resonance_hz),
            Tells(lambda: TOO_HOT_C if self.hot else self.twin.temperature_c(self._now_s)),
        )
        gain_um_pp_per_v = twin.resonator.gain_um_pp_per_v  # as calibrated
        self._board = code.board_start(
            ctypes.byref(self._calls), gain_um_pp_per_v, boot & 0xFFFF_FFFF, round(watchdog_ms)
        )

    def __del__(self) -> None:
        self._code.board_end(self._board)

    @property
    def vibrates(self) -> bool:
        """Whether the output is on, or a ramp that switches it on has been commanded."""
        return self._closed or self.state in wire.VIBRATING

    @property
    def state(self) -> str:
        """State that ``STAT?`` would report."""
        state: bytes = self._code.board_state(self._board)
        return state.decode("ascii")

    @property
    def target_level(self) -> float:
        """Commanded amplitude or, for a list, the mean amplitude."""
        return round(float(self._code.board_target_um_pp(self._board)), 6)  # 32-bit float

    def receive(self, data: bytes, now_s: float) -> list[tuple[str, bytes]]:
        """Process received bytes; return each complete command with its reply."""
        self._now_s = now_s
        answers = []
        for byte in data:
            answer: bytes | None = self._code.board_receive(self._board, byte, self._milliseconds())
            self._line = b"" if byte == wire.STOP[0] else self._line + bytes([byte])
            if byte != ord("\n"):
                continue
            command = wire.parse_command(self._line[:-1])
            self._line = b""
            if answer is not None:
                answers.append((command[1] if command else "*IDN?", answer))
        return answers

    def tick(self, now_s: float) -> None:
        """Advance the board to the given time."""
        self._now_s = now_s
        self._code.board_tick(self._board, self._milliseconds())

    def silence(self, now_s: float) -> None:
        """Switch the output off."""
        self._now_s = now_s
        self._code.board_silence(self._board)

    def commanded_level(self, now_s: float) -> float:  # noqa: ARG002 - the board's own time
        """Return the currently commanded amplitude."""
        return float(self._code.board_due_um_pp(self._board))

    def _milliseconds(self) -> int:
        # Without the added amount, rounding errors would turn 0.057 s into 56 ms.
        return math.floor(self._now_s * 1000 + 1e-6) % MILLISECONDS

    def _drive(self, frequency_hz: float, voltage_v: float) -> None:
        self._closed = True
        drive = Drive(frequency_hz=frequency_hz, voltage_v=voltage_v)
        self.twin.set_drive(drive, self._now_s)

    def _off(self) -> None:
        self._closed = False
        self.twin.set_drive(OFF, self._now_s)
