# SPDX-License-Identifier: MIT
"""The switches of the mechanics: delay, bounce, stuck contacts, other knobs at run time.

images/shuttle.c moves axis 0 to and fro; what the switches must do follows from its STEP and DIR
edges by a model of their own here.
"""

import unittest
from itertools import pairwise

from harness import (
    GPIOR2,
    RESULT_ADDRESS,
    Session,
    SimTest,
    image,
    read_edges,
    read_switches,
    rising,
)

RUN_CYCLES = 200_000
SECOND_TICKS = 16_000_000
OPEN, CLOSED = 1, 0  # to ground, with the pull-up

# Closed at 12, open at 12 - 5; the limits at and beyond 1 and 18.
HOME, HYSTERESIS, MINUS, PLUS = 12, 5, 1, 18
KNOBS = f"home={HOME},hyst={HYSTERESIS},travel={MINUS}..{PLUS},over=1000"


def positions(edges):
    """(cycle, position) after each step of axis 0."""
    at, down, made = 0, 0, []
    for cycle, _, _, signal, level in edges:
        if signal == "DIR":
            down = level
        elif signal == "STEP" and level:
            at += -1 if down else 1
            made.append((cycle, at))
    return made


def changes(edges):
    """What the switches do: (cycle, switch, level) of each change after the start."""
    is_closed = {"home": False, "minus": True, "plus": False}
    found = []
    for cycle, at in positions(edges):
        home = at > HOME - HYSTERESIS if is_closed["home"] else at >= HOME
        now = {"home": home, "minus": at <= MINUS, "plus": at >= PLUS}
        for switch, closed in now.items():
            if closed != is_closed[switch]:
                found.append((cycle, switch, CLOSED if closed else OPEN))
        is_closed = now
    return found


class PlantTest(SimTest):
    def setUp(self):
        super().setUp()
        self.edges_path = self.folder / "edges.csv"
        self.log_path = self.folder / "switches.csv"

    def session(self, knobs, board="uno", name="shuttle", options=()):
        files = ["--edges", str(self.edges_path), "--switch-log", str(self.log_path)]
        sim = Session(image(board, name), options=[*files, "--plant", f"0.0:{knobs}", *options])
        self.addCleanup(sim.__exit__)
        return sim

    def tell(self, sim, command):
        answer = sim.ask(command)
        self.assertTrue(answer.startswith("ok"), f"{command}: {answer}")
        return answer

    def log(self, sim, switch=None):
        """The log after the pins' first levels at cycle 0."""
        self.tell(sim, "flush")
        rows = [row for row in read_switches(self.log_path) if row[0] > 0]
        return [row for row in rows if switch in (None, row[1])]

    def changes(self, sim, until, delay=0, switch=None):
        """What the log should be without bounces, by the STEP edges."""
        self.tell(sim, "flush")
        rows = changes(read_edges(self.edges_path))
        rows = [(cycle + delay, name, level) for cycle, name, level in rows]
        return [row for row in rows if row[0] <= until and switch in (None, row[1])]


class Delay(PlantTest):
    def check(self, board, delay):
        sim = self.session(f"{KNOBS},delay={delay}", board)
        self.assertEqual(self.tell(sim, f"run {RUN_CYCLES}"), f"ok {RUN_CYCLES}")
        expected = self.changes(sim, RUN_CYCLES, delay)
        self.assertGreater(len(expected), 30)
        self.assertEqual(sorted(self.log(sim)), sorted(expected))

    def test_exact_cycle(self):
        for board in ("uno", "mega"):
            for delay in (0, 1, 2, 3, 777, 9_999, 25_000):
                with self.subTest(board=board, delay=delay):
                    self.check(board, delay)

    def test_a_whole_second(self):
        """The longest; the load has long gone on by then."""
        sim = self.session(f"home=5,hyst=2,start=-5,delay={SECOND_TICKS}", name="intervals")
        self.tell(sim, "run 400000")
        self.assertEqual(self.log(sim), [])
        self.tell(sim, f"run {SECOND_TICKS}")
        self.tell(sim, "flush")
        tenth = rising(read_edges(self.edges_path))[9]
        self.assertEqual(self.log(sim), [(tenth + SECOND_TICKS, "home", CLOSED)])

    def test_across_a_reset(self):
        """images/watchdog.c resets itself at 15 ms: the wire does not care."""
        for board in ("uno", "mega"):
            with self.subTest(board=board):
                sim = self.session("home=200,delay=100000", board, "watchdog")
                self.tell(sim, "run 400000")
                self.tell(sim, "flush")
                step = rising(read_edges(self.edges_path))[199]
                self.assertLess(step, 240_000)
                self.assertEqual(sim.results(1), [2])
                self.assertEqual(self.log(sim), [(step + 100_000, "home", CLOSED)])

    def test_too_many_changes_under_way(self):
        sim = self.session(f"{KNOBS},delay={SECOND_TICKS}")
        answer = sim.ask(f"run {SECOND_TICKS}")
        text = "error board 0 (uno): axis 0: more than 64 changes of a switch within its delay"
        self.assertTrue(answer.startswith(text), answer)

    def test_reads_as_the_pin_reads(self):
        """PINC's bit 0 is the home pin, before and after its edge."""
        sim = self.session(f"{KNOBS},delay=1000")
        for _ in range(200):
            self.tell(sim, "run 997")
            level = int(sim.ask("peek 0 0x26 1").split()[1], 16) & 1
            self.assertEqual(level, int(sim.ask("switches 0 0").split()[2]))


class Bounce(PlantTest):
    def bursts(self, sim, bounce):
        rows = self.log(sim, "home")
        self.assertGreater(len(rows), 5 * (1 + bounce))
        whole = len(rows) // (1 + bounce)
        return [rows[i * (1 + bounce) : (i + 1) * (1 + bounce)] for i in range(whole)]

    def check(self, bounce, bounce_ticks, delay):
        sim = self.session(f"{KNOBS},delay={delay},bounce={bounce},bounce_ticks={bounce_ticks}")
        self.tell(sim, f"run {RUN_CYCLES}")
        bursts = self.bursts(sim, bounce)
        firsts = [burst[0] for burst in bursts]
        self.assertEqual(firsts, self.changes(sim, RUN_CYCLES, delay, "home")[: len(firsts)])
        for burst in bursts:
            cycles = [cycle for cycle, _, _ in burst]
            levels = [level for _, _, level in burst]
            self.assertEqual(cycles, sorted(set(cycles)))
            self.assertLessEqual(cycles[-1] - cycles[0], bounce_ticks)
            self.assertEqual(levels, [levels[0] ^ i & 1 for i in range(1 + bounce)])
            self.assertEqual(levels[-1], levels[0])
        return bursts

    def test_edges_in_their_time(self):
        for bounce, bounce_ticks in (
            (2, 2),
            (2, 100),
            (10, 1_000),
            (64, 64),
            (64, 3_000),
        ):
            for delay in (0, 5_000):
                with self.subTest(bounce=bounce, ticks=bounce_ticks, delay=delay):
                    self.check(bounce, bounce_ticks, delay)

    def test_places_are_spread(self):
        """Not all bursts alike, and over the whole of the time."""
        bursts = self.check(4, 1_000, 0)
        offsets = {tuple(cycle - burst[0][0] for cycle, _, _ in burst) for burst in bursts}
        self.assertEqual(len(offsets), len(bursts))
        places = [place for burst in offsets for place in burst[1:]]
        self.assertLess(min(places), 250)
        self.assertGreater(max(places), 750)

    def test_seed(self):
        def row(knobs, *options):
            sim = self.session(f"{KNOBS},bounce=8,bounce_ticks=500{knobs}", options=options)
            self.tell(sim, f"run {RUN_CYCLES}")
            return self.log(sim)

        plain = row("")
        self.assertEqual(row(""), plain)
        self.assertEqual(row("", "--seed", "1"), plain)
        self.assertEqual(row(",seed=1"), plain)
        other = row("", "--seed", "2")
        self.assertNotEqual(other, plain)
        self.assertEqual(len(other), len(plain))
        self.assertEqual(row(",seed=2"), other)
        self.assertEqual(row(",seed=2", "--seed", "5"), other)

    def test_no_two_switches_bounce_alike(self):
        """Home and the upper limit at one place."""
        sim = self.session(
            f"home={HOME},hyst=1,travel=-100..{HOME},over=1000,bounce=6,bounce_ticks=2000"
        )
        self.tell(sim, "run 8000")
        home, plus = ([row[0] for row in self.log(sim, name)] for name in ("home", "plus"))
        self.assertEqual((len(home), len(plus), home[0]), (7, 7, plus[0]))
        self.assertNotEqual(home, plus)

    def test_no_two_boards_bounce_alike(self):
        knobs = f"{KNOBS},bounce=6,bounce_ticks=2000"
        options = ["--switch-log", str(self.log_path)]
        for board in (0, 1):
            options += ["--plant", f"{board}.0:{knobs}"]
        sim = Session(image("uno", "shuttle"), image("uno", "shuttle"), options=options)
        self.addCleanup(sim.__exit__)
        self.tell(sim, "run 40000")
        self.tell(sim, "flush")
        first, second = ([row for row in read_switches(self.log_path, board) if row[0] > 0]
                         for board in (0, 1))  # fmt: skip
        self.assertGreater(len(first), 7)
        self.assertEqual(first[0], second[0])  # the boards step alike
        self.assertNotEqual(first, second)

    def test_cut_off_by_the_next_change(self):
        """Bounces go on for longer than the switch stays: it ends with each change."""
        sim = self.session(f"{KNOBS},bounce=64,bounce_ticks=60000")
        self.tell(sim, f"run {RUN_CYCLES}")
        rows = self.log(sim, "home")
        levels = [level for _, _, level in rows]
        self.assertEqual(levels, [i & 1 for i in range(len(levels))])  # each row is an edge
        made = self.changes(sim, RUN_CYCLES, 0, "home")
        for cycle, _, level in made:
            upto = [row for row in rows if row[0] <= cycle]
            self.assertEqual(upto[-1][2], level)

    def test_ends_open_after_a_cut(self):
        """Closed for six steps, less than the bounces last; open for long enough."""
        bounce, ticks = 20, 10_000
        sim = self.session(f"home=18,hyst=1,bounce={bounce},bounce_ticks={ticks}")
        self.tell(sim, f"run {RUN_CYCLES}")
        rows = self.log(sim, "home")
        steps = positions(read_edges(self.edges_path))
        closings = [
            cycle for (_, before), (cycle, at) in pairwise(steps) if (before, at) == (17, 18)
        ]
        openings = [
            cycle for (_, before), (cycle, at) in pairwise(steps) if (before, at) == (18, 17)
        ]
        whole = [
            pair for pair in zip(closings, openings, strict=False) if pair[1] + ticks < RUN_CYCLES
        ]
        self.assertGreater(len(whole), 6)
        for closes, opens in whole:
            self.assertLess(opens - closes, ticks / 2)
            after = [row for row in rows if opens < row[0] <= opens + ticks + 1_000]
            self.assertEqual(len(after), bounce)
            self.assertEqual(after[-1][2], OPEN)

    def test_answer(self):
        """`switches` against the log, in the middle of bounces and after them."""
        sim = self.session(f"{KNOBS},delay=100,bounce=6,bounce_ticks=2000")
        now = 0
        seen_open = seen_closed = 0
        for _ in range(150):
            now = int(self.tell(sim, "run 1013").split()[1])
            answer = sim.ask("switches 0 0").split()
            self.assertEqual(answer[0], "switches")
            numbers = [int(word) for word in answer[1:]]
            rows = [row for row in self.log(sim) if row[0] <= now]
            for place, switch in enumerate(("home", "minus", "plus")):
                own = [row for row in rows if row[1] == switch]
                cycle, level = numbers[2 * place : 2 * place + 2]
                if own:
                    self.assertEqual((cycle, level), (own[-1][0], own[-1][2]))
                else:
                    self.assertEqual(cycle, 0)
            made = self.changes(sim, now, 100, "home")
            if made:
                self.assertEqual(numbers[6], made[-1][0])
                seen_closed += made[-1][2] == CLOSED
                seen_open += made[-1][2] == OPEN
        self.assertGreater(seen_closed, 20)
        self.assertGreater(seen_open, 20)


class Stuck(PlantTest):
    def levels(self, sim):
        words = sim.ask("switches 0 0").split()
        return tuple(int(word) for word in words[2:7:2])

    def test_each(self):
        for place, switch in enumerate(("home", "minus", "plus")):
            for state, level in (("open", OPEN), ("closed", CLOSED)):
                with self.subTest(switch=switch, state=state):
                    sim = self.session(f"{KNOBS},stuck={switch}:{state}")
                    self.tell(sim, f"run {RUN_CYCLES}")
                    self.assertEqual(self.levels(sim)[place], level)
                    self.assertEqual(self.log(sim, switch), [])
                    self.assertEqual(
                        sorted(self.log(sim)),
                        sorted(r for r in self.changes(sim, RUN_CYCLES) if r[1] != switch),
                    )

    def test_several_and_free_again(self):
        sim = self.session(f"{KNOBS},stuck=home:closed+plus:closed,stuck=minus:open")
        self.tell(sim, "run 5000")  # below home, above minus
        self.assertEqual(self.levels(sim), (CLOSED, OPEN, CLOSED))
        self.tell(sim, "knobs 0 0 stuck=plus:free")
        self.assertEqual(self.levels(sim), (CLOSED, OPEN, OPEN))
        self.tell(sim, "knobs 0 0 stuck=none,stuck=minus:closed")
        self.assertEqual(self.levels(sim), (OPEN, CLOSED, OPEN))
        self.tell(sim, "knobs 0 0 stuck=none")
        self.assertEqual(self.levels(sim), (OPEN, OPEN, OPEN))

    def test_hysteresis_goes_on_behind_it(self):
        """Freed, home is what it would have been: closed since 12, and open below 8."""
        sim = self.session(f"home={HOME},hyst={HYSTERESIS},start={HOME}")
        self.assertEqual(self.levels(sim)[0], CLOSED)
        self.tell(sim, f"knobs 0 0 stuck=home:open,home={HOME + 3}")
        self.assertEqual(self.levels(sim)[0], OPEN)
        self.tell(sim, "knobs 0 0 stuck=none")
        self.assertEqual(self.levels(sim)[0], CLOSED)


class Knobs(PlantTest):
    def test_delay_of_each_run(self):
        """One simulator, many delays, each in force at once."""
        sim = self.session(KNOBS)
        now = 0
        for delay in (3_000, 0, 12_345, 1, 500):
            self.tell(sim, f"knobs 0 0 delay={delay}")
            start, now = now, int(self.tell(sim, "run 100000").split()[1])
            made = [row for row in self.log(sim, "home") if row[0] > start + 30_000]
            due = self.changes(sim, now, delay, "home")
            self.assertEqual(made, [row for row in due if row[0] > start + 30_000])
            self.assertGreater(len(made), 2)

    def test_others_stay(self):
        sim = self.session(f"{KNOBS},delay=70,bounce=2,bounce_ticks=9")
        self.tell(sim, "knobs 0 0 play=0")
        self.tell(sim, f"run {RUN_CYCLES}")
        firsts = self.log(sim, "home")[::3]
        self.assertEqual(firsts, self.changes(sim, firsts[-1][0], 70, "home"))

    def test_start_puts_the_load(self):
        sim = self.session(f"play=4,home={HOME}")
        self.tell(sim, "run 14000")
        self.assertNotEqual(sim.ask("plant 0 0"), "plant 900 900")
        self.tell(sim, "knobs 0 0 start=900")
        self.assertEqual(sim.ask("plant 0 0"), "plant 900 900")
        self.assertEqual(sim.ask("switches 0 0").split()[2], str(CLOSED))
        before = sim.ask("plant 0 0")
        self.tell(sim, "knobs 0 0 delay=5")
        self.assertEqual(sim.ask("plant 0 0"), before)

    def test_play_taken_up_either_way(self):
        for side, motor in (("plus", 0), ("minus", -3)):
            sim = self.session(f"play=3,taken_up={side}")
            self.assertEqual(sim.ask("plant 0 0"), f"plant {motor} 0")
            self.tell(sim, f"run {RUN_CYCLES}")
            self.tell(sim, "flush")
            load = 0
            for _, made in positions(read_edges(self.edges_path)):
                load = min(max(load, motor + made), motor + made + 3)
            self.assertEqual(sim.ask("plant 0 0"), f"plant {motor + made} {load}")

    def test_start_within_the_hysteresis_is_open(self):
        sim = self.session(f"home={HOME},hyst={HYSTERESIS},start={HOME}")
        self.assertEqual(sim.ask("switches 0 0").split()[2], str(CLOSED))
        self.tell(sim, f"knobs 0 0 start={HOME - 1}")
        self.assertEqual(sim.ask("switches 0 0").split()[2], str(OPEN))

    def test_nothing_stays_under_way(self):
        """A new delay leaves no edge of the old one behind."""
        sim = self.session(f"{KNOBS},delay=50000")
        now = int(self.tell(sim, "run 9900").split()[1])
        self.assertEqual(self.log(sim), [])
        self.tell(sim, f"knobs 0 0 delay={SECOND_TICKS}")
        at_once = self.log(sim)
        self.assertTrue(all(0 <= row[0] - now <= 4 for row in at_once), at_once)  # an instruction
        self.assertEqual({row[1] for row in at_once}, {"home", "minus", "plus"})
        self.tell(sim, "run 500000")
        self.assertEqual(self.log(sim), at_once)

    def test_of_an_axis_without_plant(self):
        with Session(image("uno", "shuttle")) as sim:
            self.assertEqual(sim.ask("switches 0 0"), "switches 0 0 0 0 0 0 0")
            self.tell(sim, "knobs 0 0 home=3")
            self.tell(sim, "run 12000")
            self.assertEqual(sim.ask("switches 0 0").split()[2], str(CLOSED))

    def test_active_high(self):
        sim = self.session(f"{KNOBS},active=high")
        self.tell(sim, "run 14000")
        self.assertEqual(sim.ask("switches 0 0").split()[2], "1")
        self.tell(sim, "knobs 0 0 active=low")
        self.assertEqual(sim.ask("switches 0 0").split()[2], "0")

    def test_errors_change_nothing(self):
        sim = self.session(f"{KNOBS},delay=70")
        for knobs, text in (
            ("ploy=1", "there is no parameter 'ploy'"),
            ("delay", "cannot make sense of 'delay'"),
            ("delay=16000001", "delay='16000001': expected ticks, 0 to 16000000"),
            ("delay=-1", "delay='-1': expected ticks"),
            ("delay=5,bounce=3,bounce_ticks=9", "bounce='3': expected an even number of edges"),
            ("bounce=66,bounce_ticks=99", "bounce='66': expected an even number of edges"),
            ("bounce=4", "bounce=4: bounce_ticks must be at least as many, not 0"),
            ("stuck=home", "stuck='home': expected none, or home, minus, plus"),
            ("stuck=home:ajar", "stuck='home:ajar': expected none"),
            ("stuck=hame:open", "stuck='hame:open': expected none"),
            ("travel=5..5", "travel='5..5': expected FIRST..LAST"),
            ("home=99999999999999999999", "home='99999999999999999999': expected a position"),
        ):
            with self.subTest(knobs=knobs):
                answer = sim.ask(f"knobs 0 0 {knobs}")
                self.assertTrue(answer.startswith(f"error knobs: {text}"), answer)
        self.assertTrue(sim.ask("knobs 0 1 home=1").startswith("error "))
        self.assertTrue(sim.ask("knobs 0 0").startswith("error "))
        self.tell(sim, f"run {RUN_CYCLES}")
        self.assertEqual(self.log(sim, "home"), self.changes(sim, RUN_CYCLES, 70, "home"))

    def test_a_switch_that_is_not_there(self):
        for knobs, text in (
            ("home=1,stuck=plus:open", "travel"),
            ("stuck=home:open", "home=N"),
        ):
            with Session(image("uno", "shuttle")) as sim:
                self.assertIn(text, sim.ask(f"knobs 0 0 {knobs}"))


class Captured(PlantTest):
    """From step to switch to contact to comparator to ICR1: images/comparator.c."""

    def check(self, board, delay):
        sim = self.session(f"home=3,delay={delay}", board, "comparator")
        self.tell(sim, f"poke 0 {GPIOR2} 09")  # the pin falls; pull-up
        self.tell(sim, f"poke 0 {RESULT_ADDRESS + 2 * 62} 0000")
        self.tell(sim, f"run {50_000 + delay}")
        rows = self.log(sim)
        edges = rising(read_edges(self.edges_path))
        self.assertEqual(rows, [(edges[2] + delay, "home", CLOSED)])
        bottom = edges[0] - 32
        self.assertEqual(sim.results(2), [1, (edges[2] + delay + 3 - bottom) % 10_000])

    def test_every_place_in_the_period(self):
        for board in ("uno", "mega"):
            for delay in (*range(9_900, 10_040), 0, 1, 5_000, 123_456):
                with self.subTest(board=board, delay=delay):
                    self.check(board, delay)


if __name__ == "__main__":
    unittest.main()
