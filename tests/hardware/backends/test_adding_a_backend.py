"""docs/extending/adding-a-backend.md: its example is installed and used."""

import configparser
import json
import os
import subprocess
import sys
import threading
import tomllib
import tty
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[3] / "docs" / "extending" / "ourplate"

SESSION = """
import json, sys
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.errors import OverLimit
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface

with open_plate("ourplate:" + sys.argv[1] + ",interlock=foot_switch", clock=SystemClock()) as plate:
    made = plate.present(VirtualSurface(level=1.2))
    try:
        plate.present(VirtualSurface(level=9.0))
    except OverLimit:
        print(json.dumps([plate.identity.model, made.readback.kind, made.commanded_level]))
"""


def install(files, site):
    """Install the page's files as pip would: the module, and the metadata of its pyproject.toml.

    Without pip itself: its build needs the network.
    """
    project = tomllib.loads(files["pyproject.toml"])
    (modules,) = project["tool"]["hatch"]["build"]["targets"]["wheel"].values()
    for module in modules:
        (site / module).write_text(files[module], encoding="utf-8")
    info = site / "slipscale_ourplate-1.0.dist-info"
    info.mkdir()
    name, version = project["project"]["name"], project["project"]["version"]
    info.joinpath("METADATA").write_text(f"Name: {name}\nVersion: {version}\n")
    points = configparser.ConfigParser()
    points.read_dict(project["project"]["entry-points"])
    with info.joinpath("entry_points.txt").open("w") as file:
        points.write(file)


@pytest.fixture
def device():
    """A device that answers as the page says; what it was sent is kept."""
    master, slave = os.openpty()
    tty.setraw(slave)
    sent = []

    def answer():
        buffer = b""
        while True:
            try:
                buffer += os.read(master, 100)
            except OSError:
                return
            *lines, buffer = buffer.split(b"\n")
            for line in lines:
                sent.append(line.decode())
                os.write(master, b"ourplate 1.0\n" if line == b"?" else b"ok\n")

    thread = threading.Thread(target=answer, daemon=True)
    thread.start()
    yield os.ttyname(slave), sent
    os.close(slave)
    thread.join()
    os.close(master)


def test_the_page_followed_literally_gives_a_plate_that_works(tmp_path, device):
    port, sent = device
    files = {file.name: file.read_text(encoding="utf-8") for file in EXAMPLE.glob("*.*")}
    assert "READS = 100 " in files["ourplate.py"]  # 1 s; this machine may be busy for longer
    files["ourplate.py"] = files["ourplate.py"].replace("READS = 100 ", "READS = 100_000 ")
    install(files, tmp_path)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", SESSION, port],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout) == ["ourplate", "commanded", 1.2]
    assert sent[:2] == ["?", "A 0.000"]
    assert "A 1.200" in sent
    assert "A 9.000" not in sent
    assert sent[-1] == "A 0.000"
    listed = subprocess.run(
        [sys.executable, "-m", "slipscale", "plate", "list"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "ourplate" in listed.stdout
    spec = f"ourplate:{port},interlock=foot_switch"
    conform = subprocess.run(
        [
            sys.executable,
            "-m",
            "slipscale",
            "plate",
            "conform",
            spec,
            "--json",
        ],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    outcomes = {each["rule"]: each["outcome"] for each in json.loads(conform.stdout)}
    assert set(outcomes.values()) == {"conforms", "not applicable"}
    assert outcomes["the readback can reveal a wrong amplitude"] == "not applicable"
