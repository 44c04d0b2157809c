"""Recorded motions are read as written; files that hold none are refused in a sentence."""

import io
import os
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
from spincheck.reports.harness.recorded.files.read import read_recording
from spincheck.reports.harness.recorded.files.recording import Recording, RecordingError
from spincheck.reports.harness.recorded.files.text_formats import LONGEST_LINE, MAX_SAMPLES

ROW = "0,1,0,0,0,0.5,0,2"
GOOD = f"t,qw,qx,qy,qz,wx,wy,wz\n{ROW}\n0.1,1,0,0,0,0.5,0,2\n"


def written(folder, text, name="motion.csv"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_table_is_read_by_the_names_of_its_columns(tmp_path):
    # A spreadsheet may end each line with a comma.
    text = "wz,t,qw,qx,qy,qz,wx,wy,load,\n2,0,1,0,0,0,0.5,0,7,\n2,0.1,1,0,0,0,0.5,0,7,\n"
    recording = read_recording(written(tmp_path, text))
    assert recording.arrays["omega"].tolist() == [[0.5, 0, 2], [0.5, 0, 2]]
    assert recording.arrays["t"].tolist() == [0, 0.1]
    assert recording.ignored == ("load",)
    assert read_recording(written(tmp_path, f"time [s]{GOOD[1:]}")).arrays["t"].tolist() == [0, 0.1]
    for delimiter in ";\t ":
        recording = read_recording(written(tmp_path, GOOD.replace(",", delimiter)))
        assert recording.arrays["q"].tolist() == [[1, 0, 0, 0]] * 2


def test_units_in_brackets_become_si(tmp_path):
    text = (
        "t [ms],qw,qx,qy,qz,wx[deg/s],wy[deg/s],wz [rpm]\n0,1,0,0,0,180,0,60\n5,1,0,0,0,180,0,60\n"
    )
    recording = read_recording(written(tmp_path, text))
    assert recording.arrays["t"].tolist() == [0, 0.005]
    assert recording.arrays["omega"][0] == pytest.approx([np.pi, 0, 2 * np.pi], rel=1e-15)


def test_a_file_states_its_frames_in_comments(tmp_path):
    text = "# omega = world\n# quaternion = xyzw\n# timestep = 0.002\n# made by hand\n" + GOOD
    settings = {"omega": "world", "quaternion": "xyzw", "timestep": "0.002"}
    assert read_recording(written(tmp_path, text)).settings == settings


def test_headings_may_be_in_a_comment_as_of_savetxt(tmp_path):
    text = "# t in seconds\n# omega = world\n# " + GOOD
    recording = read_recording(written(tmp_path, text))
    plain = read_recording(written(tmp_path, "# omega = world\n" + GOOD, "plain.csv"))
    assert recording.settings == plain.settings == {"omega": "world"}
    assert recording.arrays["q"].tolist() == plain.arrays["q"].tolist()


def test_lines_of_json_are_read_with_lists_or_single_numbers(tmp_path):
    text = (
        '{"omega": "world"}\n{"t": 0, "q": [1, 0, 0, 0], "omega": [1, 2, 3], "note": [1]}\n'
        '{"t": 0.1, "q": [1, 0, 0, 0], "omega": [1, 2, 3], "note": [1]}\n'
    )
    recording = read_recording(written(tmp_path, text, "motion.jsonl"))
    assert recording.arrays["omega"].tolist() == [[1, 2, 3]] * 2
    assert recording.settings == {"omega": "world"}


@pytest.mark.parametrize(("key", "at"), [("time", 0.1), ("t [ms]", 100.0)])
def test_lines_of_json_may_name_the_time_as_tables_do(tmp_path, key, at):
    text = "".join(f'{{"{key}": {t}, "q": [1, 0, 0, 0]}}\n' for t in (0, at))
    recording = read_recording(written(tmp_path, text, "motion.jsonl"))
    assert recording.arrays["t"].tolist() == [0.0, pytest.approx(0.1)]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('{"t": true, "q": [1, 0, 0, 0]}', "line 2: 'True' must be a finite number"),
        ("{}", "line 2 must have the keys of the first"),
        ('{"t": 1, "quaternion": [1, 0, 0, 0]}', "line 2 must have the keys of the first"),
        ('{"t": 1, "q": [1, 0, 0, 0], "qw": 1}', "line 2 must have the keys of the first"),
        ('{"t": 1, "qw": 1, "qx": 0, "qy": 0, "z": 0}', "line 2 must have the keys of the first"),
    ],
)
def test_a_line_of_json_that_is_not_like_the_first_is_refused(tmp_path, line, words):
    path = written(tmp_path, f'{{"t": 0, "q": [1, 0, 0, 0]}}\n{line}\n', "motion.jsonl")
    with pytest.raises(RecordingError, match=words):
        read_recording(path)


def test_quaternions_may_shrink_slowly(tmp_path):
    lengths = 0.9 ** np.arange(5)
    text = "t,qw,qx,qy,qz\n" + "".join(f"{k},{n!r},0,0,0\n" for k, n in enumerate(lengths.tolist()))
    recording = read_recording(written(tmp_path, text))
    assert f"by {np.log(0.9):.3g} /s, to a norm of 0.6561 at 4 s" in recording.drift_off_the_sphere


def test_as_many_samples_as_a_motion_may_have_are_read(tmp_path, monkeypatch):
    monkeypatch.setattr("spincheck.reports.harness.recorded.files.text_formats.MAX_SAMPLES", 2)
    assert len(read_recording(written(tmp_path, GOOD)).arrays["t"]) == 2


def test_a_text_in_an_archive_is_no_longer_than_a_line(tmp_path):
    arrays = {"t": [0, 1], "q": [[1, 0, 0, 0]] * 2, "precision": "x" * (LONGEST_LINE + 1)}
    np.savez(tmp_path / "motion.npz", **arrays)
    with pytest.raises(RecordingError, match=r"'precision\.npy' must hold numbers, got <U"):
        read_recording(tmp_path / "motion.npz")


@pytest.mark.parametrize(("q", "resolution"), [(0.1235, 1e-3), (0.12, 0.1), (1 / 3, 1e-15)])
def test_the_resolution_is_that_of_the_digits_that_are_printed(q, resolution):
    recording = Recording(Path("m.csv"), {"q": np.array([[q, 0.0, 0.0, 0.0]])})
    assert recording.resolution == pytest.approx(resolution)


def test_arrays_are_read_from_npz(tmp_path):
    path = tmp_path / "motion.npz"
    np.savez(path, t=[0, 0.1], q=[[1, 0, 0, 0]] * 2, com=[[1, 2, 3]] * 2, timestep=0.1, other=[1])
    recording = read_recording(path)
    assert recording.arrays["com"].tolist() == [[1, 2, 3]] * 2
    assert recording.settings == {"timestep": "0.1"}
    assert recording.ignored == ("other",)


def test_parquet_is_read(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    columns = {"t": [0.0, 0.1], "qw": [1, 1], "qx": [0.0] * 2, "qy": [0.0] * 2, "qz": [0.0] * 2}
    path = tmp_path / "motion.parquet"
    parquet.write_table(pyarrow.table(columns | {"note": ["a", "b"]}), path)
    recording = read_recording(path)
    assert recording.arrays["q"].tolist() == [[1, 0, 0, 0]] * 2
    assert recording.ignored == ("note",)
    parquet.write_table(pyarrow.table(columns | {"qw": ["1", "1"]}), path)
    with pytest.raises(RecordingError, match="'qw' must hold numbers, got string"):
        read_recording(path)
    parquet.write_table(pyarrow.table(columns | {"t": [0.0, None]}), path)
    with pytest.raises(RecordingError, match="row 2: 'None' must be a finite number"):
        read_recording(path)


WRONG = {
    "empty": ("", "is empty"),
    "no time": ("qw,qx,qy,qz\n1,0,0,0\n", "'t' must be a column of the file, got qw, qx, qy, qz"),
    "other names": (
        "time,q0,q1,q2,q3\n0,1,0,0,0\n",
        "got time, q0, q1, q2, q3; name them as in t,qw,qx,qy,qz,wx,wy,wz",
    ),
    "no headings": ("0,1,0,0,0\n1,1,0,0,0\n", "must be a column of the file, got numbers; name"),
    "part of omega": ("t,qw,qx,qy,qz,wx\n0,1,0,0,0,1\n", "'wx', 'wy', 'wz' must be columns"),
    "a column twice": ("t,t,qw,qx,qy,qz\n0,0,1,0,0,0\n", "'t' must be one column each"),
    "unknown unit": (GOOD.replace("wx", "wx [furlong]"), "must be one of rad/s, deg/s, rpm"),
    "not a number": (GOOD.replace("0.5", "nan", 1), "line 2: 'nan' must be a finite number"),
    "text": (GOOD.replace("0.5", "fast", 1), "line 2: 'fast' must be a finite number"),
    "a short row": (GOOD + "0.2,1\n", "line 4 must have 8 columns, got 2"),
    "times back": (f"{GOOD}{ROW}\n", "times must increase, got 0.10000000000000001 s and then 0"),
    "times twice": (
        GOOD + "0.1,1,0,0,0,0.5,0,2\n",
        "0.10000000000000001 s in samples 2 and 3; sort the samples",
    ),
    "before the start": (GOOD.replace("\n0,", "\n-1,"), "must be counted from the scene's start"),
    "one sample": (f"t,qw,qx,qy,qz,wx,wy,wz\n{ROW}\n", "at least two samples, got 1"),
    "no length": (
        GOOD.replace("0.1,1,", "0.1,0,"),
        "drift off it slowly from 1 on, that of sample 2 is 0 long and the one before 1",
    ),
    "a first quaternion that has not drifted yet": (
        GOOD.replace("\n0,1,", "\n0,1.2,"),
        "that of sample 1 is 1.2 long",
    ),
    "a first quaternion of another norm": (
        GOOD.replace("\n0,1,", "\n0,1.002,"),
        "that of sample 1 is 1.002 long",
    ),
    "a wrong frame": ("# omega = local\n" + GOOD, "line 1: 'omega' must be body or world"),
    "a wrong timestep": ("# timestep = -1\n" + GOOD, "'timestep' must be a positive number"),
    "a long line": ("t" * (1 << 15), "line 1 must be shorter than"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_no_motion_is_refused_in_a_sentence(tmp_path, case):
    text, words = WRONG[case]
    with pytest.raises(RecordingError) as refused:
        read_recording(written(tmp_path, text))
    assert words in str(refused.value)
    assert str(refused.value).startswith(f"{tmp_path / 'motion.csv'}: ")


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"t": [0, 1], "q": [[1, 0, 0]] * 2}, "'q.npy' must have the shape (n, 4), got (2, 3)"),
        ({"t": [0, 1]}, "must have an array 'q'"),
        ({"t": [0, 1, 2], "q": [[1, 0, 0, 0]] * 2}, "'q' must have a row for each time, got 2"),
        ({"t": [0, 1], "q": [[1, 0, 0, np.inf]] * 2}, "'q' must be finite, sample 1 is not"),
        ({"t": ["a", "b"], "q": [[1, 0, 0, 0]] * 2}, "'t.npy' must hold numbers, got <U1"),
        ({"t": np.array([{}, {}]), "q": [[1, 0, 0, 0]] * 2}, "must hold numbers, got object"),
    ],
)
def test_archives_of_other_arrays_are_refused(tmp_path, arrays, words):
    path = tmp_path / "motion.npz"
    np.savez(path, **arrays)
    with pytest.raises(RecordingError, match=r"motion\.npz: ") as refused:
        read_recording(path)
    assert words in str(refused.value)


def test_an_array_that_claims_to_be_huge_or_an_endless_file_is_not_read_to_its_end(
    tmp_path, monkeypatch
):
    path = tmp_path / "motion.npz"
    np.savez_compressed(path, t=np.zeros(MAX_SAMPLES + 1), q=np.zeros((2, 4)))
    with pytest.raises(RecordingError, match=f"at most {MAX_SAMPLES} samples"):
        read_recording(path)
    monkeypatch.setattr("spincheck.reports.harness.recorded.files.text_formats.MAX_SAMPLES", 10)
    rows = "".join(f"{k},1,0,0,0,0.5,0,2\n" for k in range(20)) + "not a row\n"
    with pytest.raises(RecordingError, match="at most 10 samples"):
        read_recording(written(tmp_path, GOOD.splitlines()[0] + "\n" + rows))


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("motion.xls", GOOD.encode(), r"its name must end in one of \.csv"),
        ("motion", GOOD.encode(), r"its name must end in one of \.csv"),
        ("motion.csv", None, "is not a regular file"),
        ("motion.csv", b"t,qw\xff\n", "must be text in UTF-8"),
    ],
    ids=["another kind", "no kind", "a pipe, not waited for", "no text"],
)
def test_other_files_are_refused(tmp_path, name, content, words):
    path = tmp_path / name
    os.mkfifo(path) if content is None else path.write_bytes(content)
    with pytest.raises(RecordingError, match=words):
        read_recording(path)


def archive(entry, kind=zipfile.ZIP_STORED, names=("t",)):
    """An archive of an array's bytes."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", kind) as file:
        for name in names:
            file.writestr(f"{name}.npy", entry)
    return packed.getvalue()


def array(header, length=None):
    """An array's bytes, with a header that may claim another length than it has."""
    said = struct.pack("<I", len(header) if length is None else length)
    return b"\x93NUMPY\x02\x00" + said + header.encode()


def overwritten(packed):
    return packed[:60] + bytes(20) + packed[80:]


def encrypted(packed):
    """Every entry marked as encrypted, in its own header and in the directory."""
    marked = packed.replace(b"PK\x03\x04\x14\0\0", b"PK\x03\x04\x14\0\1")
    return marked.replace(b"PK\x01\x02\x14\3\x14\0\0", b"PK\x01\x02\x14\3\x14\0\1")


NOISE = bytes(np.random.default_rng(0).integers(0, 256, 999, dtype=np.uint8))
DAMAGED = {
    "nothing": (b"PK\x03\x04 and nothing else", "not a zip file"),
    "deflate": (overwritten(archive(NOISE, kind=zipfile.ZIP_DEFLATED)), ""),
    "bzip2": (overwritten(archive(NOISE, kind=zipfile.ZIP_BZIP2)), "Invalid data stream"),
    "lzma": (overwritten(archive(NOISE, kind=zipfile.ZIP_LZMA)), ""),
    "encrypted": (encrypted(archive(NOISE)), "encrypted"),
    "a shape that is true": (
        archive(array("{'descr': '<f8', 'fortran_order': False, 'shape': (True,)}\n") + bytes(8)),
        "",
    ),
    "a header that never ends": (archive(array(" " * 99, 1 << 31)), "EOF"),
    "a header of brackets": (archive(array("(" * 99)), ""),
    "a header of signs": (archive(array("-" * 999 + "1")), ""),
    "an array twice": (
        archive(
            array("{'descr': '<f8', 'fortran_order': False, 'shape': (0, 3)}\n"),
            names=("omega", "omega_body"),
        ),
        "holds 'omega' twice",
    ),
}


@pytest.mark.parametrize("case", DAMAGED)
def test_a_damaged_archive_is_refused(tmp_path, case):
    damaged, words = DAMAGED[case]
    (tmp_path / "motion.npz").write_bytes(damaged)
    with pytest.raises(RecordingError, match=r"motion\.npz: ") as refused:
        read_recording(tmp_path / "motion.npz")
    assert words in str(refused.value)


def test_of_a_header_no_more_is_unpacked_than_one_may_have(tmp_path, monkeypatch):
    taken = []
    read = zipfile.ZipExtFile.read
    monkeypatch.setattr(
        zipfile.ZipExtFile, "read", lambda file, n=-1: (taken.append(n), read(file, n))[1]
    )
    length = 1 << 20
    bomb = archive(array(" " * length, length), kind=zipfile.ZIP_DEFLATED)
    (tmp_path / "motion.npz").write_bytes(bomb)
    with pytest.raises(RecordingError):
        read_recording(tmp_path / "motion.npz")
    assert 0 < max(taken) < length


def test_single_precision_is_stated_or_seen_in_the_attitudes() -> None:
    q = np.array([[0.6, 0.0, 0.8, 0.0], [0.8, 0.6, 0.0, 0.0]])
    for values, settings, is_single in (
        (q, {}, False),
        (q.astype(np.float32).astype(float), {}, True),
        (q, {"precision": "single"}, True),
        (np.rint(q), {}, False),
    ):
        assert Recording(Path("m.csv"), {"q": values}, settings).is_single == is_single
