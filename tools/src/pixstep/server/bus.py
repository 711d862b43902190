# SPDX-License-Identifier: MIT
"""The one thread that speaks on a bus: requests in the order of their rank, a stop first."""

import contextlib
import heapq
import itertools
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from pixstep.board.modbus import LineGoneError, RequestError, WriteTimeoutError
from pixstep.errors import UserError
from pixstep.server import messages
from pixstep.server.line import CutShortError, SharedLine, UnsentError
from pixstep.server.messages import Message, RequestMeaning

STOP, FIRST, WRITER, READER = range(4)  # ranks; FIRST: what the server itself asks
_MARK_S = 0.02  # after a mark: boards note when its frame ended
_MORE_S = (
    0.005  # after a stop: another one of the same command may come; so after others that say so
)
SHARED_S = 0.1  # for a reply, while another client moves axes
_AGAIN_S = 0.03  # a stop that went out where a reply may have begun is sent again after it

Finish = Callable[[Message], None]
_ENDS: Message = {"error": messages.PORT, "text": "the server ends"}


@dataclass
class BusRequest:
    """A request on its way; `finish` gets its answer, in the bus's thread, and must not wait.

    `by` names who asked, `is_gone` says that nobody waits for the answer any more.
    """

    by: str
    unit: int
    pdu: bytes
    meaning: RequestMeaning
    finish: Finish
    rank: int = READER
    tells: bool = False  # nobody replies
    patience: tuple[float, int] = (0.5, 0)
    more_follows: bool = False  # another one of the same client: others wait for it a little
    turns: int = 0  # how often it is made again without a reply, after what others ask
    act: Callable[[SharedLine], None] | None = None  # in place of a request
    is_gone: Callable[[], bool] = lambda: False
    overtaken_by: str = ""  # a stop that came later
    was_cut_short: bool = False  # once already
    frames: int = 0  # that the line had sent when a stop came,
    came_s: float = field(default_factory=time.monotonic)

    def share(self) -> None:
        """Keep the bus for little at a time: another client streams."""
        timeout_s, retries = self.patience
        self.patience, self.turns = (min(timeout_s, SHARED_S), 0), retries

    @property
    def urgent(self) -> bool:
        """True for a stop: others give way to it on the line, too."""
        return bool(self.meaning.stops)


@dataclass
class BusCounts:
    """What a bus has done since the server began."""

    requests: int = 0
    stops: int = 0
    no_replies: int = 0
    line_losses: int = 0
    cut_short: int = 0  # requests without a reply that gave way to a stop
    longest_stop_s: float = 0.0  # from a stop's arrival to its frame


class BusThread(threading.Thread):
    """Makes the requests of all clients, one after the other.

    `note` is told of every stop: who, which unit, frames that went out since it came, seconds.
    """

    def __init__(
        self, line: SharedLine, note: Callable[[BusRequest, int, float], None] = lambda *_: None
    ) -> None:
        super().__init__(name="bus", daemon=True)
        self.line, self.counts = line, BusCounts()
        self._note = note
        self._waiting: list[tuple[int, int, BusRequest]] = []
        self._numbers = itertools.count()
        self._changed = threading.Condition()
        self._now: BusRequest | None = None
        self._quiet_s = 0.0  # until then only stops go out,
        self._kept_by = ""  # and what this client asks
        self._there: set[int] = set()  # units that have replied
        self._in_doubt = False  # a request was cut short
        self._told: list[BusRequest] = []  # stops that nobody acknowledges, since then
        self._over = self._ended = False

    def submit(self, job: BusRequest) -> None:
        """Put a request in its place. A stop takes back writes to its boards that still wait."""
        overtaken = []
        with self._changed:
            ended = self._ended
            if job.urgent and not ended:
                job.frames = self.line.call()
                overtaken = self._overtake(job)
            if not ended:
                heapq.heappush(self._waiting, (job.rank, next(self._numbers), job))
                self._changed.notify()
        for other in overtaken:
            other.finish(_overtaken(other))
        if ended:
            job.finish(_ENDS)

    def waiting(self) -> int:
        """Return how many requests wait."""
        return len(self._waiting)

    def close(self) -> None:
        """End; what goes first is made before that, what else waits is not."""
        with self._changed:
            self._over = True
            self.line.call()
            self._changed.notify()
        self.join()
        self.line.close()

    def _overtake(self, stop: BusRequest) -> list[BusRequest]:
        """Take out the writes that a stop makes void; mark the one that is on the line."""
        void = [item for item in self._waiting if _makes_void(stop, item[2])]
        if self._now and _makes_void(stop, self._now):
            self._now.overtaken_by = stop.by
        for item in void:
            item[2].overtaken_by = stop.by
            self._waiting.remove(item)
        heapq.heapify(self._waiting)
        return [job for _, _, job in void]

    def run(self) -> None:
        """Make requests until the bus is closed."""
        while item := self._next():
            number, job = item
            try:
                answer = None if job.is_gone() and not job.urgent else self._do(job, number)
            except Exception as error:  # of whatever kind: the others go on
                answer = {"error": messages.PORT, "text": f"{type(error).__name__}: {error}"}
            with self._changed:
                self._now = None
            if answer is not None:
                job.finish(answer)
        with self._changed:
            self._ended = True
            left, self._waiting = self._waiting, []
        for _, _, job in left:
            job.finish(_ENDS)

    def _next(self) -> tuple[int, BusRequest] | None:
        """Return the next request and its number, as soon as it may go out; None at the end."""
        with self._changed:
            while True:
                wait_s = None
                if self._over and not self._told and not self._first_waits():
                    return None
                if self._waiting:
                    rank, number, job = item = self._awaited() or self._waiting[0]
                    first = rank <= FIRST
                    kept = first or job.by == self._kept_by
                    wait_s = 0.0 if kept else self._quiet_s - time.monotonic()
                    if wait_s <= 0 and (first or not self._told):
                        self._waiting.remove(item)
                        heapq.heapify(self._waiting)
                        self._now, self._kept_by = job, ""
                        break
                if self._told:
                    wait_s = self._quiet_s - time.monotonic()
                    if wait_s <= 0:
                        self._tell_again()
                        continue
                self._changed.wait(wait_s)
        if job.urgent:
            self.line.answered()
        else:
            self._in_doubt = False
        return number, job

    def _awaited(self) -> tuple[int, int, BusRequest] | None:
        """Return what the client asks for whom the bus is kept, unless something goes first."""
        if not self._kept_by or self._first_waits():
            return None
        return next((item for item in self._waiting if item[2].by == self._kept_by), None)

    def _first_waits(self) -> bool:
        return bool(self._waiting) and self._waiting[0][0] <= FIRST

    def _tell_again(self) -> None:
        """Send stops again that may have met a late reply; nothing has gone out since."""
        told, self._told, self._in_doubt = self._told, [], False
        self.line.begin(urgent=True)
        for job in told:
            with contextlib.suppress(LineGoneError, UserError):
                self.line.tell(job.pdu, job.unit)

    def _do(self, job: BusRequest, number: int) -> Message | None:
        """Make a request; return its answer, or None if it waits again."""
        self.counts.requests += 1
        self.line.begin(urgent=job.urgent)
        if job.urgent:
            self._note_stop(job)
        try:
            return self._make(job)
        except UnsentError:
            if not self.line.waits:
                return self._put_back(job, number)
            return self._cut_short(job, number)
        except CutShortError:
            return self._cut_short(job, number)
        except WriteTimeoutError:
            return {"error": messages.WRITE_TIMEOUT}
        except LineGoneError:
            self.counts.line_losses += 1
            return {"error": messages.LINE_GONE}
        except RequestError:
            self.counts.no_replies += 1
            if job.turns and not job.meaning.writes and job.unit in self._there:
                job.turns -= 1
                return self._put_back(job, next(self._numbers))
            return {"error": messages.NO_REPLY, "heard": self.line.heard}
        except UserError as error:
            return {"error": messages.PORT, "text": str(error)}

    def _make(self, job: BusRequest) -> Message:
        """Make a request; raises what the line raises."""
        if job.act:
            job.act(self.line)
            return {}
        if job.tells:
            self.line.tell(job.pdu, job.unit)
            self._told_at(job)
            return {}
        with self.line.patient(*job.patience):
            try:
                reply = self.line.ask(job.unit, job.pdu, urgent=job.urgent)
            except (RequestError, CutShortError):
                self.line.doubt(job.unit)
                raise
        self._there.add(job.unit)
        if job.more_follows:
            self._kept_by, self._quiet_s = job.by, time.monotonic() + _MORE_S
        return {"pdu": reply.pdu.hex(), "heard": self.line.heard}

    def _told_at(self, job: BusRequest) -> None:
        """Keep the line quiet as long as what nobody acknowledges asks for."""
        rest_s = 0.0
        if job.meaning.marks:
            rest_s = _MARK_S
        elif job.urgent:
            rest_s = _MORE_S
            if self._in_doubt:
                rest_s = _AGAIN_S
                self._told.append(job)
        self._quiet_s = time.monotonic() + rest_s

    def _cut_short(self, job: BusRequest, number: int) -> Message | None:
        """Let a request that gave way wait again, if it may be sent again."""
        self.counts.cut_short += 1
        self._in_doubt = True
        repeats = job.patience[1] or not job.meaning.writes
        if job.urgent or job.was_cut_short or job.overtaken_by or not repeats:
            return {"error": messages.NO_REPLY, "heard": self.line.heard}
        job.was_cut_short = True
        return self._put_back(job, number)

    def _put_back(self, job: BusRequest, number: int) -> Message | None:
        """Let a request wait again, in front of all others of its rank."""
        with self._changed:
            if self._over:
                return _ENDS
            if not job.overtaken_by:
                heapq.heappush(self._waiting, (job.rank, number, job))
                return None
        return _overtaken(job)

    def _note_stop(self, job: BusRequest) -> None:
        """Count a stop, and tell of it."""
        late_s = time.monotonic() - job.came_s
        self.counts.stops += 1
        self.counts.longest_stop_s = max(self.counts.longest_stop_s, late_s)
        self._note(job, self.line.frames - job.frames, late_s)


def _makes_void(stop: BusRequest, other: BusRequest) -> bool:
    """True if a stop makes another request void, which came before it and would come after it."""
    fits = stop.unit in (0, other.unit) or other.unit == 0
    means = other.meaning
    stops = messages.ALL_AXES if stop.unit == 0 else stop.meaning.stops
    return fits and means.writes and not other.urgent and bool(stops & means.void_after)


def _overtaken(job: BusRequest) -> Message:
    return {"error": messages.OVERTAKEN, "text": job.overtaken_by}
