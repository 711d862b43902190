# SPDX-License-Identifier: MIT
"""Every client on every board's image in the simulator, and the table of what came of it."""

import contextlib
import selectors
import subprocess
from collections.abc import Callable, Iterator

from pixstep import natives
from pixstep.board import boards
from pixstep.errors import UserError
from pixstep.progress import Progress, unseen
from pixstep_dev import markdown
from pixstep_dev.robustness.clients import by_libmodbus, by_mbpoll, by_pymodbus, cases

CLIENTS: dict[str, Callable[[str, str], dict[str, str]]] = {
    "mbpoll": by_mbpoll.run,
    "libmodbus": by_libmodbus.run,
    "pymodbus": by_pymodbus.run,
}
_START_S = 120

Results = dict[tuple[str, str], dict[str, str]]  # by client and board: result by case


@contextlib.contextmanager
def pty_board(board: str) -> Iterator[str]:
    """Run a board's image on a pseudo terminal, in real time; yield its path."""
    image = natives.image(board)
    words = [natives.program("pixstep-sim"), "--board", f"{board}={image}", "--pty"]
    process = subprocess.Popen(
        [str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout and process.stderr  # pipes
    try:
        with selectors.DefaultSelector() as ready:
            ready.register(process.stdout, selectors.EVENT_READ)
            port = process.stdout.readline().strip() if ready.select(_START_S) else ""
        if not port:
            process.kill()
            raise UserError(f"simulator: no pseudo terminal: {process.stderr.read().strip()}")
        yield port
    finally:
        process.kill()
        process.communicate()


def run(
    names: tuple[str, ...] = boards.BOARD_NAMES,
    progress: Progress = unseen,
) -> Results:
    """Run the list with every client on these boards, each on a fresh one."""
    results: Results = {}
    pairs = [(client, board) for client in CLIENTS for board in names]
    for client, board in pairs:
        with pty_board(board) as port:
            results[client, board] = CLIENTS[client](port, board)
        progress(len(results) / len(pairs))
    return results


def failures(results: Results) -> list[str]:
    """Return a line for every case that failed."""
    return [
        f"{client} on {board}: {name}: {text}"
        for (client, board), found in results.items()
        for name, text in found.items()
        if text.startswith(cases.FAIL)
    ]


def table(results: Results) -> str:
    """Return the results as Markdown: a row a case, a column a client."""
    head = ("case", "function", "what", *CLIENTS)
    rows = [
        (
            case.name,
            case.function,
            case.about,
            *(_cell(results, client, case.name) for client in CLIENTS),
        )
        for case in cases.CASES
    ]
    served = ", ".join(
        f"{client} {sum(text == cases.OK for text in found.values())} on the {board}"
        for (client, board), found in results.items()
    )
    return f"{markdown.table(head, rows)}\n\nCases that are ok: {served}.\n"


def _cell(results: Results, client: str, name: str) -> str:
    """Return a client's result, once if it is the same on every board."""
    found = {
        board: text[name].split(":")[0] for (who, board), text in results.items() if who == client
    }
    if len(set(found.values())) == 1:
        return next(iter(found.values()))
    return ", ".join(f"{board} {text}" for board, text in found.items())
