# SPDX-License-Identifier: MIT
"""What bluesky waits for: whether a flight has begun, and whether it is over."""

import threading
from collections.abc import Callable


class FlightStatus:
    """A Status of bluesky's protocol. Its text has the words of what has failed."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._over = threading.Event()
        self._lock = threading.Lock()
        self._callbacks: list[Callable[[FlightStatus], None]] = []
        self._error: BaseException | None = None

    @property
    def done(self) -> bool:
        """True once it is over, well or not."""
        return self._over.is_set()

    @property
    def success(self) -> bool:
        """True once it is over and well."""
        return self.done and self._error is None

    def exception(self, timeout: float | None = 0.0) -> BaseException | None:
        """Return what has failed, None if nothing has; wait for so many seconds before.

        Raises TimeoutError if it is not over by then.
        """
        self.wait(timeout)
        return self._error

    def wait(self, timeout: float | None = None) -> None:
        """Wait until it is over. Raises TimeoutError if it is not after so many seconds."""
        if not self._over.wait(timeout):
            raise TimeoutError(f"{self._what}: not over yet")

    def add_callback(self, callback: "Callable[[FlightStatus], None]") -> None:
        """Let a function be called with this status when it is over; at once if it is."""
        with self._lock:
            if not self.done:
                self._callbacks.append(callback)
                return
        callback(self)

    def finish(self, error: BaseException | None = None) -> None:
        """End it, by an error or without; what is over stays as it is."""
        with self._lock:
            if self.done:
                return
            self._error = error
            self._over.set()
            called, self._callbacks = self._callbacks, []
        for callback in called:
            callback(self)

    def __repr__(self) -> str:
        if not self.done:
            return f"<{self._what}: not over yet>"
        return f"{self._what}: {self._error}" if self._error else f"<{self._what}: done>"
