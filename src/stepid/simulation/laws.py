"""The law of one effect as the kernel calls it: one function of a fixed signature, compiled once and kept on disk.

The machine code's key is what the law does (`stepid.simulation.fingerprint`), so that a changed law is compiled anew,
also where its class is the same as before, and one that moved to another module.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
import tempfile
import warnings
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from stepid.effects.base import Effect, Moment
from stepid.errors import InputError
from stepid.simulation.compiled import Address, numba
from stepid.simulation.fingerprint import fingerprint
from stepid.simulation.kernel import AT_REST, BREAKAWAY, DELAY, EVALUATE, KINK, READING, RELAX, REMEMBER, SWITCHES

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
    "kink",
)
_HOW = {"at_rest": "p, x, volts", "remember": "p, memory, shift, sign", "delay": "p", "reading": "p, time"}
_HOW |= {"relax": "p, m, time"}  # arguments, where they are not p and m
_PAGE = "see docs/how-to/own-effect.md"
_VERSION = 2  # of what is written below


def changes(effect: Effect, method: str) -> bool:
    """Whether an effect defines a method of its own."""
    return getattr(type(effect), method) is not getattr(Effect, method)


def defined(effect: Effect) -> tuple[str, ...]:
    """Methods of the law that an effect defines."""
    return tuple(name for name in _METHODS if changes(effect, name))


def source(effect: Effect, methods: Iterable[str]) -> str:
    """Python source of the law that the kernel calls; kinds and the places in `m` are those of the kernel.

    Parameters
    ----------
    effect : Effect
    methods : iterable of str
        What of its law is written; the rest is left as for the linear plant.

    Returns
    -------
    str
    """
    n_values = len(effect.parameters) + len(effect.run_parameters)
    n_extra, n_own = effect.n_extra, effect.n_extra + effect.n_memory
    sides, extra = _tuple("sides", 0, effect.n_switches), _tuple("own", 0, n_extra)
    memory = _tuple("own", n_extra, n_own)
    has = set(methods)
    arguments = {"remember": f"p, {memory}, m[7], m[0]", "relax": "p, moment, m[7]", "at_rest": "p, y[0], m[5]"}
    arguments |= {"delay": "p", "reading": "p, m[1]"}
    calls = {name: f"{name}({arguments.get(name, 'p, moment')})" for name in _METHODS if name in has}
    answers = {
        EVALUATE: [
            f"out[0] = {calls.get('force', '0.0')}",
            f"out[1] = {calls.get('friction', '0.0')}",
            f"out[2] = {calls.get('drive', 'm[5]')}",
            *(_written(calls.get("rates"), n_extra, first=3) or _zeros(n_extra, first=3)),
        ],
        SWITCHES: _written(calls.get("switches"), effect.n_switches),
        BREAKAWAY: _returned(calls.get("breakaway", calls.get("friction", "0.0"))),
        REMEMBER: _written(calls.get("remember", memory), effect.n_memory),
        RELAX: _written(calls.get("relax"), n_extra),
        AT_REST: _written(calls.get("at_rest"), n_own) or _zeros(n_own),
        DELAY: _returned(calls.get("delay")),
        READING: _returned(calls.get("reading")),
        KINK: _returned(calls.get("kink")),
    }
    lines = [
        "def law(kind, values, m, y, own, sides, out):",
        f"    p = {_tuple('values', 0, n_values)}",
        f"    moment = Moment(y[0], y[1], m[0], m[1], m[2], m[3], m[4], m[5], "
        f"{sides}, {extra}, {memory}, m[6], m[9], m[10])",
    ]
    for kind, answer in answers.items():
        if answer:
            ending = [] if answer[-1].startswith("return") else ["return 0.0"]
            lines += [f"    if kind == {kind}:", *(f"        {line}" for line in (*answer, *ending))]
    return "\n".join([*lines, "    return 0.0", ""])


def _tuple(array: str, first: int, end: int) -> str:
    """A tuple of an array's numbers from `first` to before `end`."""
    return "(" + "".join(f"{array}[{j}], " for j in range(first, end)) + ")"


def _written(call: str | None, count: int, *, first: int = 0) -> list[str]:
    """Lines that write the values of a call to `out`, from `first` on; none where there is no call."""
    return [f"found = {call}", *(f"out[{first + j}] = found[{j}]" for j in range(count))] if call else []


def _zeros(count: int, *, first: int = 0) -> list[str]:
    return [f"out[{first + j}] = 0.0" for j in range(count)]


def _returned(call: str | None) -> list[str]:
    return [f"return {call}"] if call else []


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


_known: dict[object, Address] = {}


def law(effect: Effect) -> Address:
    """The law of an effect, as the kernel takes it.

    Raises
    ------
    stepid.errors.InputError
        If a method of the effect is no static method (as in stepid 0.1), is missing, or cannot be compiled.
    """
    _check(effect)
    names = defined(effect)
    text = source(effect, names)
    methods = {name: getattr(type(effect), name) for name in names}
    if numba is None:
        key: object = (text, *methods.values())
        if key not in _known:
            _known[key] = _python_law(effect, text, methods)
        return _known[key]
    digest = hashlib.sha256(f"{_VERSION}\n{Moment._fields}\n{text}".encode())
    for name in names:
        digest.update(fingerprint(methods[name]))
    if digest.digest() not in _known:
        _known[digest.digest()] = _compiled_law(effect, text, methods, digest.hexdigest()[:24])
    return _known[digest.digest()].address


def _check(effect: Effect) -> None:
    for name in (*_METHODS, "memory_slopes"):
        if not isinstance(next(vars(k)[name] for k in type(effect).__mro__ if name in vars(k)), staticmethod):
            raise InputError(
                f"the effect {effect.name!r} is written as for stepid 0.1: its method {name!r} is no static method",
                f"Write it for plain numbers: @staticmethod, def {name}({_HOW.get(name, 'p, m')}); {_PAGE}.",
            )
    if effect.n_switches and not changes(effect, "switches"):
        raise InputError(
            f"the effect {effect.name!r} has n_switches = {effect.n_switches} and no method 'switches'",
            f"Write it: @staticmethod, def switches(p, m), a tuple of {effect.n_switches}; {_PAGE}.",
        )


def _python_law(effect: Effect, text: str, methods: dict[str, Any]) -> Address:
    space: dict[str, Any] = {"Moment": Moment, **methods}
    exec(compile(text, f"<law of {effect.name}>", "exec"), space)
    return space["law"]


def _compiled_law(effect: Effect, text: str, methods: dict[str, Any], key: str) -> Address:
    folder = cache_folder()
    path = Path(f"<law of {effect.name}>")
    if folder is not None:
        path = folder / f"{re.sub(r'[^A-Za-z0-9]', '_', effect.name)[:60]}_{key}.py"
        if not path.exists():
            whole = path.with_suffix(f".{os.getpid()}")
            folder.mkdir(parents=True, exist_ok=True)  # it may have been cleared since
            whole.write_text(text, encoding="utf-8")
            whole.replace(path)
    try:
        return _compile(text, methods, path, keep=folder is not None)
    except numba.core.errors.NumbaError as error:
        name, reason = _culprit(effect, methods, error)
        raise InputError(
            f"the effect {effect.name!r} cannot be compiled: its method {name!r} ({reason})",
            f"Write it in plain numbers, tuples and functions of math; {_PAGE}.",
        ) from error


def _compile(text: str, methods: dict[str, Any], path: Path, *, keep: bool) -> Any:
    space: dict[str, Any] = {"__name__": __name__, "Moment": Moment}
    space |= {name: f if hasattr(f, "py_func") else numba.njit(f) for name, f in methods.items()}
    exec(compile(text, str(path), "exec"), space)
    number, many = numba.types.float64, numba.types.CPointer(numba.types.float64)
    signature = number(numba.types.int64, many, many, many, many, many, many)
    try:
        return numba.cfunc(signature, cache=keep, error_model="numpy")(space["law"])
    except ImportError:  # kept machine code asks for the module of its methods, which has no file that Python finds
        return numba.cfunc(signature, error_model="numpy")(space["law"])


def _culprit(effect: Effect, methods: dict[str, Any], error: Exception) -> tuple[str, str]:
    """Method that cannot be compiled, each being tried on its own, and what numba says of it."""
    for name, method in methods.items():
        try:
            _compile(source(effect, (name,)), {name: method}, Path(f"<{name} of {effect.name}>"), keep=False)
        except numba.core.errors.NumbaError as own:
            return name, _reason(own)
    return "law", _reason(error)


def _reason(error: Exception) -> str:
    lines = (line.strip() for line in re.sub(r"\x1b\[[0-9;]*m", "", str(error)).splitlines())
    return next((line[:160] for line in lines if line and not line.startswith("Failed in")), type(error).__name__)
