"""Find the extras that provide packages missing from a minimal installation."""

from __future__ import annotations

import sys

from slipscale.faults.message import Message

# Extra in pyproject.toml that installs each module.
EXTRA_OF = {
    "joblib": "analysis",
    "openpyxl": "analysis",
    "pandas": "analysis",
    "pingouin": "analysis",
    "pyreadstat": "analysis",
    "sklearn": "analysis",
    "statsmodels": "analysis",
    "numpyro": "bayes",
    "pyvisa": "plate",
    "pyvisa_py": "plate",
    "serial": "plate",
    "skfem": "plate",
    "nidaqmx": "daq",
    "distributed": "cluster",
    "pylsl": "markers",
    "starlette": "console",
    "uvicorn": "console",
    "docx": "export",
    "weasyprint": "export",
    "psychopy": "session",
    "sounddevice": "session",
}
# Newest Python for which PsychoPy has a release.
PSYCHOPY_UP_TO = (3, 12)


def how_to_install(module: str) -> str | None:
    """Explain how to install a module, or return None if no extra of Slipscale installs it.

    Parameters
    ----------
    module : str
        Name of the module that could not be imported, with or without parent packages.
    """
    name = module.partition(".")[0]
    extra = EXTRA_OF.get(name)
    if extra is None:
        return None
    if name == "psychopy":
        return no_psychopy() or Message(
            "needs the package 'psychopy', which is not installed; install it with: slipscale "
            "setup session --run; or, with 1 GB more: pip install 'slipscale[session]'"
        )
    return Message(
        "needs the package '{name}', which is not installed; install it with: pip install "
        "'slipscale[{extra}]'",
        name=name,
        extra=extra,
    )


def no_psychopy() -> Message | None:
    """Explain why this Python cannot install PsychoPy, or return None if it can."""
    version: tuple[int, ...] = sys.version_info[:2]
    if version <= PSYCHOPY_UP_TO:
        return None
    return Message(
        "needs PsychoPy, which has no release for Python {version}; install Slipscale with Python "
        "3.11 or 3.12, then: slipscale setup session --run",
        version="{}.{}".format(*sys.version_info),
    )
