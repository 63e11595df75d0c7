"""What a function does, as a hash: the key under which its machine code is kept."""

from __future__ import annotations

import hashlib
import types
from collections.abc import Callable
from typing import Any

import numpy as np


def fingerprint(function: Callable[..., Any]) -> bytes:
    """Hash of a function's byte code and module, of the values that it names, and of the functions that it calls.

    Parameters
    ----------
    function : callable
        A Python function, or one that numba has compiled.

    Returns
    -------
    bytes
        Equal for functions that do the same by the same code in modules of the same names, in every process.
    """
    python: types.FunctionType = getattr(function, "py_func", function)  # type: ignore[arg-type]
    return _function(python, set())


def _function(function: types.FunctionType, known: set[int]) -> bytes:
    known.add(id(function))
    code = function.__code__
    names = _names(code)
    where = str(function.__module__).encode()  # kept machine code imports it
    parts = [where, _code(code), repr((function.__defaults__, function.__kwdefaults__)).encode()]
    named = {name: function.__globals__.get(name) for name in names}
    cells = (cell.cell_contents for cell in function.__closure__ or ())
    named |= dict(zip(code.co_freevars, cells, strict=True))
    parts += [name.encode() + b"=" + _value(named[name], names, known) for name in sorted(named)]
    return hashlib.sha256(b"\0".join(parts)).digest()


def _code(code: types.CodeType) -> bytes:
    parts = [code.co_code, repr((code.co_names, code.co_varnames, code.co_freevars)).encode()]
    for constant in code.co_consts:
        parts.append(_code(constant) if isinstance(constant, types.CodeType) else repr(constant).encode())
    return b"\0".join(parts)


def _value(value: object, names: set[str], known: set[int]) -> bytes:
    """What a name stands for; of a module or a class, what `names` may ask of it."""
    value = getattr(value, "py_func", value)
    if isinstance(value, types.FunctionType) or callable(value):
        where = f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', repr(value))}".encode()
        if where.startswith((b"numpy.", b"math.", b"builtins.")) or id(value) in known:
            return where
        if isinstance(value, types.FunctionType):
            return _function(value, known)
    if isinstance(value, types.ModuleType | type):
        if id(value) in known or value.__name__ in ("math", "numpy"):
            return value.__name__.encode()
        known.add(id(value))
        asked = sorted(name for name in names if hasattr(value, name))
        inside = [name.encode() + b"=" + _value(getattr(value, name), names, known) for name in asked]
        return b"\0".join([value.__name__.encode(), *inside])
    if isinstance(value, np.ndarray):
        return repr((value.shape, value.dtype)).encode() + value.tobytes()
    return repr(value).encode()


def _names(code: types.CodeType) -> set[str]:
    """Every name that a function may look up."""
    found = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            found |= _names(constant)
    return found
