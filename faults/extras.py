"""The extras that install the packages missing from a light installation."""

from __future__ import annotations

# Imported module -> the extra in pyproject.toml that installs it.
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


def how_to_install(module: str) -> str | None:
    """Return a sentence that explains how to install a module; None if no extra includes it.

    Parameters
    ----------
    module : str
        The module that could not be imported, with or without its parents' names.
    """
    name = module.partition(".")[0]
    extra = EXTRA_OF.get(name)
    if extra is None:
        return None
    return (
        f"needs the package '{name}', which is not installed; install it with: pip install "
        f"'slipscale[{extra}]'"
    )
