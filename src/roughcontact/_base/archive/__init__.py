"""Arrays with a header in one file, sealed by a checksum and written completely or not at all."""

from __future__ import annotations

import contextlib
import errno
import functools
import hashlib
import io
import json
import math
import os
import platform
import re
import stat
import threading
import time
import uuid
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from roughcontact._base.arrays import RealArray
from roughcontact.errors import InputError, NotWritten, RoughContactError

# Characters of a file's name that its unfinished copy repeats: names have up to 255 bytes, a character up to 4.
_PARTIAL_NAME_CHARACTERS = 40
_PROCESS = re.compile(r"([0-9a-f]{8})-(\d+)")
_PARTIAL_NAME = re.compile(rf"\..+\.(?P<process>{_PROCESS.pattern})\.[0-9a-f]{{12}}\.partial", re.DOTALL)
# Seconds, a week: the age at which an unfinished file is stale if its process cannot be seen from this machine.
_STALE_AGE = 604800.0
# Seconds between two times at which appended lines are flushed: it takes as long as a small solve.
_FLUSH_INTERVAL = 1.0
_appending = threading.Lock()
_flushed: dict[Path, float] = {}
HEADER = "header"
# Version of the file format; a change that older versions cannot read counts up.
FORMAT = 1
# Flags for opening a file to read, without waiting for a pipe.
_OPEN_FLAGS = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
# Hexadecimal digits of a SHA-256 digest, and of those that identify arrays and parts.
_SHA256_DIGITS = 64
_SHORT_DIGITS = 32
SEAL = f"roughcontact file, format {FORMAT}, sha256 ".encode() + _SHA256_DIGITS * b"0"
_SEAL_PATTERN = re.compile(rb"roughcontact file, format (\d{1,9}), sha256 [0-9a-f]{64}\Z")
# Bytes of a header; a problem takes some thousands.
_MAX_HEADER_BYTES = 2**22
# Bytes to which an npz file may expand, plus a multiple of its own size: heights deflate by 1 to 2, zeros by 1000.
_ARCHIVE = (2**24, 20)
# Levels of brackets in a header (a sum of surfaces takes three), and characters of a number (float64 takes 24).
_MAX_JSON_DEPTH = 150
_MAX_NUMBER_CHARACTERS = 40
# Bytes of the header of an npy file, of which numpy parses at most 10000.
_NPY_HEADER_BYTES = 2**14
# Possessive: a text of a million letters must not take a million steps back.
_JSON_TOKEN = re.compile(r'"(?:[^"\\]++|\\.)*+"?|[\[{]|[\]}]|[^\s"\[\]{},:]+')


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str], *, flush: bool = True) -> Iterator[Path]:
    """Give the path of a temporary file in the same folder; it replaces the target if the context ends without error.

    The content is on the disk before the file is renamed. Without `flush` the new name may be lost when the power
    fails, until another file in the folder is flushed. `InputError` if there is no such folder or the target is not a
    file; `NotWritten` if the system refuses, and the former file is unchanged.
    """
    target = Path(path)
    own = f"{name_process()}.{uuid.uuid4().hex[:12]}"
    partial = target.parent / f".{target.name[:_PARTIAL_NAME_CHARACTERS]}.{own}.partial"
    try:
        if "\0" in target.name or not target.parent.is_dir():
            raise InputError(f"There is no folder {str(target.parent)!r} to write {target.name!r} into.")
        if target.exists() and not target.is_file():
            raise InputError(f"There is something else than a file at {str(target)!r}: give another name.")
        _remove_stale_once(os.path.abspath(target.parent))
        yield partial
        with partial.open("r+b") as file:
            os.fsync(file.fileno())
        partial.replace(target)
        if flush:
            _flush_names(target.parent)
    except BaseException as error:
        with contextlib.suppress(OSError, ValueError):
            partial.unlink()
        if isinstance(error, OSError) and not isinstance(error, RoughContactError):
            raise NotWritten(error.errno, error.strerror or str(error), str(target)) from error
        raise


def append_line(path: Path, line: str) -> None:
    """Append a line to a file that no other process writes, completely or not at all; `NotWritten` if it cannot be.

    A process that is killed loses no line; a loss of power may lose those of the last second, in which none is flushed.
    """
    content = f"{line}\n".encode()
    try:
        # Threads of one process would write over each other.
        with _appending, path.open("ab", buffering=0) as file:
            size = file.tell()
            if file.write(content) < len(content):
                file.truncate(size)
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            now = time.monotonic()
            if now - _flushed.get(path, -math.inf) > _FLUSH_INTERVAL:
                os.fsync(file.fileno())
                _flushed.clear()
                _flushed[path] = now
    except OSError as error:
        raise NotWritten(error.errno, error.strerror or str(error), str(path)) from error


def remove_stale(folder: str | os.PathLike[str]) -> None:
    """Remove the unfinished files of `replacing` whose process was killed."""
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            owner = _PARTIAL_NAME.fullmatch(entry.name)
            with contextlib.suppress(OSError):
                if owner and entry.is_file(follow_symlinks=False) and is_left_over(entry, owner["process"]):
                    os.unlink(entry.path)


# A folder of a long study has thousands of names: they are read once by each process.
_remove_stale_once = functools.cache(remove_stale)


def name_process() -> str:
    """Return digits that identify this process among those of all machines."""
    return f"{_machine()}-{os.getpid()}"


def is_left_over(file: os.DirEntry[str] | Path, process: str) -> bool:
    """Return whether the process of a file, by its `name_process`, has ended; by the file's age if it is not seen."""
    known = _PROCESS.fullmatch(process)
    if known is None:
        return False
    if known[1] == _machine() and os.name == "posix":
        return _has_ended(int(known[2]))
    return time.time() - file.stat(follow_symlinks=False).st_mtime > _STALE_AGE


def _has_ended(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except (PermissionError, OverflowError):
        return False
    with contextlib.suppress(OSError):
        # A zombie: killed, but not waited for, as in a container without an init process.
        return Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()[:1] == ["Z"]
    return False


@functools.cache
def _machine() -> str:
    """Return digits that identify this machine, since its last start, and the container."""
    known = [platform.node()]
    with contextlib.suppress(OSError):
        known += [Path("/proc/sys/kernel/random/boot_id").read_text(), os.readlink("/proc/self/ns/pid")]
    return hashlib.sha256("".join(known).encode()).hexdigest()[:8]


def _flush_names(folder: Path) -> None:
    """Write the names in a folder to the disk, where the system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def write_archive(
    path: str | os.PathLike[str],
    arrays: Mapping[str, npt.ArrayLike],
    header: Mapping[str, Any],
    *,
    flush: bool = True,
) -> None:
    """Write arrays and a header that JSON can hold into an npz file; see `replacing` and `pack`."""
    packed = pack(arrays, header)
    with replacing(path, flush=flush) as partial:
        # As numpy.savez does, which in old versions does not close its file on a full disk.
        with zipfile.ZipFile(partial, "w") as archive:
            for name, array in packed.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                    np.lib.format.write_array(file, array, allow_pickle=False)
            archive.comment = SEAL
        seal(partial)


def read_archive(path: str | os.PathLike[str]) -> tuple[dict[str, RealArray], dict[str, Any]]:
    """Return the arrays and the header of a file of `write_archive`; see `opened`."""
    with opened(path) as file:
        return unpack(read_npz(file))


def read_some(path: str | os.PathLike[str], names: Iterable[str] = ()) -> tuple[dict[str, RealArray], dict[str, Any]]:
    """Return the named arrays and the header of a file, compared with its checksum; see `opened`."""
    with opened(path) as file:
        return unpack(read_npz(file, {HEADER, *names}), complete=False)


@contextlib.contextmanager
def opened(path: str | os.PathLike[str]) -> Iterator[IO[bytes]]:
    """Open a file after comparing all of it with its seal; errors inside the context become an `InputError`.

    `InputError` also if there is no such file, or it is damaged, of another kind or of another format.
    """
    file = Path(path)
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}.")
    try:
        descriptor = os.open(file, _OPEN_FLAGS)
    except OSError as error:
        raise InputError(f"The file {file.name} cannot be read: {error.strerror}.") from error
    try:
        with os.fdopen(descriptor, "rb") as stream:
            # A device or a pipe may have replaced it meanwhile.
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise InputError(f"There is no file {str(file)!r}.")
            found = _sealed_format(stream)
            if found != FORMAT:
                advice = f"this version of roughcontact reads format {FORMAT}: use the version that wrote it"
                raise InputError(f"The file {file.name} has format {found}, but {advice}.")
            yield stream
    except (InputError, MemoryError):
        raise
    # Each library that reads a damaged file fails in its own way.
    except Exception as error:
        reason = " ".join(str(error).split())[:200].rstrip(".") or type(error).__name__
        raise InputError(f"The file {file.name} is damaged, or was not written by roughcontact: {reason}.") from error


def seal(path: Path) -> None:
    """Write the checksum of a file that ends with `SEAL` into its last bytes."""
    with path.open("r+b") as file:
        end = file.seek(-_SHA256_DIGITS, os.SEEK_END)
        digest = _checksum(file, end)
        file.seek(end)
        file.write(digest)


def pack(arrays: Mapping[str, npt.ArrayLike], header: Mapping[str, Any]) -> dict[str, RealArray]:
    """Return the arrays, and a header that lists their digests; `InputError` if it could not be read again."""
    values = {name: np.asarray(array) for name, array in arrays.items()}
    try:
        text = json.dumps({**header, "arrays": {name: digest_of(array) for name, array in values.items()}})
        read_json(text)
    except ValueError as error:
        raise InputError(f"The solution cannot be kept in a file: {error}.") from error
    return {HEADER: np.frombuffer(text.encode(), dtype=np.uint8), **values}


def unpack(packed: Mapping[str, RealArray], *, complete: bool = True) -> tuple[dict[str, RealArray], dict[str, Any]]:
    """Return the arrays and the header of `pack`; ValueError unless the header lists these arrays."""
    header = _header(packed)
    arrays = {name: array for name, array in packed.items() if name != HEADER}
    listed = header.pop("arrays")
    found = {name: digest_of(array) for name, array in arrays.items()}
    if not found.items() <= listed.items() or (complete and len(found) < len(listed)):
        raise ValueError("its arrays are not those that its header lists")
    return arrays, header


def read_npz(file: IO[bytes], wanted: set[str] | None = None, *, deflated: bool = False) -> dict[str, RealArray]:
    """Return all or the wanted arrays of an npz file; ValueError if it declares more data than it can hold."""
    size = file.seek(0, os.SEEK_END)
    limit = bound_expansion(size)
    arrays: dict[str, RealArray] = {}
    with zipfile.ZipFile(file) as archive:
        members = {member.filename.removesuffix(".npy"): member for member in archive.infolist()}
        if len(members) < len(archive.infolist()):
            raise ValueError("a name occurs twice in it")
        require_expansion(archive, size, "write it again without compression (numpy.savez)", deflated=deflated)
        for name in members if wanted is None else [name for name in members if name in wanted]:
            with archive.open(members[name]) as stream:
                # Numbers of one byte become float64 later.
                arrays[name] = read_npy(stream, members[name].file_size, most=limit // 8)
    return arrays


def bound_expansion(size: int, bound: tuple[int, int] = _ARCHIVE) -> int:
    """Return the bytes to which the content of a file of so many bytes may expand, by an allowance and a ratio."""
    allowance, ratio = bound
    return allowance + ratio * size


def require_expansion(archive: zipfile.ZipFile, size: int, advice: str, *, deflated: bool) -> None:
    """Raise ValueError if an archive of `size` bytes declares far more data, or a compression without a bound."""
    members = archive.infolist()
    declared, stored = (sum(getattr(one, name) for one in members) for name in ("file_size", "compress_size"))
    if stored > size or declared > bound_expansion(size):
        raise ValueError(
            f"it declares {declared} bytes of data, more than a file of {size} bytes may hold; if that is right, "
            f"{advice}"
        )
    # The compressions of numpy. Others expand without a limit, and allocate dictionaries as a file declares them.
    ways = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED} if deflated else {zipfile.ZIP_STORED}
    if any(member.compress_type not in ways for member in members):
        raise ValueError("it is compressed in a way that is not read")


def read_npy(file: IO[bytes], size: int, most: int | None = None) -> RealArray:
    """Return the array of an npy file of `size` bytes; ValueError if it declares too many numbers."""
    # A damaged file may declare a header of any length, and numpy would allocate it.
    start = io.BytesIO(file.read(_NPY_HEADER_BYTES))
    version = np.lib.format.read_magic(start)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, fortran_order, dtype = read(start)
    count = math.prod(shape)
    left = size - file.seek(start.tell())
    if dtype.kind not in "biufU":
        raise ValueError(f"it holds an array of type {str(dtype)[:40]}, not of numbers: save the heights alone")
    if min(shape, default=0) < 0 or count * dtype.itemsize > left:
        raise ValueError(f"it declares an array of type {dtype} and shape {shape} in {left} bytes")
    if most is not None and count > most:
        raise ValueError(f"it declares {count} numbers, more than a file of its size may hold")
    data = np.frombuffer(file.read(count * dtype.itemsize), dtype, count)
    return data.reshape(shape, order="F" if fortran_order else "C")


def read_json(text: str) -> Any:
    """Return the content of JSON; ValueError if it is nested deeply, or a number is not finite or very long."""
    depth = 0
    for token in map(re.Match.group, _JSON_TOKEN.finditer(text)):
        depth += (token in "[{") - (token in "]}")
        if depth > _MAX_JSON_DEPTH:
            raise ValueError(f"its header has more than {_MAX_JSON_DEPTH} levels")
        is_number = token[0] not in '"[]{}' and token not in ("true", "false", "null")
        if is_number and (len(token) > _MAX_NUMBER_CHARACTERS or not math.isfinite(float(token))):
            raise ValueError(f"its header has the number {token[:_MAX_NUMBER_CHARACTERS]}")
    return json.loads(text)


def digest_of(array: RealArray) -> str:
    """Return hexadecimal digits that identify an array by its type, shape and values."""
    if array.dtype.kind not in "biufU":
        raise InputError(f"An array of type {array.dtype} cannot be kept in a file: only numbers and texts can.")
    head = f"{array.dtype.str}{array.shape}".encode()
    return _shorten_digest(head + np.ascontiguousarray(array).tobytes())


def short_digest(text: str) -> str:
    """Return hexadecimal digits that identify a text."""
    return _shorten_digest(text.encode())


def _shorten_digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:_SHORT_DIGITS]


def _header(packed: Mapping[str, RealArray]) -> dict[str, Any]:
    if HEADER not in packed or packed[HEADER].nbytes > _MAX_HEADER_BYTES:
        raise ValueError("it has no header, or one that is too long")
    header = read_json(packed[HEADER].tobytes().decode())
    if not isinstance(header, dict):
        raise ValueError("its header is not a mapping")
    return header


def _sealed_format(file: IO[bytes]) -> int:
    """Return the format of a file; ValueError unless its content has the checksum of its seal."""
    size = file.seek(0, os.SEEK_END)
    file.seek(max(0, size - 2 * len(SEAL)))
    found = _SEAL_PATTERN.search(file.read(2 * len(SEAL)))
    if found is None:
        raise ValueError("it does not end with a checksum")
    if _checksum(file, size - _SHA256_DIGITS) != found[0][-_SHA256_DIGITS:]:
        raise ValueError("its content has another checksum")
    return int(found[1])


def _checksum(file: IO[bytes], count: int) -> bytes:
    digest = hashlib.sha256()
    file.seek(0)
    for start in range(0, count, 2**20):
        digest.update(file.read(min(2**20, count - start)))
    return digest.hexdigest().encode()
