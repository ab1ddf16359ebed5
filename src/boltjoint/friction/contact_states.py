"""Contact states of an element over one period, by their numbers in result files."""

import numpy as np

UNKNOWN = -1
STICK = 0
STICK_SLIP = 1
STICK_SLIP_SEPARATION = 2
SEPARATION = 3

MEANINGS = ("stick", "stick-slip", "stick-slip with separation", "separation")

#: of a variable that holds them
ATTRIBUTES = {
    "units": "1",
    "long_name": "contact state at the peak, -1 without a peak",
    "flag_values": np.arange(len(MEANINGS), dtype=np.int8),
    "flag_meanings": " ".join(meaning.replace(" ", "_") for meaning in MEANINGS),
}
