"""Contact states of an element over one period, by their numbers in result files."""

UNKNOWN = -1
STICK = 0
STICK_SLIP = 1
STICK_SLIP_SEPARATION = 2
SEPARATION = 3

MEANINGS = ("stick", "stick-slip", "stick-slip with separation", "separation")
