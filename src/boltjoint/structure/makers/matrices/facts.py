"""What pages state of a structure from matrices or modes."""

from boltjoint.config.matrices import Matrices

MEANING = (
    "Stiffness and mass matrices, or modes, of another program, with the contact points and bolts "
    "they have."
)


def facts_of(described: Matrices) -> dict[str, float | str | tuple[float, ...]]:
    """Files, bolts, inputs and outputs, by what they are called."""
    names = {"inputs": described.input_names, "outputs": described.output_names}
    files = ", ".join(described.named_files)
    return {
        f"{'modes' if described.has_modes_only else 'matrices'} from": files,
        "bolts": described.bolt_count or "none, since normal loads are given",
        **{kind: ", ".join(values) or "none" for kind, values in names.items()},
    }
