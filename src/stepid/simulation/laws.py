"""The law of one effect as the kernel calls it: one function of a fixed signature, compiled once and kept on disk.

The machine code's key is what the law does (its byte code and that of what it calls), so that a changed law is compiled
anew, wherever it is written.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
import types
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from stepid.effects.base import Effect, Moment
from stepid.errors import InputError
from stepid.simulation.compiled import Address, numba

_METHODS = (
    "force",
    "friction",
    "drive",
    "rates",
    "switches",
    "breakaway",
    "remember",
    "relax",
    "at_rest",
    "delay",
    "reading",
)
_VERSION = 1  # of what is written below


def changes(effect: Effect, method: str) -> bool:
    """Whether an effect defines a method of its own."""
    return getattr(type(effect), method) is not getattr(Effect, method)


def source(effect: Effect) -> str:
    """Python source of the law that the kernel calls, see the order of `stepid.simulation.kernel.EVALUATE`."""
    n_values = len(effect.parameters) + len(effect.run_parameters)
    own = [f"own[{j}]" for j in range(effect.n_extra + effect.n_memory)]
    sides = [f"sides[{j}]" for j in range(effect.n_switches)]
    has = {name: changes(effect, name) for name in _METHODS}

    def row(items: list[str]) -> str:
        return "(" + "".join(f"{item}, " for item in items) + ")"

    def write(values: str, count: int, first: int = 0) -> list[str]:
        return [f"found = {values}", *(f"out[{first + j}] = found[{j}]" for j in range(count))]

    breakaway = next((f"{name}(p, moment)" for name in ("breakaway", "friction") if has[name]), "0.0")
    extra, memory = row(own[: effect.n_extra]), row(own[effect.n_extra :])
    answers: list[list[str]] = [
        [
            f"out[0] = {'force(p, moment)' if has['force'] else '0.0'}",
            f"out[1] = {'friction(p, moment)' if has['friction'] else '0.0'}",
            f"out[2] = {'drive(p, moment)' if has['drive'] else 'm[5]'}",
            *(
                write("rates(p, moment)", effect.n_extra, 3)
                if has["rates"]
                else [f"out[{3 + j}] = 0.0" for j in range(effect.n_extra)]
            ),
        ],
        write("switches(p, moment)", effect.n_switches) if effect.n_switches else [],
        [f"return {breakaway}"],
        write(f"remember(p, {memory}, m[7], m[0])", effect.n_memory) if effect.n_memory else [],
        write("relax(p, moment, m[7])", effect.n_extra) if has["relax"] else [],
        write("at_rest(p, y[0], m[5])", len(own)) if has["at_rest"] else [f"out[{j}] = 0.0" for j in range(len(own))],
        ["return delay(p)"] if has["delay"] else [],
        ["return reading(p, m[1])"] if has["reading"] else [],
    ]
    lines = [
        "def law(kind, values, m, y, own, sides, out):",
        f"    p = {row([f'values[{j}]' for j in range(n_values)])}",
        f"    moment = Moment(y[0], y[1], m[0], m[1], m[2], m[3], m[4], m[5], "
        f"{row(sides)}, {extra}, {memory}, m[6], m[9], m[10])",
    ]
    for kind, answer in enumerate(answers):
        if answer:
            lines += [f"    if kind == {kind}:", *(f"        {line}" for line in answer)]
            lines += ["        return 0.0"] if not answer[-1].startswith("return") else []
    return "\n".join([*lines, "    return 0.0", ""])


def _fingerprint(function: Callable[..., Any], known: set[int]) -> bytes:
    """What a function does: its code, and that of the functions and the values that it names."""
    parts: list[bytes] = []

    def code(c: types.CodeType) -> None:
        parts.extend([c.co_code, repr(c.co_names).encode(), repr(c.co_varnames).encode()])
        for constant in c.co_consts:
            if isinstance(constant, types.CodeType):
                code(constant)
            else:
                parts.append(repr(constant).encode())

    code(function.__code__)
    parts.append(repr(function.__defaults__).encode())
    named = {n: function.__globals__.get(n) for n in _names(function.__code__)}
    named |= dict(
        zip(function.__code__.co_freevars, (c.cell_contents for c in function.__closure__ or ()), strict=True)
    )
    for name, value in sorted(named.items()):
        inner = getattr(value, "py_func", value)
        if isinstance(inner, types.FunctionType):
            if id(inner) not in known:
                known.add(id(inner))
                parts.append(_fingerprint(inner, known))
        elif not isinstance(inner, types.ModuleType):
            parts.append(f"{name}={inner!r}".encode())
    return hashlib.sha256(b"\0".join(parts)).digest()


def _names(code: types.CodeType) -> set[str]:
    found = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            found |= _names(constant)
    return found


@cache
def cache_folder() -> Path | None:
    """Folder in which compiled laws are kept, None where none can be written (said once)."""
    home = Path.home()
    if os.environ.get("NUMBA_CACHE_DIR"):
        base = Path(os.environ["NUMBA_CACHE_DIR"])
    elif sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local"))
    elif sys.platform == "darwin":
        base = home / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
    folder = base / "stepid"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        warnings.warn(
            f"no cache for compiled laws can be written in {folder} ({error.strerror}): they are compiled in every "
            "process. Set NUMBA_CACHE_DIR to a folder of yours.",
            RuntimeWarning,
            stacklevel=2,
        )
        return None


_known: dict[type[Effect], Address] = {}


def law(effect: Effect) -> Address:
    """The law of an effect, as the kernel takes it.

    Raises
    ------
    stepid.errors.InputError
        If a method of the effect cannot be compiled.
    """
    kind = type(effect)
    if kind not in _known:
        _known[kind] = _python_law(effect) if numba is None else _compiled_law(effect)
    return _known[kind].address if numba is not None else _known[kind]


def _python_law(effect: Effect) -> Address:
    space: dict[str, Any] = {"Moment": Moment} | {name: getattr(effect, name) for name in _METHODS}
    exec(compile(source(effect), f"<law of {effect.name}>", "exec"), space)
    return space["law"]


def _compiled_law(effect: Effect) -> Address:
    text = source(effect)
    methods = {name: getattr(type(effect), name) for name in _METHODS if changes(effect, name)}
    digest = hashlib.sha256(f"{_VERSION}\n{text}".encode())
    for name in sorted(methods):
        digest.update(_fingerprint(methods[name], set()))
    folder = cache_folder()
    path = Path(f"<law of {effect.name}>")
    if folder is not None:
        path = folder / f"{effect.name}_{digest.hexdigest()[:24]}.py"
        if not path.exists():
            whole = path.with_suffix(f".{os.getpid()}")
            whole.write_text(text, encoding="utf-8")
            whole.replace(path)
    space: dict[str, Any] = {"__name__": __name__, "Moment": Moment} | {
        name: numba.njit(f) for name, f in methods.items()
    }
    exec(compile(text, str(path), "exec"), space)
    number, many = numba.types.float64, numba.types.CPointer(numba.types.float64)
    signature = number(numba.types.int64, many, many, many, many, many, many)
    try:
        return numba.cfunc(signature, cache=folder is not None, error_model="numpy")(space["law"])
    except numba.core.errors.NumbaError as error:
        raise InputError(
            f"the effect {effect.name!r} cannot be compiled: {str(error).strip().splitlines()[-1]}",
            "Write its laws as static methods on plain numbers, see docs/how-to/own-effect.md.",
        ) from error
