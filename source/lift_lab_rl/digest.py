"""A digest at the end of a torch file: one changed byte anywhere in the file is noticed.

A torch file is a zip archive. The digest is the comment that a zip archive may end with, so torch and other programs
read the file as before. It covers every byte before the digest itself.
"""

from __future__ import annotations

import hashlib
import io
import struct
import zipfile

_END_RECORD = b"PK\x05\x06"
"""Start of a zip archive's last record, which takes 22 bytes and then the comment."""

_LABEL = b"lift-lab sha256 "
_HEX = 2 * hashlib.sha256().digest_size

_DAMAGED = "the file is damaged: its content does not match its checksum"


def add_digest(archive: bytes) -> bytes:
    """Append a digest to a zip archive.

    Args:
        archive: the archive, without a comment.

    Returns:
        The archive with the digest as its comment.
    """
    covered = archive[:-2] + struct.pack("<H", len(_LABEL) + _HEX) + _LABEL
    return covered + hashlib.sha256(covered).hexdigest().encode()


def damage(data: bytes) -> str | None:
    """Check the bytes of a torch file.

    Older versions and other programs write files without a digest. These are checked by the checksums of a zip archive,
    which do not cover the archive's own tables. A file that is no zip archive is not checked.

    Args:
        data: the whole file.

    Returns:
        The mistake in words for the user; None if there is none.
    """
    covered, digest = data[:-_HEX], data[-_HEX:]
    if covered.endswith(_LABEL):
        return None if hashlib.sha256(covered).hexdigest().encode() == digest else _DAMAGED
    if not data.startswith(b"PK"):
        return None
    if data[-22:-18] != _END_RECORD:
        return "it is no checkpoint (model_N.pt), or not a whole one"
    return _damaged_entry(data)


def _damaged_entry(data: bytes) -> str | None:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return None if archive.testzip() is None else _DAMAGED
    except Exception:  # the tables of a damaged archive can say anything
        return _DAMAGED
