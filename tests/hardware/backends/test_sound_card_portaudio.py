"""The sound-card backend on a real PortAudio stream: ALSA's null device, which plays to nobody.

The other tests of this backend put a stand-in in PortAudio's place. Here the library, its thread
and its callbacks are the real ones; what the device does is nothing, as fast as it can.
"""

import json
import os
import subprocess
import sys

import pytest

# Without a default, ALSA's PortAudio aborts the process.
CONFIGURATION = """
pcm.!default { type null }
ctl.!default { type null }
pcm.null_plate { type null hint { show on description "nobody" } }
"""
PROGRAM = """
import json, sys
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.registry import open_plate
from slipscale.hardware.errors import PlateFault
from tests.support.patient_host import PatientHost

told = []
for spec in sys.argv[1:]:
    plate = open_plate(spec, clock=SystemClock())
    plate._machine = PatientHost()
    try:
        with plate:
            about = plate.identity.model
            readback = plate.excite(frequency_hz=30_500, voltage_v=10.0)
            level = plate._carrier.level
            plate.check()
            plate.silence()
            told.append([about, readback.kind, level, plate._carrier.level])
        told[-1].append(plate._stream is None or plate._stream.closed)
    except PlateFault as fault:
        told.append(fault.code)
print(json.dumps(told))
"""


def plays(folder, *specs):
    """Return what each SPEC's plate told, in a process whose ALSA knows the null device only."""
    configuration = folder / "asound.conf"
    configuration.write_text(CONFIGURATION)
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *specs],
        env={**os.environ, "ALSA_CONFIG_PATH": str(configuration)},
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    if "PortAudio library not found" in done.stderr:
        pytest.skip("PortAudio is not installed")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ALSA is Linux's")
def test_a_real_stream_plays_the_carrier_and_ends_silent(tmp_path):
    played, missing = plays(
        tmp_path, "sound:null_plate,full_scale=20", "sound:no_such_card,full_scale=20"
    )
    about, kind, driven, silent, closed = played
    assert about == "null_plate"
    assert kind == "none"  # nothing is calibrated, so no amplitude is told
    assert (driven, silent) == (0.5, 0.0)  # of full scale: 10 V of 20 V
    assert closed
    assert missing == "not_there"
