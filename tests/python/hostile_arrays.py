"""Arrays of numpy in every layout, of every kind, with wrong numbers, or with more rows than there is memory."""

import tempfile

import numpy
from numpy.lib.stride_tricks import as_strided

import shapes

HUGE = 1 << 40  # rows that an array of no stride claims


def mesh(dice):
    """Vertices of a flat square, whose numbers every float has, its faces, and whether both are right."""
    flat, triangles = shapes.grid(dice.choice((1, 2, 4, 8)))
    flat, triangles = numpy.array(flat), triangles.astype(numpy.int64)
    if dice.random() < 0.6:
        return flat, triangles, True
    if dice.random() < 0.5:
        flat[dice.randrange(len(flat)), dice.randrange(3)] = dice.choice((numpy.nan, numpy.inf, -numpy.inf, 1e308,
                -1e308, 5e-324))
    else:
        wrong = (-1, len(flat), 1 << 31, (1 << 32) + 1, (1 << 63) - 1, -(1 << 63), -len(flat), 255, 65535)
        triangles[dice.randrange(len(triangles)), dice.randrange(3)] = dice.choice(wrong)
    return flat, triangles, False


# --- layouts: each gives an array with the same numbers ---------------------------------------------------------------


def every_second(array):
    large = numpy.zeros((2 * len(array), 3), array.dtype)
    large[::2] = array
    return large[::2]


def columns(array):
    large = numpy.zeros((len(array), 7), array.dtype)
    large[:, 1::2] = array
    return large[:, 1::2]


def reversed_rows(array):
    return array[::-1].copy()[::-1]


def reversed_columns(array):
    return array[:, ::-1].copy()[:, ::-1]


def unaligned(array):
    return numpy.frombuffer(b"x" + array.tobytes(), numpy.uint8)[1:].view(array.dtype).reshape(-1, 3)


def read_only(array):
    array = array.copy()
    array.flags.writeable = False
    return array


def of_a_file(array):
    with tempfile.NamedTemporaryFile(delete=False) as file:
        file.write(array.tobytes())
    return numpy.memmap(file.name, array.dtype, "r", shape=array.shape)


def of_records(array):
    records = numpy.zeros(len(array), [("skipped", "i1"), ("numbers", array.dtype, 3)])
    records["numbers"] = array
    return records["numbers"]


class Lying(numpy.ndarray):
    """A subclass that says other things of itself than its base."""

    def __len__(self):
        return 10**6

    @property
    def __array_interface__(self):
        return {"data": (8, False), "shape": (10**6, 3), "typestr": "<f8", "version": 3}


class Given:
    """An object that gives the array."""

    def __init__(self, array):
        self.array = array

    def __array__(self, dtype=None, copy=None):
        return self.array


LAYOUTS = {
    "plain": lambda array: array, "Fortran": numpy.asfortranarray, "transposed": lambda array: array.T.copy().T,
    "every second row": every_second,
    "every second column": columns, "reversed": reversed_rows, "reversed columns": reversed_columns,
    "unaligned": unaligned, "read-only": read_only,
    "of a file": of_a_file, "of records": of_records, "lying": lambda array: array.view(Lying), "given": Given,
    "a list": lambda array: array.tolist(), "tuples": lambda array: tuple(map(tuple, array.tolist())), "rows": list,
    "a matrix": lambda array: array.view(numpy.matrix),
    "swapped": lambda array: array.astype(array.dtype.newbyteorder()),
    "one row for all": lambda array: numpy.broadcast_to(array[:1], array.shape),
}
CLAIMS = {
    "claims rows": lambda array: as_strided(array, (HUGE, 3), (0, array.itemsize)),
    "claims rows backwards": lambda array: as_strided(array[-1:], (HUGE, 3), (0, array.itemsize)),
    "claims as many as bytes": lambda array: as_strided(array, (1 << 33, 3), (0, 0)),
}
NO_NUMBERS = {
    "a memory view": memoryview, "objects": lambda array: array.astype(object), "text": lambda array: array.astype(str),
    "complex": lambda array: array.astype(complex), "bool": lambda array: array > 0,
    "dates": lambda array: array.astype("int64").astype("datetime64[s]"), "a row": lambda array: array.ravel(),
    "two columns": lambda array: array[:, :2],
    "a dimension more": lambda array: array[None], "a number": lambda array: array[0, 0],
    "nothing": lambda array: array[:0, :0],
    "masked": lambda array: numpy.ma.masked_array(array, numpy.arange(array.size).reshape(array.shape) == 1),
    "void": lambda array: array.copy().view("V%d" % array.itemsize),
}
FLOATS = ("f8", "f8", "f8", "f4", "f2", "g", "i1", "i8", "u2")
INTEGERS = ("u4", "u4", "i4", "i8", "u8", "i2", "u2", "i1", "u1")


def drawn(array, kinds, dice):
    """A name, the array in some form, and a plain copy of its numbers; None: it has to be refused."""
    with numpy.errstate(all="ignore"):
        array = numpy.ascontiguousarray(array.astype(dice.choice(kinds)))
    forms = dice.choice((LAYOUTS, LAYOUTS, LAYOUTS, LAYOUTS, CLAIMS or LAYOUTS, NO_NUMBERS))
    name = dice.choice(sorted(forms))
    with numpy.errstate(all="ignore"):
        given = forms[name](array)
    name = "%s of %s" % (name, array.dtype)
    if forms is not LAYOUTS:
        return name, given, None
    return name, given, numpy.array(numpy.asarray(given.array if isinstance(given, Given) else given), order="C")


def vertices(array, dice):
    return drawn(array, FLOATS, dice)


def faces(array, dice):
    return drawn(array, INTEGERS, dice)


# --- changes ----------------------------------------------------------------------------------------------------------


def change(array, triangles, over, dice):
    """Changes numbers, shapes and types of both in place, to and fro, until it is over."""
    right = array.copy(), triangles.copy()
    while not over.is_set():
        for one, good, bad in ((array, right[0], numpy.nan), (triangles, right[1], 0xFFFF0000)):
            what = dice.randrange(5)
            if what == 0:
                one[:: dice.randrange(1, 5)] = bad
            elif what == 1:
                one.shape = dice.choice(((-1, 1), (1, -1), (-1,)))
            elif what == 2:
                one.dtype = numpy.uint8
            elif what == 3:
                one.flags.writeable = False
            one.flags.writeable = True
            one.dtype = good.dtype
            one.shape = good.shape
            one[:] = good
