# SPDX-License-Identifier: MIT
"""Signals that end a command: SIGTERM and SIGHUP go the way of Ctrl-C, so all of them stop motion.

SIGINT raises KeyboardInterrupt by itself; the others raise EndedBySignal, a KeyboardInterrupt too.
"""

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

Handler = Callable[[int, FrameType | None], Any] | int | None
Handlers = dict[int, Handler]  # what signals did before, by number

_ENDING = ("SIGTERM", "SIGHUP")  # Windows has no SIGHUP
_BASE_STATUS = 128  # a shell's exit status for a signal is this and its number


class EndedBySignal(KeyboardInterrupt):
    """SIGTERM or SIGHUP has come; `number` is the signal's."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number


def name(error: KeyboardInterrupt) -> str:
    """Return what ended the command, in words."""
    return signal.Signals(error.number).name if isinstance(error, EndedBySignal) else "Ctrl-C"


def status(error: KeyboardInterrupt) -> int:
    """Return the exit status of a command that was ended: 130, 143 or 129.

    An interrupt that passes through the execution of a text (every dataclass is made by one, so an
    import is hit now and then) is remembered by CPython, which then ends by SIGINT, whatever
    status was asked for. The next text that is executed makes it forget.
    """
    exec("")
    return _BASE_STATUS + (error.number if isinstance(error, EndedBySignal) else signal.SIGINT)


def catch() -> Handlers:
    """Let SIGTERM and SIGHUP raise EndedBySignal in this process; return the handlers before.

    A signal that is ignored stays ignored: that is how nohup works. Only the main thread gets
    signals, and only it may change what they do.
    """
    if threading.current_thread() is not threading.main_thread():
        return {}
    before = {number: signal.getsignal(number) for number in _numbers(_ENDING)}
    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, _raise)
    return before


@contextlib.contextmanager
def caught() -> Iterator[None]:
    """Let SIGTERM and SIGHUP raise EndedBySignal as long as this lasts; put SIGINT back then."""
    before = catch()
    if before:
        before[signal.SIGINT] = signal.getsignal(signal.SIGINT)
    try:
        yield
    finally:
        _restore(before)


@contextlib.contextmanager
def until_ctrl_c() -> Iterator[None]:
    """Let Ctrl-C end the block as its usual end; the other signals still end the command."""
    try:
        yield
    except EndedBySignal:
        raise
    except KeyboardInterrupt:
        pass


@contextlib.contextmanager
def once() -> Iterator[None]:
    """Let a signal end the block once: those that come while it tidies up are ignored.

    In a command they are ignored until its end.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    found = {number: signal.getsignal(number) for number in _numbers(("SIGINT", *_ENDING))}
    ours = (_raise, signal.default_int_handler)
    before: Handlers = {number: one for number, one in found.items() if one in ours}

    def end(number: int, _frame: object) -> None:
        for other in before:
            signal.signal(other, signal.SIG_IGN)
        if _raise in before.values():
            before.clear()
        raise KeyboardInterrupt if number == signal.SIGINT else EndedBySignal(number)

    for number in before:
        signal.signal(number, end)
    try:
        yield
    finally:
        _restore(before)


@contextlib.contextmanager
def ignored() -> Iterator[None]:
    """Ignore SIGINT, SIGTERM and SIGHUP: stopping motion must not be broken off."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {
        number: signal.signal(number, signal.SIG_IGN) for number in _numbers(("SIGINT", *_ENDING))
    }
    try:
        yield
    finally:
        _restore(before)


def _restore(handlers: Handlers) -> None:
    for number, handler in handlers.items():
        signal.signal(number, handler)


def _raise(number: int, _frame: object) -> None:
    """Raise EndedBySignal once: a closing terminal sends SIGHUP twice, some tools two signals."""
    for other in _numbers(_ENDING):
        signal.signal(other, signal.SIG_IGN)
    raise EndedBySignal(number)


def _numbers(names: tuple[str, ...]) -> list[int]:
    """Return the numbers of the signals that this system has."""
    return [getattr(signal, one) for one in names if hasattr(signal, one)]
