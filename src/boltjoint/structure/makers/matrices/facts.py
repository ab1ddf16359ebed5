"""What pages state of a structure from matrices."""

from boltjoint.config.matrices import Matrices

MEANING = (
    "Stiffness and mass matrices of another program, with the contact points and bolts they have."
)


def facts_of(described: Matrices) -> dict[str, float | str | tuple[float, ...]]:
    """Files, bolts, inputs and outputs, by what they are called."""
    names = {"inputs": described.input_names, "outputs": described.output_names}
    return {
        "matrices from": ", ".join(described.named_files),
        "bolts": described.bolt_count,
        **{kind: ", ".join(values) or "none" for kind, values in names.items()},
    }
