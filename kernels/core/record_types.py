"""How kernels hold records of arrays: by a pointer, whose fields are loaded where they are used.

Numba holds a NamedTuple by value, and passes it as all the numbers in it: hundreds for a scene, and
each takes instructions on both sides of every call, which take time to compile.
"""

import hashlib
from typing import Any, TypeVar

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import (
    NativeValue,
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
        """What stands for the type in the names of functions.

        With all fields, names had thousands of letters, in every line that calls one.
        """
        digest = hashlib.sha256(self.name.encode()).hexdigest()
        return f"{self.instance_class.__name__}.{digest[:16]}", ()


def by_reference(record: Record) -> Record:
    """Have kernels hold a class of NamedTuples by a pointer. They cannot make or return any."""
    typeof_impl.register(record)(_typeof)
    return record


def _typeof(value: tuple[Any, ...], context: object) -> RecordType:
    return RecordType([typeof_impl(field, context) for field in value], type(value))


@register_model(RecordType)
class _RecordModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: RecordType) -> None:
        fields = [manager.lookup(field).get_value_type() for field in kind.types]
        super().__init__(manager, kind, ir.LiteralStructType(fields).as_pointer())


@lower_getattr_generic(RecordType)
def _load_field(context: Any, builder: Any, kind: RecordType, record: Any, name: str) -> Any:
    place = cgutils.gep_inbounds(builder, record, 0, kind.fields.index(name))
    field = builder.load(place)
    field.set_metadata("invariant.load", builder.module.add_metadata([]))
    return field


@unbox(RecordType)
def _unbox(kind: RecordType, value: Any, c: Any) -> NativeValue:
    """Lay a record out on the stack of the function that Python calls."""
    record = cgutils.alloca_once(c.builder, c.context.get_value_type(kind).pointee)
    failed = cgutils.alloca_once_value(c.builder, cgutils.false_bit)
    for index, field in enumerate(kind.types):
        native = c.unbox(field, c.pyapi.tuple_getitem(value, index))
        c.builder.store(native.value, cgutils.gep_inbounds(c.builder, record, 0, index))
        with c.builder.if_then(native.is_error, likely=False):
            c.builder.store(cgutils.true_bit, failed)
    return NativeValue(record, is_error=c.builder.load(failed))
