"""Damping of a case: the model of structural damping and its parameters."""

import inspect
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, get_origin, get_type_hints

import numpy as np
from pydantic import Field, create_model

from boltjoint.config.entries import Entry
from boltjoint.config.types import Number, Problems
from boltjoint.damping import MODELS, Damping, ModalDamping, ModalStructure, make_damping

#: what the key of a parameter ends in, by its unit
_ENDINGS = {"1": "", "s": "_s", "1/s": "_1_per_s"}

#: a parameter without a unit is a ratio of damping, and less than one
_RATIO = Annotated[Number, Field(ge=0, lt=1)]
_COEFFICIENT = Annotated[Number, Field(ge=0)]


class DampingEntry(Entry):
    """Damping of the structure by one model."""

    model: str
    """The damping model."""

    @property
    def damping(self) -> Damping:
        """The model with its parameters."""
        quantities = MODELS[self.model].quantities
        values = (getattr(self, key) for key in self._keys())
        return make_damping(self.model, **dict(zip(quantities, values, strict=True)))

    def conflicts(self) -> Problems:
        if not self.damping.matrix(ModalStructure(np.ones(1))).dissipates:
            first, *others = self._keys()
            yield (first,), f"must be greater than 0{''.join(f', or {key}' for key in others)}"

    @classmethod
    def _keys(cls) -> list[str]:
        """The keys of the parameters, in the order of the model's quantities."""
        return [key for key in cls.model_fields if key != "model"]


def _entry(model: type[Damping]) -> type[DampingEntry]:
    """The keys of a model."""
    kinds = get_type_hints(model)
    keys: dict[str, Any] = {"model": (Literal[model.name], Field(description="The damping model."))}
    for name, (unit, meaning) in model.quantities.items():
        value: Any = _RATIO if unit == "1" else _COEFFICIENT
        if get_origin(kinds[name]) is tuple:
            value = Annotated[tuple[value, ...], Field(min_length=1)]
        sentence = f"{meaning[0].upper()}{meaning[1:]}."
        keys[f"{name}{_ENDINGS[unit]}"] = (value, Field(description=sentence))
    name, text = f"{model.__name__}Entry", inspect.getdoc(model)
    # a class without source, where pydantic would search all frames for it
    options = {"use_attribute_docstrings": False}
    return create_model(
        name,
        __base__=DampingEntry,
        __doc__=text,
        __module__=__name__,
        __cls_kwargs__=options,
        **keys,
    )


def modal_damping(ratios: Sequence[float]) -> DampingEntry:
    """Modal damping of these ratios, as a case would give it."""
    content = {"model": ModalDamping.name, "damping_ratios": tuple(ratios)}
    return _ENTRIES[ModalDamping.name].model_validate(content)


_ENTRIES = {name: _entry(model) for name, model in MODELS.items()}
if TYPE_CHECKING:
    StructuralDamping = DampingEntry
else:
    ENTRIES = tuple(_ENTRIES.values())
    StructuralDamping = Annotated[Union[ENTRIES], Field(discriminator="model")]  # noqa: UP007
