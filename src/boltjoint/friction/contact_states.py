"""The contact states an element can have over one period, as the result files number them."""

UNKNOWN = -1
STICK = 0
STICK_SLIP = 1
STICK_SLIP_SEPARATION = 2
SEPARATION = 3

MEANINGS = ("stick", "stick-slip", "stick-slip with separation", "separation")
