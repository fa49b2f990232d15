"""Consistent overhead byte stuffing: packets without the byte 0x00 (Cheshire and Baker, 1999)."""

from __future__ import annotations

MAX_PACKET = 254
"""Packets up to this length grow by exactly one byte; longer ones are not needed here."""


def stuff(packet: bytes) -> bytes:
    """Packet of at most MAX_PACKET bytes -> the same without zeros, one byte longer."""
    return b"".join(bytes((len(part) + 1,)) + part for part in packet.split(b"\0"))


def unstuff(stuffed: bytes) -> bytes | None:
    """Inverse of `stuff`; None where no packet gives these bytes."""
    length = len(stuffed)
    if not 1 < length <= MAX_PACKET + 1:
        return None
    parts = []
    start = 0
    while start < length:
        end = start + stuffed[start]
        parts.append(stuffed[start + 1 : end])
        if end > length or end == start:
            return None
        start = end
    return b"\0".join(parts)
