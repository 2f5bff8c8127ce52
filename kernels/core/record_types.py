"""How kernels hold records of arrays: by a pointer, whose fields are loaded where they are used.

Numba holds a NamedTuple by value, and passes it as all the numbers in it: hundreds for a scene, and
each takes instructions on both sides of every call, which take time to compile.

A record that a scene lacks is None, and Numba leaves out what would use it; or, where kernels are
to serve scenes with and without it, it is `absent`: a null pointer, which `is None` at run time.
"""

import hashlib
import operator
from collections import namedtuple
from collections.abc import Collection
from functools import cache
from types import NoneType
from typing import Any, TypeVar, get_args

from llvmlite import ir
from numba import config
from numba.core import cgutils, types
from numba.extending import (
    NativeValue,
    lower_builtin,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)

Record = TypeVar("Record", bound=type)


class RecordType(types.NamedTuple):
    """A NamedTuple that Python makes and kernels only read."""

    _hash: int | None = None

    def __hash__(self) -> int:
        """Return the hash of all fields, which compiling asks for all the time; computed once."""
        if self._hash is None:
            self._hash = super().__hash__()
        return self._hash

    def __getstate__(self) -> dict[str, Any]:
        """Return what is saved: hashes are of one process."""
        return {name: value for name, value in vars(self).items() if name != "_hash"}

    @property
    def mangling_args(self) -> tuple[str, tuple[()]]:
        """What stands for the type in names of functions: all fields took thousands of letters."""
        digest = hashlib.sha256(self.name.encode()).hexdigest()
        return f"{self.instance_class.__name__}.{digest[:16]}", ()


def by_reference(record: Record) -> Record:
    """Have kernels hold a class of NamedTuples by a pointer. They cannot make or return any.

    Its annotations are Numba's types, `int`, `float`, and records, which may be `| None`.
    """
    typeof_impl.register(record)(_typeof)
    return record


def with_absent(record: Any, without: Collection[str] = ()) -> Any:
    """Return a record in which those that are None, at any depth, are `absent`.

    Those whose names are in `without` stay None; all do in plain Python.
    """
    if config.DISABLE_JIT or not _is_record(type(record)):
        return record
    changed = {}
    for name, kind in record.__annotations__.items():
        value = getattr(record, name)
        if value is not None:
            value = with_absent(value, without)
        elif name not in without and (optional := _optional(kind)):
            value = absent(optional)
        if value is not getattr(record, name):
            changed[name] = value
    return record._replace(**changed) if changed else record


@cache
def absent(record: type) -> tuple[()] | None:
    """Return what stands for a record of a class: an empty tuple of its own; in plain Python, None.

    A named tuple: for these, Numba has a fast way from a value to its type.
    """
    if config.DISABLE_JIT:
        return None
    fields = [_declared(kind) for kind in record.__annotations__.values()]
    kind, stand_in = RecordType(fields, record), namedtuple(f"No{record.__name__}", ())
    typeof_impl.register(stand_in)(lambda value, context: kind)
    return stand_in()


@cache
def _is_record(kind: type) -> bool:
    return typeof_impl.dispatch(kind) is _typeof


@cache
def _optional(kind: Any) -> Any:
    """Return the record of an annotation `record | None`, None for others."""
    parts = [part for part in get_args(kind) if part is not NoneType]
    return parts[0] if len(parts) == 1 and _is_record(parts[0]) else None


_SCALARS = {int: types.int64, float: types.float64, bool: types.boolean}


def _declared(kind: Any) -> types.Type:
    """Return Numba's type of what an annotation describes."""
    record = _optional(kind) or (kind if hasattr(kind, "_fields") else None)
    return typeof_impl(absent(record), None) if record else _SCALARS.get(kind, kind)


@lower_builtin(operator.is_, RecordType, types.NoneType)
def _is_absent(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return cgutils.is_null(builder, arguments[0])


def _typeof(value: tuple[Any, ...], context: object) -> RecordType:
    return RecordType([typeof_impl(field, context) for field in value], type(value))


@register_model(RecordType)
class _RecordModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: RecordType) -> None:
        fields = [manager.lookup(field).get_value_type() for field in kind.types]
        super().__init__(manager, kind, ir.LiteralStructType(fields).as_pointer())


@lower_getattr_generic(RecordType)
def _load_field(context: Any, builder: Any, kind: RecordType, record: Any, name: str) -> Any:
    pointer = cgutils.gep_inbounds(builder, record, 0, kind.fields.index(name))
    field = builder.load(pointer)
    field.set_metadata("invariant.load", builder.module.add_metadata([]))
    return field


@unbox(RecordType)
def _unbox(kind: RecordType, value: Any, c: Any) -> NativeValue:
    """Lay a record out on the stack of the function that Python calls; null if it is absent."""
    record = cgutils.alloca_once(c.builder, c.context.get_value_type(kind).pointee)
    pointer = cgutils.alloca_once_value(c.builder, cgutils.get_null_value(record.type))
    failed = cgutils.alloca_once_value(c.builder, cgutils.false_bit)
    with c.builder.if_then(cgutils.is_not_null(c.builder, c.pyapi.tuple_size(value))):
        c.builder.store(record, pointer)
        for index, field in enumerate(kind.types):
            native = c.unbox(field, c.pyapi.tuple_getitem(value, index))
            c.builder.store(native.value, cgutils.gep_inbounds(c.builder, record, 0, index))
            with c.builder.if_then(native.is_error, likely=False):
                c.builder.store(cgutils.true_bit, failed)
    return NativeValue(c.builder.load(pointer), is_error=c.builder.load(failed))
