"""Every pinned package has a wheel for each system and Python that Slipscale supports.

Asks a package index: opt-in, ``python -m pytest -m index tests/installation``.
"""

import subprocess

import pytest
from packaging.requirements import Requirement

from tools import setup

pytestmark = [
    pytest.mark.index,
    pytest.mark.skipif("'index' not in config.option.markexpr", reason="asks a package index"),
]

#: Platforms, as uv names them, with what is built from source there.
PLATFORMS = {
    "x86_64-manylinux_2_28": set(),
    "aarch64-manylinux_2_28": {"psychtoolbox"},
    "aarch64-apple-darwin": set(),
    "x86_64-apple-darwin": set(),
    "x86_64-pc-windows-msvc": set(),
}
#: Plain Python without a wheel: built from source everywhere, without a compiler.
PLAIN = {"esprima"}
CASES = [
    (name, platform, f"3.{minor}")
    for name, (newest, _size) in setup.SETS.items()
    for platform in PLATFORMS
    for minor in range(setup.OLDEST[1], newest[1] + 1)
]


def resolved(texts, platform, python, folder):
    """Return the resolver's exit status and errors for pins from wheels alone; nothing is kept."""
    pins = folder / "pins.txt"
    pins.write_text("\n".join(texts))
    options = ["--only-binary", ":all:", "--no-deps", "--dry-run", "--quiet"]
    target = [
        "--target",
        folder / "none",
        "--python-platform",
        platform,
        "--python-version",
        python,
    ]
    words = [setup.find_uv(), "pip", "install", *options, *target, "-r", pins]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


@pytest.mark.parametrize("name, platform, python", CASES)
def test_every_pin_but_the_listed_ones_has_a_wheel(tmp_path, name, platform, python):
    text = (setup.ROOT / setup.pins(name)).read_text(encoding="utf-8")
    pins = [line.removesuffix("\\") for line in text.splitlines() if line[:1].isalnum()]
    assert len(pins) > 30
    source = PLAIN | PLATFORMS[platform]
    wheels = [each for each in pins if Requirement(each).name not in source]
    assert resolved(wheels, platform, python, tmp_path) == (0, "")
    if python == "3.13":  # the exceptions are PsychoPy's, which has no release for it
        return
    for missing in source & {Requirement(each).name for each in pins}:
        alone = [each for each in pins if Requirement(each).name == missing]
        status, errors = resolved(alone, platform, python, tmp_path)
        assert (status, f"Wheels are required for `{missing}`" in errors) == (1, True), errors
