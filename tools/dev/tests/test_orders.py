# SPDX-License-Identifier: MIT
"""Commands in every order: a state machine of actions against the real images, and the campaign."""

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule, run_state_machine_as_test

from clock import TICK_HZ
from effort import TRIED_BOARDS, cases
from pixstep.board import registers as regs
from pixstep.simulation.simulator import PermitOutput, Simulator
from pixstep_dev.robustness.orders import actions, campaign
from pixstep_dev.robustness.orders.guard import Guard
from pixstep_dev.robustness.orders.world import ActionOutcome, OrdersWorld

pytestmark = pytest.mark.usefixtures("simulator")
FIXED = settings(
    max_examples=cases(15, 150),
    stateful_step_count=18,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
)
HOW = st.sampled_from((actions.ASK, actions.TELL))
WAITS = st.one_of(st.integers(0, 3000), st.integers(0, 80_000), st.integers(0, 1_600_000))
COUNTS = st.sampled_from((1, 2, 7, 10, 40, 300, 500))  # steps/pixel, 30 pixels/s
OFFS = st.sampled_from((0, 0, 0, 0, -1, 1))  # of a block's number
TOKENS = st.sampled_from((None, None, None, 5))
AHEAD = st.sampled_from((0, 1, 3, 3))  # edges that `go` names ahead, at 30 Hz; 0: none
ENDINGS = st.sampled_from(("stop", "disarm", "discard"))
BAD_BLOCKS = (((0x7FFF, 0),), ((1, 0), (0, 0), (20_000, 1)), ((5, 5), (2, 0)), ((2, 0),))


class Orders(RuleBasedStateMachine):
    """Any action may follow any other; after each one the model's rules hold."""

    board = ""

    def __init__(self):
        super().__init__()
        self.world = OrdersWorld(self.board, clock_hz=30).__enter__()
        self.guard = Guard(self.world)

    def teardown(self):
        try:
            if not self.guard.complaints:
                self.guard.recover()
            assert self.guard.complaints == []
        finally:
            self.world.__exit__()

    @initialize(careful=st.booleans())
    def begin(self, careful):
        self.guard.careful = careful
        self.do(actions.Frequency(30))

    @rule(mask=st.integers(1, 15), count=COUNTS, clocked=st.booleans(), token=TOKENS, how=HOW,
          step=st.booleans(), more=st.integers(0, 70_000), fresh=st.booleans())  # fmt: skip
    def lines_armed(self, mask, count, clocked, token, how, step, more, fresh):
        """What random rules seldom come to by themselves: lines that move."""
        mark, mask = 0x21 if clocked else 0x01, mask & self.world.all_axes or 1
        if fresh:
            self.guard.recover()
            assert self.guard.complaints == []
        for axis in range(self.world.axes):
            if mask >> axis & 1:
                entries = ((mark, 0), (0, 0), (count + axis, 1000), (2, 0))
                self.do(actions.QueueBlock(axis, entries, 0, how))
        self.do(actions.BoardOrder("arm", mask, token, how))
        axis = mask.bit_length() - 1
        self.do(actions.StepWait(axis, TICK_HZ // 10, more) if step else actions.Wait(more))

    @rule(count=st.sampled_from((10, 20, 40)), mask=st.sampled_from((1, 3, 15)), first=ENDINGS,
          second=ENDINGS, step=st.booleans(), more=st.integers(0, 70_000),
          gap=st.integers(0, 40_000), how=HOW)  # fmt: skip
    def ended_twice(self, count, mask, first, second, step, more, gap, how):
        """Inside a period that the timer holds."""
        self.lines_armed(mask, count, False, None, actions.TELL, step, more, True)
        self.do(actions.BoardOrder(first, mask & self.world.all_axes, None, actions.TELL))
        self.do(actions.Wait(gap))
        self.do(actions.BoardOrder(second, mask & self.world.all_axes, None, how))
        self.do(actions.Look())
        self.do(actions.Wait(TICK_HZ // 20))

    @rule(gap=st.integers(1000, 3000))
    def stopped_beside_permit(self, gap):
        """The emergency stop within the round that serves the request."""
        self.do(actions.PinInput("ESTOP", 0, 1))
        self.do(actions.BoardOrder("clear_fault", 0))
        self.do(actions.BoardOrder("permit_on", 0, None, actions.TELL))
        self.do(actions.Wait(gap))
        self.do(actions.PinInput("ESTOP", 0, 0))
        self.do(actions.Wait(1000))

    def do(self, action):
        self.guard.do(action)
        assert self.guard.complaints == []

    @rule(axis=st.integers(0, 3), count=COUNTS, negative=st.booleans(), clocked=st.booleans(),
          pixels=st.sampled_from((1, 3, 1000)), how=HOW, off=OFFS)  # fmt: skip
    def plain_line(self, axis, count, negative, clocked, pixels, how, off):
        mark = 0x21 if clocked else 0x01
        runs = ((-count if negative else count, pixels), (2, 0))
        self.do(actions.QueueBlock(axis % self.world.axes, ((mark, 0), (0, 0), *runs), off, how))

    @rule(axis=st.integers(0, 3), quarter=st.sampled_from((1, 5, 20)), how=HOW)
    def smooth_line(self, axis, quarter, how):
        rise = ((quarter, 1), (3 * quarter, 1))
        entries = ((0x11, 0), (0, 0), *rise, (4 * quarter, 500), *reversed(rise), (2, 0))
        self.do(actions.QueueBlock(axis % self.world.axes, entries, 0, how))

    @rule(axis=st.integers(0, 3), opens=st.booleans(), how=HOW)
    def seek(self, axis, opens, how):
        mark = 0x181 if opens else 0x81
        entries = ((mark, 0), (0, 0), (2, 1), (8, 20), (3, 0), (2, 1), (2, 0))
        self.do(actions.QueueBlock(axis % self.world.axes, entries, 0, how))

    @rule(axis=st.integers(0, 3), entries=st.sampled_from(BAD_BLOCKS), how=HOW)
    def bad_block(self, axis, entries, how):
        self.do(actions.QueueBlock(axis % self.world.axes, entries, 0, how))

    @rule(name=st.sampled_from([name for name in regs.COMMANDS if name != "default_settings"]),
          mask=st.sampled_from((0, 1, 1, 1, 2, 3, 5, 15, 15)),
          argument=st.sampled_from((None, None, None, 0, 5, 6)), how=HOW, ahead=AHEAD)  # fmt: skip
    def order(self, name, mask, argument, how, ahead):
        self.do(actions.BoardOrder(name, mask, argument, how, ahead if name == "go" else 0))

    @rule(name=st.sampled_from(("arm", "stop", "stop", "disarm", "discard")), how=HOW)
    def order_of_all(self, name, how):
        self.do(actions.BoardOrder(name, self.world.all_axes, None, how))

    @rule(first=st.integers(0, 13), value=st.integers(0, 1), more=st.integers(0, 2), how=HOW)
    def coils(self, first, value, more, how):
        self.do(actions.Coils(first, (value,) * (1 + more), how))

    @rule(name=st.sampled_from(("backlash_policy", "enable_settle_ms", "start_stop_steps")),
          value=st.sampled_from((0, 1, 5, 20_000)), how=HOW)  # fmt: skip
    def setting(self, name, value, how):
        self.do(actions.Setting(name, value, how))

    @rule(text=st.sampled_from(("on", "off", "drop 1", "hz 30/1", "hz 33/1", "hz 70/1")))
    def clock(self, text):
        self.do(actions.ClockCommand(text))

    @rule(signal=st.sampled_from(("ESTOP", "HOME", "LIMIT_MINUS", "LIMIT_PLUS")),
          level=st.integers(0, 1))  # fmt: skip
    def pin(self, signal, level):
        self.do(actions.PinInput(signal, 0, level))

    @rule(what=st.sampled_from(("cycle", "external", "brownout")), chance=st.integers(0, 7))
    def supply(self, what, chance):
        if chance:
            return
        self.do(actions.Supply(what))
        self.do(actions.Frequency(30))

    @rule(cycles=WAITS)
    def wait(self, cycles):
        self.do(actions.Wait(cycles))

    @rule(axis=st.integers(0, 3), more=st.integers(0, 70_000))
    def step(self, axis, more):
        self.do(actions.StepWait(axis % self.world.axes, TICK_HZ // 10, more))

    @rule()
    def look(self):
        self.do(actions.Look())


class Uno(Orders):
    board = "uno"


class Mega(Orders):
    board = "mega"


@pytest.mark.parametrize("machine", [Uno, Mega])
def test_any_order(machine):
    run_state_machine_as_test(machine, settings=FIXED)


def play(board, *played):
    """Do actions on a fresh board; return the guard behind its recovery."""
    with OrdersWorld(board) as world:
        guard = Guard(world)
        for action in played:
            guard.do(action)
        guard.recover()
    return guard


LINE = ((1, 0), (0, 0), (10, 1000), (2, 0))
MOVING = (
    actions.Frequency(30),
    actions.QueueBlock(0, LINE),
    actions.BoardOrder("permit_on", 0),
    actions.BoardOrder("arm", 1),
    actions.Wait(TICK_HZ // 20),
)


TRIALS = cases(40, 150)
TOGETHER = cases(15, 100)
RESTS = cases(6, 10)


@pytest.mark.parametrize("board", TRIED_BOARDS)
def test_campaign(invoke, board):
    done = invoke(
        "robustness", "orders", "--board", board, "--count", TRIALS, "--seed", 5, "--json"
    )
    outcome = json.loads(done.stdout)
    assert outcome["failures"] == []
    assert outcome["trials"] == TRIALS
    assert outcome["edges"] > 60 * TRIALS
    assert len(outcome["pairs"]) > TRIALS // 3
    assert outcome["faults"]["estop"] >= TRIALS // 50


def test_together(invoke):
    done = invoke(
        "robustness", "orders", "--board", "mega", "--together", "--count", TOGETHER, "--json"
    )
    outcome = json.loads(done.stdout)
    assert outcome["failures"] == []
    assert set(outcome["started"]) == {"all", "none"}
    assert outcome["started"]["all"] > TOGETHER // 2


@pytest.mark.parametrize("board", TRIED_BOARDS)
def test_rests(invoke, board):
    done = invoke("robustness", "orders", "--board", board, "--rests", "--count", RESTS, "--json")
    outcome = json.loads(done.stdout)
    assert outcome["failures"] == []
    assert outcome["rests"] >= RESTS // 2
    assert outcome["lines"] > 0
    assert outcome["slowest_cycles"] > 0


def test_a_trial_can_be_had_again():
    plan = campaign.OrdersPlan("uno", 3, 9)
    said = [[], []]
    for lines in said:
        assert campaign.replay(plan, 2, lines.append)
    assert said[0] == said[1]
    assert len(said[0]) > 5


def test_edges_behind_a_stop_are_a_complaint(monkeypatch):
    """The stop does not reach the board: its steps go on."""
    perform = OrdersWorld.perform

    def deaf(world, action):
        if isinstance(action, actions.BoardOrder) and action.name == "stop":
            return ActionOutcome(True, world.cycle)
        return perform(world, action)

    monkeypatch.setattr(OrdersWorld, "perform", deaf)
    guard = play("uno", *MOVING, actions.BoardOrder("stop", 1), actions.Wait(TICK_HZ // 20))
    assert any("halted by" in text for text in guard.complaints)


def test_a_lost_step_is_a_complaint(monkeypatch):
    edges = OrdersWorld.edges
    monkeypatch.setattr(
        OrdersWorld, "edges", lambda *place: edges(*place)._replace(steps=edges(*place).made // 2)
    )
    guard = play("uno", *MOVING, actions.BoardOrder("stop", 1), actions.Wait(TICK_HZ // 20))
    assert any("steps made" in text for text in guard.complaints)


def test_permit_behind_a_stop_is_a_complaint(monkeypatch):
    monkeypatch.setattr(
        Simulator, "permit", lambda self, _: PermitOutput(1, 1, self.cycle, self.cycle)
    )
    guard = play("uno", *MOVING, actions.BoardOrder("stop", 1), actions.Wait(TICK_HZ // 20))
    assert any("PERMIT must be low" in text for text in guard.complaints)


def test_lost_time_is_a_complaint():
    with OrdersWorld("uno") as world:
        guard = Guard(world)
        address, size, _ = world.time_words(0)[2]
        world.add(address, size, 65_536)
        guard.recover()
    assert any("account of time" in text for text in guard.complaints)


def test_what_a_refusal_changes_is_a_complaint(monkeypatch):
    written = iter(range(100))
    monkeypatch.setattr(OrdersWorld, "registers", lambda _: dict.fromkeys(
        ("command", "settings", "outputs"), (next(written),)))  # fmt: skip
    with OrdersWorld("uno") as world:
        guard = Guard(world)
        guard.careful = True
        guard.do(actions.BoardOrder("arm", 1))
    assert any("changed command" in text for text in guard.complaints)


def test_figures_are_written(invoke, tmp_path):
    path = Path(tmp_path) / "ORDERS.md"
    path.write_text("<!-- begin generated: orders-uno -->\n<!-- end generated: orders-uno -->\n")
    invoke("robustness", "orders", "--board", "uno", "--count", 4, "--write", path)
    assert "4 trials on the uno from seed 1" in path.read_text()


def test_together_is_for_the_mega(invoke):
    invoke("robustness", "orders", "--board", "uno", "--together", status=2)
