"""Requests of a page, answered by threads that live as long as there is work. The newest frame
wins.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass

_LOG = logging.getLogger("halfline")


class Superseded(Exception):  # noqa: N818
    """A newer request has arrived."""


@dataclass(slots=True, eq=False)
class Turn:
    """A request from its arrival to its end."""

    answer: Callable[[Turn], None]
    """Answers it; called in another thread."""
    drop: Callable[[], None] | None = None
    """Says that a newer one came before its turn; without it, it is answered in any case."""
    seq: int = 0
    """A greater number makes those needless that arrived before it."""
    is_needless: bool = False

    def check(self, *_: object) -> None:
        """Ends work that nobody wants any longer; the ``progress`` of a rendering.

        Raises:
            Superseded: if a newer request has arrived, or the interpreter ends.
        """
        if self.is_needless or not threading.main_thread().is_alive():
            raise Superseded


class Turns:
    """Requests, answered one after the other by a thread that ends with the last one, so that no
    thread outlives its view.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._lock = threading.Lock()
        self._waiting: list[Turn] = []
        self._now: Turn | None = None
        self._works = False

    def ask(self, turn: Turn) -> None:
        """A request arrives."""
        with self._lock:
            before = [*self._waiting, self._now] if self._now else self._waiting
            for other in before:
                other.is_needless |= other.seq < turn.seq
            dropped = [other for other in self._waiting if other.is_needless and other.drop]
            self._waiting = [other for other in self._waiting if other not in dropped] + [turn]
            starts, self._works = not self._works, True
        for other in dropped:
            if other.drop:
                other.drop()
        if starts:
            threading.Thread(target=self._work, name=self._name).start()

    def _work(self) -> None:
        while True:
            with self._lock:
                self._now = self._waiting.pop(0) if self._waiting else None
                if self._now is None:
                    self._works = False
                    return
                turn = self._now
            try:
                turn.answer(turn)
            except Exception as error:
                # An answer reports its own errors: this is one that could not be sent.
                _LOG.warning("an answer to the view was lost: %r", error)

    def close(self) -> None:
        """Nobody wants an answer any longer."""
        with self._lock:
            self._waiting = []
            if self._now:
                self._now.is_needless = True
