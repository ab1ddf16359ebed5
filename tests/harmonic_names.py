"""Names of the components of a motion, read apart from the library."""


def parse_component(name):
    """Coefficient (bias, sin or cos) and number of a component."""
    part = name.rstrip("0123456789")
    if part == "bias":
        return part, 0
    return part, int(name.removeprefix(part) or 1)
