"""Define friction maps: surfaces whose amplitude depends on the grey value of an image.

An image with one row is a profile along the stroke. Without a sensor, the profile is played from
its left end, at the speed assumed for the finger. An image with several rows requires the position
of the finger in both directions. The middle of the image is at the sensor's zero, and the top of
the image is at positive y. The amplitude is interpolated between pixels. Outside the image, the
nearest pixel is used.
"""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from dataclasses import dataclass
from functools import cache
from typing import Annotated, ClassVar

from slipscale.faults import UserError
from slipscale.stimuli.modulation import DEFAULT_MODULATOR, STEPS_MAX, Followed, Loop, Modulator
from slipscale.stimuli.parameters import FINGER_SPEED, Parameter, Parametric
from slipscale.stimuli.surface import Sensor

WHITE = 255
# Largest number of pixels, because the journal contains the image of each presentation.
MOST_PIXELS = 16_384
Greys = tuple[bytes, ...]  # rows, from the top; 0 is black


def packed(rows: Greys) -> str:
    """Encode the rows of an image as text for study files and journals."""
    return base64.b64encode(zlib.compress(b"".join(rows), 9)).decode()


@cache
def _unpacked(pixels: str, columns: int) -> Greys:
    """Decode the rows of an image. Raises `ValueError` if the text is not an image."""
    decoder = zlib.decompressobj()
    greys = decoder.decompress(base64.b64decode(pixels, validate=True), MOST_PIXELS + 1)
    if not 0 < len(greys) <= MOST_PIXELS or not columns > 0 or len(greys) % columns:
        raise ValueError("the number of pixels or columns is wrong")
    return tuple(greys[start : start + columns] for start in range(0, len(greys), columns))


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionMap(Parametric):
    """Surface whose amplitude is given by the grey values of an image.

    Parameters
    ----------
    pixels : str
        Image encoded with `packed`.
    columns : int
        Number of pixels per row.
    image : str
        Name of the image file.
    label, name : str
        See `slipscale.stimuli.texture.Grating`.

    Raises
    ------
    UserError
        If a parameter is out of range or the image is invalid.
    """

    #: Key by which a record is identified as a friction map.
    MARK: ClassVar = "pixels"

    black_level: Annotated[
        float,
        Parameter(
            name="black {q.name}", unit=None, least=0, description="Amplitude at black pixels."
        ),
    ]
    white_level: Annotated[
        float,
        Parameter(
            name="white {q.name}", unit=None, least=0, description="Amplitude at white pixels."
        ),
    ]
    pixel_mm: Annotated[
        float,
        Parameter(
            name="pixel size",
            unit="mm",
            above=0,
            most=100,
            description="Width and height of a pixel on the plate.",
        ),
    ]
    pixels: str
    columns: int
    image: str = ""
    finger_speed_mm_s: Annotated[float, FINGER_SPEED] = 50.0
    label: str = ""
    name: str = ""

    def __post_init__(self) -> None:
        self.refuse_parameters()
        try:
            _unpacked(self.pixels, self.columns)
        except (ValueError, binascii.Error, zlib.error) as error:
            raise UserError(
                "{where}: the image cannot be read ({error})", where=self.where, error=error
            ) from None

    @property
    def _rows(self) -> Greys:
        return _unpacked(self.pixels, self.columns)

    def _level(self, grey: float) -> float:
        return self.black_level + grey / WHITE * (self.white_level - self.black_level)

    @property
    def _changes(self) -> bool:
        return self.black_level != self.white_level and len(set(b"".join(self._rows))) > 1

    @property
    def needs_sensor(self) -> bool:
        """Whether the finger position must be measured: the map varies and has several rows."""
        return self._changes and len(self._rows) > 1

    @property
    def sensor(self) -> Sensor | None:
        """Sensor that controls the amplitude; None if the amplitude is the same everywhere."""
        return "position" if self._changes else None

    @property
    def level(self) -> float:
        """Largest amplitude."""
        greys = b"".join(self._rows)
        return max(self._level(min(greys)), self._level(max(greys)))

    @property
    def settled_level(self) -> float:
        """Level at which the plate settles, which is the mean level of the map."""
        greys = b"".join(self._rows)
        return self._level(sum(greys) / len(greys))

    @property
    def _width_mm(self) -> float:
        return self.columns * self.pixel_mm

    @property
    def caption(self) -> str:
        """Name of the image file."""
        return self.image

    @property
    def summary(self) -> str:
        """Description of the amplitudes, the image and its size."""
        return (
            f"{self.black_level:g} (black) to {self.white_level:g} (white), {self.image}, "
            f"{self._width_mm:g} x {len(self._rows) * self.pixel_mm:g} mm"
        )

    def level_at(self, x_mm: float, y_mm: float = 0.0) -> float:
        """Return the amplitude at a position along and across the stroke."""
        rows = self._rows
        across = _between(-y_mm / self.pixel_mm, len(rows))
        along = _between(x_mm / self.pixel_mm, self.columns)
        row, column = int(across), int(along)
        below, right = min(row + 1, len(rows) - 1), min(column + 1, self.columns - 1)

        def grey(of: int) -> float:
            return rows[of][column] + (along - column) * (rows[of][right] - rows[of][column])

        return self._level(grey(row) + (across - row) * (grey(below) - grey(row)))

    def shown(self, share: float) -> float:
        """Return the amplitude at a fraction (0 to 1) of the map's width, on its centre line."""
        return self.level_at((share - 0.5) * self._width_mm)

    def change(
        self,
        modulator: Modulator = DEFAULT_MODULATOR,  # noqa: ARG002 - on any plate
    ) -> Loop | None:
        """Return None, because a friction map has no trigger."""
        return None

    def loop(self, modulator: Modulator = DEFAULT_MODULATOR) -> Loop | None:
        """Return the profile at the assumed speed, or None if it is constant or needs a sensor.

        Raises
        ------
        UserError
            If the plate or its serial line is too slow for the profile.
        """
        if not self._changes or self.needs_sensor:
            return None
        stroke_s = self._width_mm / self.finger_speed_mm_s
        steps = min(math.floor(stroke_s / modulator.shortest_step_s + 1e-9), STEPS_MAX)
        if steps < 2:  # noqa: PLR2004 - fewer are no change
            raise UserError(
                "{where}: a finger at {finger_speed_mm_s:g} mm/s crosses the image in "
                "{crossing_ms:.3g} ms, but the plate and its connection need {needed_ms:g} ms "
                "for two amplitudes",
                where=self.where,
                finger_speed_mm_s=self.finger_speed_mm_s,
                crossing_ms=1000 * stroke_s,
                needed_ms=2000 * modulator.shortest_step_s,
            )
        levels = tuple(self.shown((step + 0.5) / steps) for step in range(steps))
        step_s = stroke_s / steps
        return Loop(
            levels=levels,
            step_s=step_s,
            edge_s=min(modulator.edge_s, step_s),
            mean_level=sum(levels) / steps,
        )

    def followed(self, modulator: Modulator = DEFAULT_MODULATOR) -> Followed | None:
        """Predict how well amplitude and friction follow the map at the assumed finger speed.

        Return None if the amplitude is constant.
        """
        if not self._changes:
            return None
        return Followed(
            change=f"{self.pixel_mm / self.finger_speed_mm_s * 1000:.3g} ms per pixel at "
            f"{self.finger_speed_mm_s:g} mm/s",
            whole="its range",
            plate=self._range_after(modulator.time_constant_s),
            friction=self._range_after(modulator.time_constant_s, modulator.film_time_constant_s),
            remedy="larger pixels, or a slower finger",
        )

    def _range_after(self, *time_constants_s: float) -> float:
        """Return the fraction of the grey-value range that passes through first-order lags."""
        found: list[float] = []
        for row in self._rows:
            greys = [float(each) for each in row]
            for time_constant_s in time_constants_s:
                passed = -math.expm1(-self.pixel_mm / self.finger_speed_mm_s / time_constant_s)
                state, behind = greys[0], []
                for grey in greys:
                    state += passed * (grey - state)
                    behind.append(state)
                greys = behind
            found += greys
        every = b"".join(self._rows)
        return (max(found) - min(found)) / (max(every) - min(every))


def _between(place: float, count: int) -> float:
    """Convert a position relative to the middle (in pixels) to a fractional pixel index."""
    return min(max(place + (count - 1) / 2, 0.0), float(count - 1))
