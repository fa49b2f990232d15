"""A disk that breaks: of the operating system's calls one fails, or all from then on."""

from __future__ import annotations

import errno
import os
from typing import Self


class BrokenDisk:
    """Refuses the k-th call of one kind, or each from then on, in this process while it lasts.

    Attributes:
        seen: calls so far.
    """

    def __init__(self, kind: str, at: int, *, lasting: bool) -> None:
        """It does not break before it is entered.

        Args:
            kind: function of `os`, for example fsync or replace.
            at: which of its calls is refused first, from 1 on.
            lasting: whether those after it are, too.
        """
        self.seen = 0
        self._kind, self._at, self._lasting = kind, at, lasting
        self._real = getattr(os, kind)

    def __enter__(self) -> Self:
        setattr(os, self._kind, self)
        return self

    def __exit__(self, *_: object) -> None:
        setattr(os, self._kind, self._real)

    def __call__(self, *arguments: object, **more: object) -> object:
        self.seen += 1
        if self.seen == self._at or (self._lasting and self.seen > self._at):
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return self._real(*arguments, **more)

    @property
    def struck(self) -> bool:
        """Whether it has refused anything."""
        return self.seen >= self._at
