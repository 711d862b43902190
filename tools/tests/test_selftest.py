# SPDX-License-Identifier: MIT
"""The self-test: a person who does what is asked, one who errs, one who is not there."""

import pytest

from fake_board import FakeBoard, FakeLine, FakeWorld
from pixstep.board import boards, selftest
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.board.modbus import SimClient
from pixstep.board.selftest import FAILED, OK, SKIPPED, SelfTest
from test_board_images import Live

INPUTS = {"HOME": 0, "LIMIT_MINUS": 1, "LIMIT_PLUS": 2}
BOARDS = boards.BOARD_NAMES


class Machine:
    """What a person can do at a machine; here at a fake board's."""

    def __init__(self, kind="mega"):
        self.world = FakeWorld()
        self.fake = FakeBoard(self.world, 1, kind)
        self.fake.clock = True
        self.client = SimClient(FakeLine(self.world, self.fake))

    def work(self, signal, axis):
        for seconds in (0.5, 1.0):
            self.world.later(seconds, lambda: self.toggle(signal, axis))

    def toggle(self, signal, axis):
        self.fake.inputs_bits ^= 1 << 4 * axis + INPUTS[signal]

    def stop(self, pressed):
        self.world.later(0.5, lambda: self.fake.press_estop(pressed))


class LiveMachine:
    """The same at a simulated board's pins."""

    def __init__(self, live):
        self.live, self.world, self.client = live, live.world, live.client

    def work(self, signal, axis):
        self.live.pin(signal, 0, axis)
        self.live.pin(signal, 1, axis, later_s=0.2)

    def stop(self, pressed):
        self.live.pin("ESTOP", 0 if pressed else 1)


class Person:
    """Says yes to all but some questions, and does what is asked but for some mistakes."""

    def __init__(self, machine, no=(), swapped=None, lazy=()):
        self.machine, self.no, self.swapped, self.lazy = machine, no, swapped or {}, lazy
        self.asked, self.defaults = [], {}

    def agrees(self, question, *, default=True):
        self.asked.append(question)
        self.defaults[question] = default
        return not any(text in question for text in self.no)

    def says(self, text):
        if any(word in text for word in self.lazy):
            return
        if "emergency" in text:
            self.machine.stop(True)
        elif text.startswith("Release"):
            self.machine.stop(False)
        else:
            signal, axis = text.split()[2], int(text.split("axis ")[1][0])
            self.machine.work(*self.swapped.get((signal, axis), (signal, axis)))


def test_of(machine, person, axes=(0,), **options):
    board = Device(machine.client)
    return SelfTest(board, board.who(), machine.world, person, list(axes), **options)


test_of.__test__ = False


def verdicts(test):
    return {result.name: result.verdict for result in test.go()}


def texts(test):
    return {result.name: (result.verdict, result.text) for result in test.go()}


def test_all_is_well():
    machine = Machine()
    person = Person(machine)
    test = test_of(machine, person, (0, 1))
    found = texts(test)
    assert {verdict for verdict, _ in found.values()} == {OK}
    assert test.passed and len(found) == 4 + 2 * 3 + 2 * 2 + 2
    assert found["axis 1 LIMIT_PLUS"][1] == "LIMIT_PLUS on A13 seen"
    assert found["pixel clock"][1].endswith("Hz; set to 30 Hz")
    assert machine.fake.axes[1].position == 0 and machine.fake.axes[1].lines_done == 2
    assert not machine.fake.permit and not machine.fake.fault[0]


def test_nobody_there_moves_nothing_and_switches_nothing():
    machine = Machine()
    test = test_of(machine, None)
    found = verdicts(test)
    assert [name for name, verdict in found.items() if verdict == OK] == [
        "identity", "supply", "fault", "pixel clock",
    ]  # fmt: skip
    assert set(found.values()) == {OK, SKIPPED} and test.passed
    assert machine.fake.commands == []


def test_a_person_who_declines_everything_moves_nothing():
    machine = Machine()
    found = verdicts(test_of(machine, Person(machine, no=("?",))))
    assert set(found.values()) == {OK, SKIPPED}
    assert machine.fake.commands == []


def test_a_wrong_input_is_named():
    machine = Machine()
    person = Person(machine, swapped={("LIMIT_MINUS", 1): ("LIMIT_PLUS", 0)})
    found = texts(test_of(machine, person, (0, 1)))
    assert found["axis 1 LIMIT_MINUS"] == (
        FAILED, "LIMIT_PLUS on A12 (axis 0) changed instead of LIMIT_MINUS on A9",
    )  # fmt: skip


def test_a_switch_that_is_tripped_when_let_go():
    machine = Machine()
    for signal in ("HOME", "LIMIT_PLUS"):
        machine.toggle(signal, 0)
    found = texts(test_of(machine, Person(machine)))
    assert found["axis 0 HOME"][0] == OK
    assert found["axis 0 LIMIT_PLUS"][0] == FAILED
    assert "tripped when let go: setting inputs_inverted?" in found["axis 0 LIMIT_PLUS"][1]


def test_a_switch_that_sticks():
    machine = Machine()
    machine.work = lambda signal, axis: machine.toggle(signal, axis)
    found = texts(test_of(machine, Person(machine), limit_s=2))
    assert found["axis 0 HOME"] == (FAILED, "HOME on A0 did not change back in 2 s")


def test_a_fault_fails_its_check_and_no_other():
    machine = Machine()
    machine.fake.obey_arm = lambda *_: machine.fake.latch("limit_plus")
    found = texts(test_of(machine, Person(machine)))
    assert found["axis 0 STEP, DIR"][0] == FAILED and "limit_plus" in found["axis 0 STEP, DIR"][1]
    assert found["axis 0 ENABLE"][0] == OK and "ESTOP" in found


def test_an_input_that_does_not_change():
    machine = Machine()
    test = test_of(machine, Person(machine, lazy=("HOME",)), limit_s=3)
    assert texts(test)["axis 0 HOME"] == (FAILED, "HOME on A0 did not change in 3 s")
    assert not test.passed


@pytest.mark.parametrize(("hz", "verdict"), [(30, OK), (29.9, OK), (33, FAILED), (25, FAILED)])
def test_the_clock_is_measured(hz, verdict):
    machine = Machine()
    machine.fake.clock_hz = hz
    assert texts(test_of(machine, None))["pixel clock"][0] == verdict


MEASURED = 1 << 7  # bit of `status`


@pytest.mark.parametrize(
    ("period_ticks", "new_edges", "verdict"),
    [
        (16_000_000 // 30, {}, OK),
        (16_000_000 // 25, {}, FAILED),
        (16_000_000 // 30, {"clock_missing": 1}, FAILED),
        (16_000_000 // 30, {"clock_glitches": 1}, FAILED),
        (0, {}, FAILED),
    ],
)
def test_a_board_behind_the_time_of_its_host_tells_by_its_own(period_ticks, new_edges, verdict):
    """As a simulated one on a busy machine: 10 edges in a second of the host's."""
    machine = Machine()
    machine.fake.clock_hz = 10
    status = machine.fake.status
    machine.fake.status = lambda: status() | MEASURED
    machine.fake.values |= {"clock_period_ticks": period_ticks, "clock_missing": 7}
    wait = machine.world.wait

    def pass_time(seconds):
        wait(seconds)
        if seconds >= 1:
            for name, count in new_edges.items():
                machine.fake.values[name] = machine.fake.values.get(name, 0) + count

    machine.world.wait = pass_time
    assert texts(test_of(machine, None))["pixel clock"][0] == verdict


def test_a_missing_clock_is_told_with_its_pin():
    machine = Machine()
    machine.fake.clock = False
    verdict, text = texts(test_of(machine, None))["pixel clock"]
    assert verdict == FAILED and text.startswith("no edge on PIXEL_CLOCK on D48")


@pytest.mark.parametrize("kind", ["uno", "mega"])
def test_a_clock_that_is_not_wired_is_skipped_if_someone_says_so(kind):
    machine = Machine(kind)
    machine.fake.clock = False
    person = Person(machine, no=("pixel clock",))
    test = test_of(machine, person)
    verdict, text = texts(test)["pixel clock"]
    assert (verdict, text) == (SKIPPED, "not wired: run lines with --sync free")
    asked = [question for question in person.asked if "pixel clock" in question]
    assert asked[-1].startswith("Is a pixel clock wired to PIXEL_CLOCK on D")
    assert test.passed


@pytest.mark.parametrize(
    ("cause", "text"), [(4, "brown-out; the 5 V supply"), (8, "watchdog; the firmware hung")]
)
def test_a_bad_reset_is_told(cause, text):
    machine = Machine()
    machine.fake.values["reset_cause"] = cause
    found = texts(test_of(machine, None))["supply"]
    assert found[0] == FAILED and text in found[1]


def test_a_latched_fault_is_cleared_only_when_agreed():
    for person_of, verdict in ((Person, OK), (lambda machine: None, FAILED)):
        machine = Machine()
        machine.fake.latch("limit_plus")
        found = texts(test_of(machine, person_of(machine)))["fault"]
        assert found[0] == verdict and "limit_plus" in found[1]
        assert bool(machine.fake.fault[0]) is (verdict == FAILED)


def test_a_motor_that_does_not_follow():
    machine = Machine()
    found = texts(test_of(machine, Person(machine, no=("turn back",))))
    assert found["axis 0 STEP, DIR"] == (FAILED, "the motor did not follow: look at DIR on D22")
    found = texts(test_of(Machine(), Person(machine, no=("hold",))))
    assert found["axis 0 ENABLE"][0] == FAILED


def clears_while_pressed(fake):
    fake.obey_clear_fault = lambda *_: setattr(fake, "fault", (0, 0, 0, 0))


def latches_nothing(fake):
    fake.press_estop = lambda pressed: setattr(fake, "estop", pressed)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (clears_while_pressed, "the fault cleared while it was pressed"),
        (latches_nothing, "pressed, but no fault estop is latched"),
    ],
)
def test_an_emergency_stop_that_does_not_latch(change, text):
    machine = Machine()
    change(machine.fake)
    assert texts(test_of(machine, Person(machine)))["ESTOP"] == (FAILED, text)


def test_an_emergency_stop_that_is_not_wired():
    machine = Machine()
    found = texts(test_of(machine, Person(machine, lazy=("Press",)), limit_s=2))
    assert found["ESTOP"] == (FAILED, "ESTOP on D18 did not trip in 2 s")
    found = texts(test_of(machine, Person(machine, lazy=("Release",)), limit_s=2))
    assert found["ESTOP"] == (FAILED, "ESTOP on D18 stayed tripped for 2 s")


def test_permit_goes_off_again_whatever_comes():
    machine = Machine()

    class Gone(Person):
        def agrees(self, question, *, default=True):
            del default
            if "permits on" in question:
                raise KeyboardInterrupt
            return "permit output" in question

    with pytest.raises(KeyboardInterrupt):
        test_of(machine, Gone(machine)).go()
    assert not machine.fake.permit and ("permit_off", 1, 0) in machine.fake.commands


def test_enter_alone_switches_no_laser_on():
    machine = Machine()
    person = Person(machine)
    assert test_of(machine, person).go()
    no = [question for question, default in person.defaults.items() if not default]
    assert len(no) == 1 and no[0].startswith("Switch the permit output")


def test_drivers_are_as_before_whatever_comes():
    machine = Machine()
    machine.fake.obey("enable", 0b0010, 0)
    assert test_of(machine, Person(machine), axes=(0, 1, 2)).go()
    assert machine.fake.commands[-1] == ("disable", 0b0101, 0)
    assert Device(machine.client).input("outputs") == 0b0010


def test_ctrl_c_stops_the_motor_that_turns():
    machine = Machine()

    def interrupt():
        assert machine.fake.axes[0].state == "running"
        raise KeyboardInterrupt

    class Hasty(Person):
        def agrees(self, question, *, default=True):
            del default
            if "slow steps" in question:
                machine.world.later(0.5, interrupt)
            return "slow steps" in question

    with pytest.raises(KeyboardInterrupt):
        test_of(machine, Hasty(machine), steps=1000).go()
    assert machine.fake.axes[0].state == "empty"
    assert [name for name, _, _ in machine.fake.commands[-2:]] == ["stop", "disable"]


def test_a_board_that_moves_is_left_alone():
    machine = Machine()
    machine.fake.axes[0].state = "running"
    machine.fake.axes[0].entries = [(1, 60_000)]
    with pytest.raises(BoardError, match="is armed or moves"):
        test_of(machine, Person(machine)).go()


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("name", BOARDS)
def test_the_images_pass(make_console, name):
    live = Live(make_console, (name,), hz=30)
    try:
        axes = tuple({0, boards.load(name).axes - 1})
        test = test_of(LiveMachine(live), Person(LiveMachine(live)), axes, steps=60)
        found = texts(test)
        assert {verdict for verdict, _ in found.values()} == {OK}, found
        assert all(live.sim.count(0, axis) == 120 for axis in axes)
        assert all(live.sim.steps(0, axis) == 0 for axis in axes)
    finally:
        live.sim.kill()


def test_the_command(make_console):
    machine = Machine()
    console = make_console(FakeLine(machine.world, machine.fake), machine.world)
    text = console.out("selftest", "--yes")
    assert "ok      pixel clock: " in text and text.endswith("4 ok, 0 failed, 22 skipped\n")
    found = console.json("selftest", "--yes", "--axis", 1)
    assert found["passed"] and found["checks"][0] == {
        "name": "identity", "verdict": "ok", "text": "pixstep mega 0.1, 4 axes",
    }  # fmt: skip
    for seconds in (3, 5):
        machine.world.later(seconds, lambda: machine.toggle("HOME", 0))
    # home yes, limits no, driver no, motor no, permit no, stop no
    found = console.json("selftest", "--axis", 0, say="y\n" + "n\n" * 6)
    by_name = {row["name"]: row["verdict"] for row in found["checks"]}
    assert by_name["axis 0 HOME"] == OK and by_name["axis 0 LIMIT_PLUS"] == SKIPPED
    machine.fake.clock = False
    text = console.out("selftest", "--yes", status=1)
    assert "failed  pixel clock: no edge on PIXEL_CLOCK on D48" in text


def test_verdicts_have_colours():
    from pixstep.cli.board.person import COLOURS

    assert set(COLOURS) == {selftest.OK, selftest.FAILED, selftest.SKIPPED}
