"""Encode and decode a line of a journal: a record, its checksum and a running hash.

Each line is a JSON object. The object contains the record's number ``n``, the session time ``t`` in
seconds, the record's ``kind`` and its data. The last two entries are checksums:

- ``hash``: the first 32 hexadecimal digits of the SHA-256 of the previous record's hash and this
  record's text. This hash does not match if a record was removed, moved, repeated or edited.
- ``crc``: the CRC-32 of the line up to this entry. This checksum detects a truncated or altered
  line without reference to other lines, so that undamaged lines can still be read.
"""

from __future__ import annotations

import hashlib
import json
import re
import zlib
from dataclasses import dataclass, replace
from typing import Any

from slipscale.faults.message import Message

FORMAT = 2
HASH_DIGITS = 32
# Maximum number of digits in an integer. Longer integers are never written, and floats overflow at
# about 308 digits.
MOST_DIGITS = 300
_HASH = re.compile(rf',"hash":"([0-9a-f]{{{HASH_DIGITS}}})"}}$')


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """One line of a journal.

    Parameters
    ----------
    number : int
        Number of the record in the order of writing, from 0.
    time_s : float
        Time on the session's clock.
    kind : str
        Kind of record, such as "header", "begin" or "done".
    data : dict
        Entries of the line other than the number, time, kind and checksums.
    hash : str
        Running hash up to this record; empty until it is computed by `sealed`.
    """

    number: int
    time_s: float
    kind: str
    data: dict[str, Any]
    hash: str = ""


def sealed(record: Record, before: str) -> tuple[Record, bytes]:
    """Add the hash, computed from the previous one, to a record; return the record and its line."""
    body = _body(record)
    found = replace(record, hash=_running_hash(before, body))
    return found, _line(body, found.hash)


def encode(record: Record) -> bytes:
    """Return a record as a line, with its hash (if any) and its checksum."""
    return _line(_body(record), record.hash)


def _line(body: str, running_hash: str) -> bytes:
    if running_hash:
        body = f'{body[:-1]},"hash":"{running_hash}"}}'
    return f'{body[:-1]},"crc":"{zlib.crc32(body.encode()):08x}"}}\n'.encode()


def decode(line: bytes) -> tuple[Record, str]:
    """Decode a line into a record and the text from which the running hash is computed.

    Raises
    ------
    ValueError
        If the line is not a complete record, or its checksum does not match.
    """
    body, mark, tail = line.decode().rpartition(',"crc":"')
    if not mark or tail[8:] != '"}\n' or f"{zlib.crc32((body + '}').encode()):08x}" != tail[:8]:
        raise ValueError("the checksum does not match")
    body += "}"
    try:
        fields = _DECODER.decode(body)
    except RecursionError:
        raise ValueError("the data are nested too deeply") from None
    found = _HASH.search(body)
    if found and fields.get("hash") == found[1]:
        del fields["hash"]
        body = f"{body[: found.start()]}}}"
    number, time_s, kind = (fields.pop(name, None) for name in ("n", "t", "kind"))
    if type(number) is not int or type(time_s) not in (int, float) or not isinstance(kind, str):
        raise ValueError("expected a number n, a time t and a kind")
    record = Record(
        number=number, time_s=time_s, kind=kind, data=fields, hash=found[1] if found else ""
    )
    return record, body


def _whole(digits: str) -> int:
    if len(digits) > MOST_DIGITS:
        raise ValueError(
            Message("a number has more than {most_digits} digits", most_digits=MOST_DIGITS)
        )
    return int(digits)


# Created only once, because a journal has thousands of short lines.
_DECODER = json.JSONDecoder(parse_int=_whole)
_ENCODER = json.JSONEncoder(ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def follows(record: Record, covered: str, before: str) -> bool:
    """Return whether a record's hash matches its text and the previous hash."""
    return record.hash == _running_hash(before, covered)


def _body(record: Record) -> str:
    fields = {"n": record.number, "t": record.time_s, "kind": record.kind, **record.data}
    return _ENCODER.encode(fields)


def _running_hash(before: str, body: str) -> str:
    return hashlib.sha256(f"{before}\n{body}".encode()).hexdigest()[:HASH_DIGITS]
