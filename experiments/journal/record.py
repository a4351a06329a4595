"""One line of a journal: a record, its checksum, and the running hash that chains it to all before.

One JSON object a line. Each holds its number ``n``, the session's time ``t`` in seconds, what it
is (``kind``), its data, and two proofs at the end:

- ``hash``: SHA-256, its first 32 hexadecimal digits, of the hash of the record
  before and of this one's text. A record that was removed, moved, repeated or edited breaks it.
- ``crc``: CRC-32 of all before it in the line. A torn or altered line is known by itself, so that
  damage in one place leaves the rest readable.
"""

from __future__ import annotations

import hashlib
import json
import re
import zlib
from dataclasses import dataclass
from typing import Any

FORMAT = 2
HASH_DIGITS = 32
# Of a whole number: more are not written, and beyond some 308 no float can hold it.
MOST_DIGITS = 300
_HASH = re.compile(rf',"hash":"([0-9a-f]{{{HASH_DIGITS}}})"}}$')


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """One line of a journal.

    Parameters
    ----------
    number : int
        0, 1, ... in the order of writing.
    time_s : float
        On the session's clock.
    kind : str
        What it is: "header", "begin", "done", ...
    data : dict
        All else that the line holds.
    hash : str
        The running hash up to this record; empty until `chained` gives it.
    """

    number: int
    time_s: float
    kind: str
    data: dict[str, Any]
    hash: str = ""


def chained(record: Record, before: str) -> Record:
    """Return a record with the running hash that follows from the one before it."""
    return Record(
        number=record.number,
        time_s=record.time_s,
        kind=record.kind,
        data=record.data,
        hash=_running_hash(before, _body(record)),
    )


def encode(record: Record) -> bytes:
    """Return a record as a line, with its hash (if it has one) and its checksum."""
    body = _body(record)
    if record.hash:
        body = f'{body[:-1]},"hash":"{record.hash}"}}'
    return f'{body[:-1]},"crc":"{zlib.crc32(body.encode()):08x}"}}\n'.encode()


def decode(line: bytes) -> tuple[Record, str]:
    """Return the record that a line holds, and the text that its hash covers.

    Raises
    ------
    ValueError
        The line is not a whole record, or its checksum does not fit.
    """
    body, mark, tail = line.decode().rpartition(',"crc":"')
    if not mark or tail[8:] != '"}\n' or f"{zlib.crc32((body + '}').encode()):08x}" != tail[:8]:
        raise ValueError("the checksum does not fit")
    body += "}"
    try:
        fields = json.loads(body, parse_int=_whole)
    except RecursionError:
        raise ValueError("too deeply nested") from None
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
        raise ValueError(f"a number of more than {MOST_DIGITS} digits")
    return int(digits)


def follows(record: Record, covered: str, before: str) -> bool:
    """Return whether a record's hash is the one that its text and the hash before it give."""
    return record.hash == _running_hash(before, covered)


def _body(record: Record) -> str:
    fields = {"n": record.number, "t": record.time_s, "kind": record.kind, **record.data}
    return json.dumps(fields, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def _running_hash(before: str, body: str) -> str:
    return hashlib.sha256(f"{before}\n{body}".encode()).hexdigest()[:HASH_DIGITS]
