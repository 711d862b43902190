# SPDX-License-Identifier: MIT
"""The process that plans a program for another one: a Request comes in, messages go out.

python -m pixstep.programs.planner
"""

import contextlib
import os
import pickle
import sys
from threading import Thread
from typing import BinaryIO

import numpy as np

from pixstep.errors import PlainError
from pixstep.programs import sources


def main() -> None:
    """Plan what the standard input asks for; end quietly when nobody takes it any more."""
    request: sources.Request = pickle.load(sys.stdin.buffer)
    Thread(target=_end_with_the_other, daemon=True).start()
    out = sys.stdout.buffer
    with contextlib.suppress(BrokenPipeError):
        try:
            for part in request.parts():
                _send(out, sources.COUNTS, part.astype(np.int32))
            _send(out, sources.END, None)
        except PlainError as error:
            _send(out, sources.ERROR, error)


def _end_with_the_other() -> None:
    """End this process when the one that asks has ended, however that was: its pipe closes then.

    The bare descriptor is read: a reader that waits in sys.stdin keeps the interpreter from ending.
    """
    with contextlib.suppress(OSError):
        while os.read(sys.stdin.fileno(), 1):
            pass
    os._exit(1)


def _send(out: BinaryIO, kind: str, found: object) -> None:
    pickle.dump((kind, found), out, pickle.HIGHEST_PROTOCOL)
    out.flush()


if __name__ == "__main__":
    main()
