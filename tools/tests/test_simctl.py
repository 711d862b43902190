# SPDX-License-Identifier: MIT
"""The simulator's control pipe from the host's side, on the real images: what the tests of settings
and safety stand on.
"""

from fractions import Fraction

import pytest

from bench import Bench
from pixstep import natives
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.logs import read_edges
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions, SimulatorError
from pixstep_trials.probe import BoardProbe

pytestmark = pytest.mark.usefixtures("simulator")
BOARDS = boards.BOARD_NAMES
MS = 16_000
STORE, KEY = 11, 0x5AFE
EEPROM_BYTE_CYCLES = 54_400  # 3.4 ms
POWER_ON, EXTERNAL, BROWN_OUT, WATCHDOG = 1, 2, 4, 8  # bits of reset_cause
LONG = Line((40,) * 200, PLAIN)


def pin_of(board, signal):
    """Port and bit of a signal of the whole board."""
    (pin,) = [one for one in boards.load(board).pins if one.signal == signal]
    return pin.port, pin.bit


def cause_after(bench, act):
    """Return the board's own reset_cause after doing something to it."""
    act()
    bench.sim.boot()
    return bench.board.input("reset_cause")


@pytest.mark.parametrize("board", BOARDS)
def test_reset_causes(board):
    with Bench(board) as bench:
        sim = bench.sim
        assert bench.board.input("reset_cause") == POWER_ON
        assert cause_after(bench, lambda: sim.reset(0)) == EXTERNAL
        assert cause_after(bench, lambda: sim.reset(0, "brownout")) == BROWN_OUT
        assert cause_after(bench, lambda: sim.supply(0, "cycle")) == POWER_ON
        assert cause_after(bench, lambda: sim.supply(0, "cycle", at=sim.cycle + 100)) == POWER_ON
        BoardProbe(sim).hang(0, "main")
        sim.run(200 * MS)
        assert bench.board.input("reset_cause") == WATCHDOG


def test_a_kept_hang_resets_again_and_again():
    with Bench("uno") as bench:
        BoardProbe(bench.sim).hang(0, "main", kept=True)
        bench.sim.run(500 * MS)
        with pytest.raises(BoardError):
            bench.board.input("reset_cause")
        BoardProbe(bench.sim).hang(0, "off")
        bench.sim.run(200 * MS)
        assert bench.board.input("reset_cause") == WATCHDOG


def test_no_power():
    with Bench("mega") as bench:
        bench.sim.supply(0, "off")
        with pytest.raises(BoardError):
            bench.board.input("reset_cause")
        with pytest.raises(SimulatorError, match="the board has no power"):
            bench.sim.reset(0)
        bench.sim.supply(0, "on")
        bench.sim.boot()
        assert bench.board.input("reset_cause") == POWER_ON


def store(bench):
    """Have the settings stored, and return the bytes of EEPROM that this has changed."""
    before = BoardProbe(bench.sim).eeprom_read(0, 0, 1024)
    bench.board.write(regs.COMMAND_BASE, [0, STORE, KEY])
    assert BoardProbe(bench.sim).eeprom_state(0).address is not None
    bench.sim.run(80 * EEPROM_BYTE_CYCLES)
    assert BoardProbe(bench.sim).eeprom_state(0).address is None
    after = BoardProbe(bench.sim).eeprom_read(0, 0, 1024)
    return [at for at in range(1024) if after[at] != before[at]]


@pytest.mark.parametrize("board", BOARDS)
def test_eeprom(board, tmp_path):
    path = tmp_path / "eeprom.bin"
    bench = Bench(board)
    bench.options["eeproms"] = {0: path}
    with bench:
        changed = store(bench)
        assert changed
        writes = BoardProbe(bench.sim).eeprom_state(0).writes
        assert writes >= len(changed)
        bench.sim.flush()
        assert path.read_bytes()[:1024] == BoardProbe(bench.sim).eeprom_read(0, 0, 1024)
        BoardProbe(bench.sim).eeprom_write(0, 1000, b"\x12\x34")
        assert BoardProbe(bench.sim).eeprom_read(0, 999, 3) == b"\xff\x12\x34"
        bench.sim.quit()
    bench = Bench(board)
    bench.options["eeproms"] = {0: path}
    with bench:  # what the run before has left
        assert bench.board.input("settings_serial") == 1
        assert BoardProbe(bench.sim).eeprom_read(0, 1000, 2) == b"\x12\x34"


@pytest.mark.parametrize("board", BOARDS)
def test_permit(board, tmp_path):
    edges = tmp_path / "edges.csv"
    with Bench(board, edges=edges) as bench:
        assert bench.sim.permit(0).level == 0
        bench.board.command("permit_on", [])
        on = bench.sim.permit(0)
        bench.board.command("permit_off", [])
        off = bench.sim.permit(0)
        bench.sim.quit()
    found = read_edges(edges).axis(0, 0)
    assert (on.level, on.changes, off.level, off.changes) == (1, 1, 0, 2)
    assert found.permit_cycles.tolist() == [on.cycle, off.cycle]
    assert found.permit_levels.tolist() == [1, 0]


def test_a_planned_pin_is_exact():
    """An emergency stop in a cycle chosen beforehand: its edge is the only thing that stops."""
    with Bench("uno") as bench:
        bench.load(LONG)
        bench.arm()
        bench.until(lambda: bench.count() > 20)
        at = bench.sim.cycle + 12_345
        port, bit = pin_of("uno", "ESTOP")
        bench.sim.pin(0, port, bit, 0, at=at)
        bench.sim.run(12_345 - 1)
        before = bench.count()
        bench.sim.run(100 * MS)
        assert bench.count() <= before + 2
        assert bench.fault() == "estop"
    with Bench("uno") as bench, pytest.raises(SimulatorError, match="is over, it is"):
        bench.sim.pin(0, port, bit, 0, at=bench.sim.cycle - 1)


@pytest.mark.parametrize("board", BOARDS)
def test_memory_by_name(board):
    with Bench(board) as bench:
        end = BoardProbe(bench.sim).symbol(0, "_end")
        assert end.space == "ram"
        BoardProbe(bench.sim).poke(0, end.address + 200, b"\x12\x34\x56")
        assert BoardProbe(bench.sim).peek(0, "_end+200", 3) == b"\x12\x34\x56"
        assert BoardProbe(bench.sim).symbol(0, "main").space == "flash"
        with pytest.raises(UserError, match="no symbol 'nowhere'"):
            BoardProbe(bench.sim).peek(0, "nowhere")


@pytest.mark.parametrize("board", BOARDS)
def test_last_edges(board, tmp_path):
    with Bench(board, edges=tmp_path / "edges.csv") as bench:
        assert bench.sim.command("last 0 0") == "last 0 0 0 0"
        bench.load(Line((-10, 10), PLAIN))
        bench.arm()
        bench.until(lambda: bench.state() == "done")
        bench.assert_rest()
        bench.sim.command("flush")
        before, last = read_edges(tmp_path / "edges.csv").axis(0, 0).rising[-2:]
        assert bench.sim.command("last 0 0") == f"last 20 0 {last} {before}"


def test_several_boards_power_up_apart(tmp_path):
    """Each at a cycle of its own, another one by another seed; a board alone at the start."""
    images = [(name, natives.image(name)) for name in ("uno", "mega", "uno")]

    def booted(seed, **more):
        with SimLink(SimOptions(images, Fraction(100), seed=seed, **more)) as link:
            units = [link.board(unit) for unit in (1, 2, 3)]
            assert [unit.input("reset_cause") for unit in units] == [1, 1, 1]
            return [row["interrupt_cycles"] for row in link.simulator.stats()["boards"]]

    apart, other, together = booted(1), booted(2), booted(1, power_up_ms=0)
    assert booted(1) == apart != other
    assert abs(together[0] - together[2]) < abs(apart[0] - apart[2])
    assert "--power-up-ms" not in SimOptions(images[:1], Fraction(100)).arguments()


def test_flaws_of_one_boards_pin(tmp_path):
    """Two boards count what reaches their pins: one edge less, one or two more, none in a rest."""
    images = [(name, natives.image(name)) for name in ("uno", "mega")]
    log = tmp_path / "pins.csv"
    with SimLink(SimOptions(images, Fraction(100), pin_log=log)) as link:
        sim = link.simulator
        sim.edge(0, "miss 2")
        sim.edge(1, "add 3 400")
        sim.edge(1, "double 5")
        sim.wait_s(0.205)
        sim.clock("rest 300000")
        sim.edge(0, "pulse")
        sim.edge(1, "pulse", at=sim.cycle + 1000)
        sim.edge(1, "jitter 20000")
        sim.wait_s(0.5)
        sim.flush()
    rows = [text.split(",") for text in log.read_text().splitlines()[1:]]
    pins = [[(int(c), kind) for c, b, kind in rows if b == board] for board in "01"]
    kinds = [[kind for _, kind in pin] for pin in pins]
    assert [one.count("true") for one in kinds] == [len(kinds[1]) - 4, len(kinds[1]) - 3]
    assert [one.count("false") for one in kinds] == [1, 3]
    true = [[c for c, kind in pin if kind == "true"] for pin in pins]
    assert set(true[0]) - set(true[1]) and len(set(true[1][:20]) - set(true[0])) == 1
    resting = [[c for c, _ in pin if 0.275 <= c / sim.tick_hz < 0.57] for pin in pins]
    assert [len(one) for one in resting] == [1, 1]


def test_another_pixel_frequency():
    with Bench("uno") as bench:
        begun = bench.board.input("pixel_edges")
        bench.sim.command("clock hz 5000/7")
        bench.sim.run(1000 * MS)
        assert bench.board.input("pixel_edges") - begun == pytest.approx(5000 / 7, abs=10)
        for text in ("hz 0/1", "hz 5/0", "hz x", "hz"):
            with pytest.raises(SimulatorError):
                bench.sim.command(f"clock {text}")
