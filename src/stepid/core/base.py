"""The frozen model base and the field types that all models share."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
import numpy.typing as npt
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    PrivateAttr,
    ValidationError,
    WithJsonSchema,
)

from stepid.core.field_units import field_unit
from stepid.core.quantities import CART, Quantities, quantities_of, spoken
from stepid.core.show import HEADER, one_line, rows
from stepid.core.tables import html_table, text_table
from stepid.core.takes import described
from stepid.errors import InputError

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass as _PydanticMeta

    from stepid.core.provenance import Provenance
else:
    _PydanticMeta = type(BaseModel)

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]


def _vector(value: object) -> Array:
    return _frozen_array(value, 1)


def _matrix(value: object) -> Array:
    return _frozen_array(value, 2)


def _frozen_array(value: object, ndim: int) -> Array:
    if isinstance(value, np.ma.MaskedArray):
        raise ValueError("is a masked array; leave out what is masked, or give its values (x.compressed(), x.data)")
    if isinstance(value, Model):  # such as a StepInput, which readers take
        samples = callable(getattr(value, "values", None))
        hint = "; readers take it, here give its samples: its method values(time) has them" if samples else ""
        raise ValueError(f"needs numbers, got {described(value)}{hint}")
    try:
        source = np.asarray(value)
    except ValueError as error:
        raise ValueError(f"not an array of numbers ({error})") from None
    if source.dtype.kind not in "fiu":
        raise ValueError(f"needs numbers, got {source.dtype}")
    array = np.array(source, dtype=np.float64, order="C")
    if array.ndim != ndim:
        raise ValueError(f"needs {ndim} dimension{'s'[: ndim - 1]}, got shape {array.shape}")
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        raise ValueError(f"{bad.size} value(s) are not finite, the first at index {bad[0]}")
    array.setflags(write=False)
    return array


def _to_list(array: Array) -> list[Any]:
    nested: list[Any] = array.tolist()
    return nested


def _finite(value: float) -> float:
    # strict float fields still admit inf and nan; physics does not
    if not np.isfinite(value):
        raise ValueError("must be a finite number")
    return value


def _plain(value: object) -> object:
    # strict mode refuses numpy integers and float32; a number is a number
    return value.item() if isinstance(value, np.generic) else value


_SERIALIZE = PlainSerializer(_to_list, when_used="json")
Vector = Annotated[
    Array,
    BeforeValidator(_vector),
    _SERIALIZE,
    WithJsonSchema({"type": "array", "items": {"type": "number"}}),
]
Matrix = Annotated[
    Array,
    BeforeValidator(_matrix),
    _SERIALIZE,
    WithJsonSchema({"type": "array", "items": {"type": "array", "items": {"type": "number"}}}),
]
Finite = Annotated[float, BeforeValidator(_plain), AfterValidator(_finite)]
Positive = Annotated[float, BeforeValidator(_plain), Field(gt=0), AfterValidator(_finite)]
NonNegative = Annotated[float, BeforeValidator(_plain), Field(ge=0), AfterValidator(_finite)]
Label = Annotated[str, Field(min_length=1)]


def _same(a: object, b: object) -> bool:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return isinstance(a, np.ndarray) and isinstance(b, np.ndarray) and bool(np.array_equal(a, b))
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(_same(a[k], b[k]) for k in a)
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(_same(x, y) for x, y in zip(a, b, strict=True))
    return bool(a == b)


def _hashable(value: object) -> object:
    if isinstance(value, np.ndarray):
        return (value.shape, (value + 0.0).tobytes() if value.dtype.kind == "f" else value.tobytes())  # -0.0 is 0.0
    if isinstance(value, Mapping):
        return tuple(sorted((str(k), _hashable(v)) for k, v in value.items()))
    if isinstance(value, tuple | list):
        return tuple(_hashable(v) for v in value)
    return value


def _complain(owner: str, data: object, error: ValidationError) -> InputError:
    name = data.get("name") if isinstance(data, Mapping) else None
    who = f"{owner} {name!r}" if isinstance(name, str) else owner
    lines = []
    for item in error.errors():
        where = ".".join(str(part) for part in item["loc"])
        message = item["msg"].removeprefix("Value error, ")
        lines.append(f"{where}: {message}" if where else message)
    return InputError(f"{who}: " + "; ".join(lines), f"Give {owner} values of the documented type, unit and range.")


_WRITES = {"summary", "__repr__", "__str__", "_repr_html_", "to_latex", "to_dataframe"}


class _Meta(_PydanticMeta):
    # on the metaclass, because a custom __init__ would make pydantic build nested models in Python mode
    if not TYPE_CHECKING:  # and hidden, to keep the typed signature that pydantic gives each model

        def __call__(self, *args: Any, **data: Any) -> Any:
            if args:
                needed = ", ".join(f"{name}=…" for name, field in self.model_fields.items() if field.is_required())
                raise TypeError(f"{self.__name__} takes its values by name: {self.__name__}({needed})")
            try:
                return super().__call__(**data)
            except ValidationError as error:
                raise _complain(self.__name__, data, error) from None


class Model(BaseModel, metaclass=_Meta):
    """Frozen, strict, finite, array-safe base of every stepid model.

    Construction raises `stepid.errors.InputError` (a `ValueError`) that names the model and the field.
    """

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        strict=True,
        allow_inf_nan=False,
        arbitrary_types_allowed=True,
        ser_json_inf_nan="constants",
        hide_input_in_errors=True,
    )
    _provenance: Any = PrivateAttr(default=None)
    _quantities: Quantities | None = PrivateAttr(default=None)

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        """Have what a model writes be in the words and units of its plant."""
        super().__pydantic_init_subclass__(**options)
        for name in _WRITES & cls.__dict__.keys():
            setattr(cls, name, spoken(cls.__dict__[name]))

    def model_post_init(self, context: Any) -> None:
        """Have what is inside a model of another plant than a cart driven in V know it, too."""
        if CART[:2] != (self.__dict__.get("motion", CART.motion), self.__dict__.get("input_unit", CART.input_unit)):
            own = quantities_of(self)
            fields = {name: own.bear(getattr(self, name)) for name in type(self).model_fields}
            object.__setattr__(self, "__dict__", fields)
            self._quantities = own

    @property
    def provenance(self) -> Provenance | None:
        """Where it comes from: files with their hashes, settings, versions; None for what was made by hand.

        It takes no part in equality, `to_dict` and JSON; `save` keeps it.
        """
        found: Provenance | None = self._provenance
        return found

    def _bearing(self, provenance: Provenance | None) -> Self:
        self._provenance = provenance
        return self

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write it as one JSON file with its provenance, which `stepid.load` reads, also in later versions.

        Parameters
        ----------
        path : path-like
            An older file of this name is replaced, at once and whole.

        Returns
        -------
        pathlib.Path
            Where it was written.

        Raises
        ------
        stepid.errors.InputError
            If the file cannot be written.
        """
        from stepid.core.saving import save

        return save(self, path)

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """Validate a mapping or instance; see `pydantic.BaseModel.model_validate`."""
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise _complain(cls.__name__, obj, error) from None

    @classmethod
    def model_validate_json(cls, json_data: str | bytes | bytearray, **options: Any) -> Self:
        """Validate JSON text; see `pydantic.BaseModel.model_validate_json`."""
        try:
            return super().model_validate_json(json_data, **options)
        except ValidationError as error:
            raise _complain(cls.__name__, None, error) from None

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Copy it, without what was computed of fields that are updated; see `pydantic.BaseModel.model_copy`."""
        copy = super().model_copy(update=update, deep=deep)
        if update:
            fields = {name: value for name, value in copy.__dict__.items() if name in type(self).model_fields}
            object.__setattr__(copy, "__dict__", fields)
        return copy

    def _unit(self, field: str, key: str = "") -> str:
        """Return the unit of a field, or of the entry `key` of a mapping."""
        return field_unit(type(self).__name__, field)

    @spoken
    def summary(self) -> str:
        """Return a table in plain text."""
        return text_table(HEADER, rows(self), title=type(self).__name__)

    @spoken
    def __repr__(self) -> str:
        return one_line(self)

    def __str__(self) -> str:
        return repr(self)

    @spoken
    def _repr_html_(self) -> str:
        return html_table(HEADER, rows(self), title=type(self).__name__)

    def to_dict(self) -> dict[str, Any]:
        """Return all fields as plain dictionaries, lists, strings and numbers, ready for ``json.dumps``."""
        return self.model_dump(mode="json")

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Self:
        """Make the model again from what `to_dict` gave; InputError names the field that is wrong."""
        try:
            return cls.model_validate_json(json.dumps(values))
        except TypeError as error:
            raise InputError(
                f"{cls.__name__}: the dictionary is not plain ({error})", "Give it as to_dict() returns it."
            ) from None

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return False
        return all(_same(getattr(self, f), getattr(other, f)) for f in type(self).model_fields)

    def __hash__(self) -> int:
        return hash((type(self), tuple(_hashable(getattr(self, f)) for f in type(self).model_fields)))
