"""Gap between the surfaces of the bars before tightening: its shape, or the file of a map."""

from collections.abc import Mapping
from typing import Annotated

from pydantic import Discriminator, Tag

from boltjoint.config.entries import Entry
from boltjoint.config.types import DataFile, Number, Positive, Problems

#: fewest elements along a wave
ELEMENTS_IN_WAVE = 4


class GapShape(Entry):
    """Form error of both surfaces together, as flatness and waviness.

    The waviness is a cosine along the bar. The surfaces touch where both together are nearest.
    """

    flatness_um: Number = 0.0
    """Distance of two parallel planes that hold the surface, a paraboloid around the centre of the
    lap whose corners lie in one of them: positive where it is hollow, so that the corners touch
    first, negative where it is crowned, so that the centre does."""
    waviness_um: Number = 0.0
    """Amplitude of the waviness, half of the height from valley to crest: positive with a valley at
    the centre of the lap, negative with a crest."""
    wavelength_mm: Positive | None = None
    """Wavelength of the waviness along the bar, at least four elements of the lap; needed with
    ``waviness_um``."""

    def conflicts(self) -> Problems:
        keys = self.model_fields_set
        if not keys & {"flatness_um", "waviness_um"}:
            yield ("flatness_um",), "is missing: or give waviness_um and wavelength_mm"
        elif "waviness_um" in keys and self.wavelength_mm is None and self.waviness_um:
            yield ("wavelength_mm",), "is missing: length of a wave along the bar"
        elif self.wavelength_mm is not None and "waviness_um" not in keys:
            yield ("waviness_um",), "is missing: amplitude of the wave"


def _form(value: object) -> str | None:
    if isinstance(value, str):
        return "file"
    return "shape" if isinstance(value, Mapping | GapShape) else None


Gap = Annotated[
    Annotated[DataFile, Tag("file")] | Annotated[GapShape, Tag("shape")],
    Discriminator(
        _form,
        custom_error_type="no_values",
        custom_error_message="must be the name of a CSV file, or have flatness_um, or waviness_um "
        "with wavelength_mm",
    ),
]
