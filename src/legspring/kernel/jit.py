"""The four ways in which this package compiles: all release Python's lock and use fused multiply-adds.

Division by zero gives infinity, as in NumPy, so that loops stay free of branches. Numba counts references to arrays
at every call, at the cost of several right-hand sides a call: what does not make arrays goes without. Nor is there
machine code for calls from Python, which takes long to compile, but for what Python calls.

What Python calls must return numbers, arrays and plain tuples of them only. A named tuple is made by running Python,
in which a signal (Ctrl-C) may raise; compiled code does not look, and crashes.
"""

import ctypes
import gc
import hashlib
import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba
import numba.extending
from llvmlite import binding
from numba.core import cgutils, config, serialize
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

from legspring.kernel.cache import check_compiler, keep

P = ParamSpec("P")
R = TypeVar("R")

# Where inlining is not forbidden, numba takes it over from the caller.
OPTIONS = {"nogil": True, "forceinline": False, "error_model": "numpy", "fastmath": {"contract", "nsz", "arcp"}}
INNER = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}
njit: Any = numba.njit  # its types leave out some of its options
tools: Any = cgutils
linker: Any = binding
settings: Any = config
intrinsic: Any = numba.extending.intrinsic
typeof: Any = numba.typeof
check_compiler()
# Where compiled code hands an array to Python, Numba looks up what it knows by this function, in Python: the one place
# left for a signal to raise where nobody looks, so that it comes out as a SystemError. A cache written in C is none.
if hasattr(serialize, "_numba_unpickle"):
    serialize._numba_unpickle = cache(serialize._numba_unpickle)


SOURCES = sorted(Path(__file__).parent.glob("*.py"))
FINGERPRINT = hashlib.sha256(b"\0".join(path.read_bytes() for path in SOURCES)).hexdigest()


def kept(compiled: Any) -> Any:
    """Keep machine code on disk for as long as no file of the kernel changes.

    Numba looks at a function's own file only, and would go on using old code of the functions that it calls; this puts
    all files in the place of that one.
    """
    keep(compiled, FINGERPRINT)
    return compiled


def refuse(*_: Any) -> None:
    """Say what is wrong; Python raises SystemError after that."""
    raise TypeError("only compiled functions can call this one")


REFUSAL = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)(refuse)
MANGLED = "_ZN"
"""With this begin the names of functions that numba compiles."""


class Ingredient(JITCodeLibrary):
    """A function as LLVM has it, to be linked into its callers and optimised there: it gets no machine code.

    That code would never be called, and took a third of all the time to compile.
    """

    def add_ir_module(self, module: Any) -> None:
        """Take in the function; where it is not to be inlined, LLVM is not to do so either."""
        for function in module.functions:
            inlined = "alwaysinline" in function.attributes
            if function.name.startswith(MANGLED) and not function.is_declaration and not inlined:
                function.attributes.add("noinline")
        super().add_ir_module(module)  # type: ignore[no-untyped-call]

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True

    def get_pointer_to_function(self, _: str) -> int | None:
        """Return what Python finds in the place of the function."""
        return ctypes.cast(REFUSAL, ctypes.c_void_p).value

    @property
    def codegen(self) -> Any:
        """Where `set_env` is looked for."""
        return self

    def set_env(self, *_: Any) -> None:
        """There is no code that needs an environment."""


class InnerPipeline(Compiler):
    """The way to such a function."""

    def define_pipelines(self) -> Any:
        """Take numba's way, with another library at its end."""
        state: Any = self.state
        state.library = Ingredient(state.targetctx.codegen(), state.func_id.func_qualname)  # type: ignore[no-untyped-call]
        return super().define_pipelines()  # type: ignore[no-untyped-call]


@contextmanager
def no_collection() -> Iterator[None]:
    """Keep Python from looking for garbage: compilers make a great many objects that stay, and it takes an eighth."""
    usual = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if usual:
            gc.enable()


def driver(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that Python calls; only such a one can make arrays."""
    compiled: Any = kept(njit(**OPTIONS)(function))
    by_numba = compiled.compile

    def compile_or_load(signature: Any) -> Any:
        for stock in STOCK:
            stock.provide()
        with no_collection():
            return by_numba(signature)

    compiled.compile = compile_or_load
    result: Callable[P, R] = compiled
    return result


def jit(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that only works on arrays that it is given, and that only compiled functions call."""
    compiled: Callable[P, R] = njit(pipeline_class=InnerPipeline, **INNER, **OPTIONS)(function)
    return compiled


def formula(function: Callable[P, R]) -> Callable[P, R]:
    """Compile such a function into its callers, where it costs no call."""
    compiled: Callable[P, R] = njit(pipeline_class=InnerPipeline, **INNER, **OPTIONS | {"forceinline": True})(function)
    return compiled


class Shared:
    """A function that is compiled once, and whose machine code all its callers share.

    Numba would copy it, and all that it calls, into each of them. These callers know it by a name instead, which stands
    for its address in this process only, so that their machine code may be kept on disk. It is compiled, or loaded, and
    its name made known, before a caller is. LLVM makes vector instructions of what it does four times in a row.
    """

    def __init__(self, function: Callable[..., Any], result: Any, arguments: tuple[Any, ...]) -> None:
        self.compiled = kept(njit(**INNER, **OPTIONS)(function))
        self.name = f"legspring.{function.__name__}.{FINGERPRINT}"
        self.result, self.arguments = result, arguments
        self.provided = False

    def provide(self) -> None:
        """Make the function's name known to the linker."""
        if not self.provided:
            usual, settings.SLP_VECTORIZE = settings.SLP_VECTORIZE, 1
            try:
                with no_collection():
                    self.compiled.compile(self.arguments)
            finally:
                settings.SLP_VECTORIZE = usual
            made = self.compiled.overloads[self.arguments]
            linker.add_symbol(self.name, made.library.get_pointer_to_function(made.fndesc.llvm_func_name))
            self.provided = True

    def call(self, context: Any, builder: Any, _: Any, values: Any) -> Any:
        """Write a call of it."""
        convention = context.call_conv
        kind = convention.get_function_type(self.result, self.arguments)
        function = tools.get_or_insert_function(builder.module, kind, self.name)
        status, result = convention.call_function(builder, function, self.result, self.arguments, values)
        with tools.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return result


STOCK: list[Shared] = []
"""All shared functions."""


def shared(result: Any, *arguments: Any) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Compile a function like `jit`, but once, for arguments and a result of these types: see `Shared`."""

    def share(function: Callable[P, R]) -> Callable[P, R]:
        stock = Shared(function, result, arguments)
        STOCK.append(stock)

        def write_call(_: Any, *__: Any) -> Any:
            stock.provide()
            return stock.result(*stock.arguments), stock.call

        written: Any = write_call
        context = inspect.Parameter("context", inspect.Parameter.POSITIONAL_ONLY)
        parameters = inspect.signature(function).parameters.values()
        written.__signature__ = inspect.Signature([context, *parameters])
        call: Callable[P, R] = intrinsic(write_call)
        return call

    return share
