#!/usr/bin/env python3
"""psim from Python with nothing but the standard library: python_ctypes.py [FILE of libpsim.so]."""
import ctypes as c
import sys

LIBRARY = sys.argv[1] if len(sys.argv) > 1 else "libpsim.so.0.1"
try:
    psim = c.CDLL(LIBRARY)
except OSError as error:
    sys.exit(f"{error}; name the library: python_ctypes.py build/release/libpsim.so (or set LD_LIBRARY_PATH)")


class Column(c.Structure):
    _fields_ = [("data", c.c_void_p), ("stride", c.c_size_t)]


class DiscBatch(c.Structure):  # psim_disc_batch, field by field
    _fields_ = ([("struct_size", c.c_uint32), ("type", c.c_int32), ("count", c.c_size_t)]
                + [(name, Column) for name in ("x", "y", "radius", "angle", "vx", "vy", "omega")]
                + [("common_radius", c.c_double), ("density", c.c_double),
                   ("restitution", c.c_double), ("friction", c.c_double), ("mass", c.c_double),
                   ("gravity_scale", c.c_double), ("fixed_rotation", c.c_int32),
                   ("bullet", c.c_int32), ("category", c.c_uint32), ("mask", c.c_uint32),
                   ("group", c.c_int32), ("reserved", c.c_int32)])


class State(c.Structure):  # psim_state
    _fields_ = ([("struct_size", c.c_uint32), ("reserved", c.c_uint32), ("count", c.c_size_t),
                 ("id", c.POINTER(c.c_uint32))]
                + [(n, c.POINTER(c.c_double)) for n in ("x", "y", "angle", "vx", "vy", "omega",
                                                        "radius")]
                + [("type", c.POINTER(c.c_uint8))])


WORLD_DESC, DISC_BATCH, STATE = 1, 4, 12  # psim_struct


def init(struct, kind):
    """What psim_NAME_init does in C: the defaults, and the size that this program knows."""
    psim.psim_init(c.byref(struct), kind, c.sizeof(struct))
    return struct


def call(name, *arguments):
    if (result := getattr(psim, name)(world, *arguments)) < 0:
        line = c.create_string_buffer(256)
        psim.psim_last_error(world, line, c.c_size_t(256))
        raise RuntimeError(line.value.decode() or f"{name}: result {result}")


def doubles(values):
    return (c.c_double * len(values))(*values)


psim.psim_version.restype = c.c_char_p
world, error = c.c_void_p(), c.create_string_buffer(256)
desc = init(c.create_string_buffer(136), WORLD_DESC)  # the defaults are all that is wanted
if psim.psim_world_create(desc, None, c.byref(world), error, c.c_size_t(256)) < 0:
    sys.exit(error.value.decode())

n = 1000
batch = init(DiscBatch(), DISC_BATCH)
x, y = doubles([k % 40 * 1.1 for k in range(n)]), doubles([k // 40 * 1.1 for k in range(n)])
batch.count, batch.x.data, batch.y.data = n, c.addressof(x), c.addressof(y)
call("psim_world_add_discs", c.byref(batch), None)
for frame in range(60):
    call("psim_world_step", None)

state = init(State(), STATE)
call("psim_world_state", c.byref(state))  # pointers into psim, valid until the next step
mean = sum(state.y[:state.count]) / state.count - sum(y) / n
print(f"psim {psim.psim_version().decode()}: {state.count} discs fell {-mean:.3f} m in a second")
psim.psim_world_destroy(world)
