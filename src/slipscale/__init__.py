"""Laboratory software for ultrasonic tactile plates: run, pilot and analyse experiments.

The package consists of the top-level folders of the repository: `slipscale.analysis` is the folder
``analysis``, and so on. A wheel contains copies of these folders, and an editable installation
contains links to them (``tools/build_hook.py``).

The functions in `FUNCTIONS` are imported on first use.

>>> import slipscale
>>> slipscale.read_study("biet2007").participants
12
"""

__version__ = "0.1.0"

TYPE_CHECKING = False  # importing typing takes milliseconds
if TYPE_CHECKING:
    from slipscale.analysis.api import open_plate, pilot, power, read_study, reconstruct
    from slipscale.analysis.load import load
    from slipscale.analysis.pipeline import analyse

__all__ = [
    "__version__",
    "analyse",
    "load",
    "open_plate",
    "pilot",
    "power",
    "read_study",
    "reconstruct",
]
#: Module that defines each function.
FUNCTIONS = {
    "load": "slipscale.analysis.load",
    "analyse": "slipscale.analysis.pipeline",
    "pilot": "slipscale.analysis.api",
    "power": "slipscale.analysis.api",
    "reconstruct": "slipscale.analysis.api",
    "read_study": "slipscale.analysis.api",
    "open_plate": "slipscale.analysis.api",
}


def __getattr__(name: str) -> object:
    """Import a public function when it is first used."""
    if name not in FUNCTIONS:
        raise AttributeError(f"module 'slipscale' has no attribute '{name}'")
    from importlib import import_module

    function: object = getattr(import_module(FUNCTIONS[name]), name)
    globals()[name] = function
    return function


def __dir__() -> list[str]:
    """Return the public names of the package."""
    return __all__
