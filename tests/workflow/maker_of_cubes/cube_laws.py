"""Friction with a coefficient that is twice what a case says: a law in a package of its own."""

from dataclasses import replace

from boltjoint.friction.declarations import CONSTANT

DECLARATION = replace(CONSTANT, name="rough", label="rough contact", meaning="Rough contact.")


def law():
    """The class of the law."""
    from dataclasses import dataclass
    from typing import ClassVar

    from boltjoint.friction.constant import ConstantLoad
    from boltjoint.friction.declarations import LawDeclaration

    @dataclass(frozen=True)
    class RoughContact(ConstantLoad):
        """Elements under constant normal load, with twice the friction coefficient."""

        declaration: ClassVar[LawDeclaration] = DECLARATION

        @classmethod
        def from_contact(cls, pairs, *, tangential_stiffness, friction_coefficient):
            """As of elements under constant normal load."""
            keys = {"friction_coefficient": 2 * friction_coefficient}
            return super().from_contact(pairs, tangential_stiffness=tangential_stiffness, **keys)

    return RoughContact
