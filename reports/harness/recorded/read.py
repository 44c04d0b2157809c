"""A recorded motion read from a file: CSV, JSON lines, npz or Parquet.

Files may come from anyone and be of any size: they are read in pieces, no further than to the
largest number of samples, and nothing in them is executed.
"""

import stat
from pathlib import Path

from ....scenarios import printable
from .binary_formats import read_npz, read_parquet
from .columns import ColumnError
from .recording import Recording, RecordingError, check_motion
from .text_formats import read_csv, read_json_lines

#: By the ending of a file's name, what reads it.
READERS = {
    ".csv": read_csv,
    ".txt": read_csv,
    ".jsonl": read_json_lines,
    ".ndjson": read_json_lines,
    ".npz": read_npz,
    ".parquet": read_parquet,
}


def read_recording(path: Path) -> Recording:
    """Read a recorded motion, by the ending of the file's name.

    Raises
    ------
    RecordingError
        If the file cannot be read, or holds no such motion.
    """
    where = printable(str(path))
    reader = READERS.get(path.suffix.lower())
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise RecordingError("is not a regular file")
        if reader is None:
            raise RecordingError(f"its name must end in one of {', '.join(READERS)}")
        recording = reader(path)
        check_motion(recording.arrays)
    except (RecordingError, ColumnError) as error:
        # A library's own message may end with one.
        raise RecordingError(f"{where}: {str(error).rstrip('.')}.") from None
    except OSError as error:
        raise RecordingError(f"{where}: cannot be read: {error.strerror}.") from None
    except UnicodeDecodeError:
        raise RecordingError(f"{where}: must be text in UTF-8.") from None
    return recording
