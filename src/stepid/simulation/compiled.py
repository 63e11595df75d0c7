"""The way to numba: what is compiled where numba is there, and plain Python where it is not."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from typing import Any

Address = Any  # of a compiled law, or the Python function itself


def _numba() -> Any:
    """Numba, or None where it is switched off or missing."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return None
    try:
        import numba
    except ImportError as error:
        warnings.warn(
            f"numba cannot be imported ({error}): simulations run as plain Python, hundreds of times slower. "
            "Install numba for this Python.",
            RuntimeWarning,
            stacklevel=2,
        )
        return None
    return numba


numba = _numba()
JIT = numba is not None

if numba is None:

    def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
        """Leave a function as it is."""
        return function

    compiled_sums = inlined = compiled

    def call(
        law: Address, kind: int, q: Any, values: int, m: Any, y: Any, own: int, sides: Any, side: int, out: Any
    ) -> float:
        """Ask a law."""
        return float(law(kind, q[values:], m, y, y[own:], sides[side:], out))

else:
    from llvmlite import ir
    from numba.extending import intrinsic

    def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
        """Compile a function at its first call; keep the machine code in numba's cache where one can be written."""
        return _compiled(function, {})

    def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
        """Compile a function into those that call it: what each stage of a step asks costs as much to call as to do."""
        return _compiled(function, {"forceinline": True})

    def compiled_sums(function: Callable[..., Any]) -> Callable[..., Any]:
        """Compile a function likewise; its sums may be taken in any order."""
        return _compiled(function, {"fastmath": {"reassoc", "contract"}})

    def _compiled(function: Callable[..., Any], more: dict[str, Any]) -> Any:
        options = {"nogil": True, "error_model": "numpy"} | more
        if function.__name__.startswith("_"):  # called by compiled functions only
            options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        try:
            return numba.njit(cache=True, **options)(function)
        except RuntimeError:
            return numba.njit(**options)(function)

    @intrinsic
    def call(
        context: Any,
        law: Any,
        kind: Any,
        q: Any,
        values: Any,
        m: Any,
        y: Any,
        own: Any,
        sides: Any,
        side: Any,
        out: Any,
    ) -> Any:
        """Ask a law by its address: double law(kind, p*, m*, y*, own*, sides*, out*)."""
        signature = numba.types.float64(law, kind, q, values, m, y, own, sides, side, out)

        def generate(target: Any, builder: Any, types: Any, args: Any) -> Any:
            number = ir.DoubleType()
            pointer = number.as_pointer()
            kind_of = ir.FunctionType(number, [ir.IntType(64)] + [pointer] * 6)
            function = builder.inttoptr(args[0], kind_of.as_pointer())

            def data(i: int, skip: int | None = None) -> Any:
                array = target.make_array(types.args[i])(target, builder, args[i]).data
                return array if skip is None else builder.gep(array, [args[skip]])

            given = [args[1], data(2, 3), data(4), data(5), data(5, 6), data(7, 8), data(9)]
            return builder.call(function, given)

        return signature, generate
