"""List the types of textures that a study can contain.

Each kind is a dataclass with `Parameter` annotations (see `slipscale.stimuli.parameters`) that
implements the interface `slipscale.stimuli.surface.Surface`.
"""

from __future__ import annotations

from collections.abc import Mapping

from slipscale.stimuli.friction_map import FrictionMap
from slipscale.stimuli.parameters import Declared, declared
from slipscale.stimuli.texture import Grating
from slipscale.stimuli.transient import Transient

Texture = Grating | Transient | FrictionMap
#: Kinds of texture, keyed by name in study files.
KINDS: Mapping[str, type[Texture]] = {
    "grating": Grating,
    "transient": Transient,
    "map": FrictionMap,
}
#: Parameters that a study can vary, keyed by field name.
PARAMETERS: Mapping[str, Declared] = {
    field: each for kind in KINDS.values() for field, each in declared(kind).items()
}


def kind_in(record: Mapping[str, object]) -> type[Texture] | None:
    """Return the texture type that a record describes, or None if it is not a texture."""
    return next((kind for kind in KINDS.values() if kind.MARK in record), None)
