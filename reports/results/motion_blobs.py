"""Motions as stored in a result file: archives of arrays, unpacked with care.

A foreign archive may unpack to any size. So the sizes that it declares are checked against what a
motion can have before anything is unpacked, and no more bytes than declared are unpacked.
"""

import io
import zipfile
from dataclasses import fields
from typing import Any

import numpy as np

from ...scenarios import FloatArray, Trajectory
from ...scenarios.document import MAX_ROTORS, MAX_SAMPLES

#: Bytes of an array's header: magic, shape and type (numpy.lib.format).
HEADER = 1 << 10
_NAMES = tuple(field.name for field in fields(Trajectory))
#: Arrays that the motions of some scenes alone have.
_OPTIONAL = ("spins",)
#: Components of the widest of the other arrays.
_WIDEST = 4


def pack(motion: Trajectory) -> bytes:
    """A motion as an archive in numpy's format .npz, not compressed.

    Compressing takes several times as long, and motions become only a fifth smaller.
    """
    buffer = io.BytesIO()
    arrays: dict[str, Any] = {
        name: np.ascontiguousarray(values)
        for name in _NAMES
        if (values := getattr(motion, name)).size or name not in _OPTIONAL
    }
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def unpack(blob: bytes) -> Trajectory:
    """The motion in an archive.

    Raises
    ------
    ValueError
        If it is not an archive of a motion, or larger than one can be.
    zipfile.BadZipFile
        If it is damaged, by its checksums (CRC-32).
    """
    with zipfile.ZipFile(io.BytesIO(blob)) as archive:
        members = archive.infolist()
        names = [member.filename.removesuffix(".npy") for member in members]
        if sorted({*names, *_OPTIONAL}) != sorted(_NAMES) or len(set(names)) < len(members):
            raise ValueError("the archive does not hold the arrays of a motion")
        arrays = {
            member.filename.removesuffix(".npy"): _array(archive, member) for member in members
        }
    return Trajectory(**arrays)


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> FloatArray:
    widest = MAX_ROTORS if member.filename.removesuffix(".npy") in _OPTIONAL else _WIDEST
    if member.file_size > HEADER + widest * 8 * MAX_SAMPLES:
        raise ValueError(f"an array of {member.file_size} bytes, more than {MAX_SAMPLES} samples")
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError("the archive is compressed otherwise than a motion is")
    with archive.open(member) as packed:
        # One byte more than declared is an error.
        content = packed.read(member.file_size + 1)
    stream = io.BytesIO(content)
    if np.lib.format.read_magic(stream) != (1, 0):
        raise ValueError("an array of another format")
    shape, in_columns, kind = np.lib.format.read_array_header_1_0(stream)
    values = content[stream.tell() :]
    if in_columns or kind != np.float64 or len(values) != 8 * int(np.prod(shape, dtype=object)):
        raise ValueError(f"an array of type {kind} and shape {shape} in {len(values)} bytes")
    return np.frombuffer(values).reshape(shape)
