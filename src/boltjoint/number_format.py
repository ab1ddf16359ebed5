"""Numbers as pages, tables, figures and messages print them."""

import math


def number(value: float, digits: int = 4) -> str:
    """A number in text, with this many significant digits.

    >>> number(0.001), number(37976.0), number(7.3e-15), number(-11.1288)
    ('0.001', '37976', '7.3 × 10⁻¹⁵', '−11.13')
    """
    if value == 0 or 1e-4 <= abs(value) < 1e7:
        before = 1 + math.floor(math.log10(abs(value))) if value else 1
        text = f"{value:.{max(0, digits - before)}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    else:
        base, power = f"{value:.{min(digits, 3) - 1}e}".split("e")
        base = base.rstrip("0").rstrip(".")
        exponent = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{base} × 10{exponent}"
    return text.replace("-", "−")
