"""Compute large counts with 64-bit integers, using residues modulo 2^64 and several primes.

A count smaller than M is equal to its residue modulo M. Overflow of intermediate results is
harmless, because 64-bit arithmetic is exact modulo 2^64. For counts below 2^64, one table of 64-bit
integers is enough. For larger counts, each additional prime needs another table, and the residues
are combined by the Chinese remainder theorem.
"""

from __future__ import annotations

from functools import cache
from math import isqrt, prod

WORD = 2**64


@cache
def primes(count: int) -> tuple[int, ...]:
    """Return the `count` largest primes below 2^31.

    The product of two residues modulo one of these primes fits in 64 bits.
    """
    small = [
        q for q in range(3, isqrt(2**31) + 1, 2) if all(q % d for d in range(3, isqrt(q) + 1, 2))
    ]
    found: list[int] = []
    candidate = 2**31 - 1
    while len(found) < count:
        if all(candidate % q for q in small):
            found.append(candidate)
        candidate -= 2
    return tuple(found)


def moduli_above(bound: int) -> tuple[int, ...]:
    """Return moduli whose product exceeds `bound`: 2^64 first, then primes.

    Examples
    --------
    >>> moduli_above(10**12) == (2**64,)
    True
    >>> len(moduli_above(10**30))
    3
    """
    extra = 0
    while WORD * prod(primes(extra)) <= bound:
        extra += 1
    return (WORD, *primes(extra))


@cache
def weights(moduli: tuple[int, ...]) -> tuple[tuple[int, ...], int]:
    """Return the weights w and the modulus M for the Chinese remainder theorem.

    The integer with the given residues is ``sum(residue * w) mod M``.
    """
    whole = prod(moduli)
    return tuple(whole // m * pow(whole // m, -1, m) for m in moduli), whole


def join(residues: tuple[int, ...], moduli: tuple[int, ...]) -> int:
    """Return the smallest non-negative integer with these residues.

    Examples
    --------
    >>> join((2**80 % 2**64, 2**80 % (2**31 - 1)), (2**64, 2**31 - 1)) == 2**80
    True
    """
    factors, whole = weights(moduli)
    return sum(r * w for r, w in zip(residues, factors, strict=True)) % whole
