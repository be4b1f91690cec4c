"""Answers to a page, and its error objects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ._halfline import AccuracyError, AdapterError


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer to a request of the page."""

    status: int
    json: Any = None
    info: dict[str, Any] | None = None
    picture: bytes | None = None


# A newer request came.
NOTHING = Answer(204)


def error(kind: str, code: int, message: str) -> dict[str, Any]:
    return {"error": {"kind": kind, "message": message, "exit": code}}


def refusal(problem: Exception) -> Answer:
    """The error object of the command for an exception."""
    kinds: list[tuple[type[Exception], str, int]] = [
        (AccuracyError, "accuracy", 7),
        (AdapterError, "adapter", 4),
        (MemoryError, "limits", 5),
        (OSError, "io", 8),
        (ValueError, "settings", 2),
        (TypeError, "settings", 2),
        (KeyError, "settings", 2),
    ]
    for kind, name, code in kinds:
        if isinstance(problem, kind):
            text = problem.args[0] if isinstance(problem, KeyError) and problem.args else problem
            return Answer(400, error(name, code, str(text)))
    return Answer(500, error("internal", 101, f"the program failed: {problem!r}"))
