# SPDX-License-Identifier: MIT
"""Random operations on a motor record above the ideal stepper: what holds after each of them."""

import time

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import motor_invariants as holds
from effort import LONG, cases, only_long
from pixstep.motor_record import FIELDS, MotorRecord
from pixstep_trials.motor_traces.bench import TraceBench
from pixstep_trials.motor_traces.stepper import Stepper

WANTED = 1_000_000  # operations of a long check
LENGTH = 50  # of one example, at most

positions = st.sampled_from((-4.0, -1.5, -0.3, -0.01, 0.0, 0.004, 0.02, 0.5, 2.25, 5.0, 12.0))
velocities = st.sampled_from((0.0, 0.5, 5.0, 8.0, 20.0))
steps = st.sampled_from((0.01, 0.0025, -0.01, -0.005))
flags = st.sampled_from((0, 1))

started = st.fixed_dictionaries(
    {"MRES": steps, "VELO": st.sampled_from((5, 20)), "RTRY": st.sampled_from((0, 2))},
    optional={
        "DIR": flags,
        "OFF": positions,
        "BDST": st.sampled_from((0.5, -0.5, 0.02, -0.1)),
        "BVEL": st.sampled_from((5, 20)),
        "FOFF": flags,
        "FRAC": st.sampled_from((0.7, 1)),
        "RMOD": st.sampled_from((0, 1, 2)),
        "NTM": flags,
        "RDBD": st.sampled_from((0.02, 0.1)),
        "SPDB": st.sampled_from((0.0, 0.03)),
        "DLY": st.sampled_from((0.0, 0.05)),
        "DVAL": positions,
        "RSTM": st.sampled_from((0, 1, 2, 3)),
        "VBAS": st.sampled_from((0.0, 0.5)),
        "VMAX": st.sampled_from((0.0, 20.0)),
        "JVEL": st.sampled_from((2.0, 5.0)),
        "HVEL": st.just(5.0),
        "HLSV": st.sampled_from((0, 1)),
    },
)
targets = st.tuples(st.sampled_from(("VAL", "DVAL", "RLV")), positions)
buttons = st.tuples(
    st.sampled_from(("TWF", "TWR", "JOGF", "JOGR", "HOMF", "HOMR", "STOP", "SYNC", "PROC")), flags
)
modes = st.one_of(
    st.tuples(st.just("SPMG"), st.sampled_from((0, 1, 2, 3, 3, 3))),
    st.tuples(st.sampled_from(("SET", "FOFF", "IGSET", "DIR", "UEIP", "NTM")), flags),
)
sizes = st.one_of(
    st.tuples(st.sampled_from(("DHLM", "DLLM", "HLM", "LLM", "OFF", "TWV", "BDST")), positions),
    st.tuples(st.sampled_from(("VELO", "VBAS", "VMAX", "S", "SBAS", "SMAX", "BVEL")), velocities),
    st.tuples(st.sampled_from(("MRES", "ERES")), steps),
    st.tuples(st.just("SREV"), st.sampled_from((0, 2, 400))),
    st.tuples(st.just("RTRY"), st.sampled_from((0, 2))),
    st.tuples(st.sampled_from(("ACCL", "ACCS", "BACC", "FRAC", "NTMF", "RDBD")), velocities),
)
puts = st.one_of(targets, targets, buttons, modes, sizes).map(lambda put: ("put", *put))
times = st.one_of(
    st.tuples(st.just("adv"), st.integers(1, 12)), st.just(("settle",)), st.just(("delay",))
)
world = st.one_of(
    st.tuples(st.just("sim"), st.just("slip"), st.sampled_from((0.0, 3.0, -20.0))),
    st.tuples(st.just("sim"), st.just("home"), st.sampled_from((0.0, 150.0, -40.0))),
    st.tuples(st.just("sim"), st.sampled_from(("comm", "problem")), flags),
    st.tuples(st.just("sim"), st.just("hi"), st.sampled_from((700.0, 1e5))),
    st.tuples(st.just("sim"), st.just("lo"), st.sampled_from((-900.0, -1e5))),
)
operations = st.one_of(puts, puts, puts, times, times, world)


class Tally:
    """How many operations were tried, and in what time."""

    done = 0
    seconds = 0.0


class Trial:
    """One record, its motor, and a client that listens to all posts."""

    def __init__(self, fields, ratio):
        self.bench = TraceBench(MotorRecord(fields), Stepper(ratio=ratio))
        self.known = {}
        self._take, self.bench.take = self.bench.take, self.take
        self.bench.take(self.bench.record.initialise(self.bench.stepper.status()))

    def take(self, outcome):
        self.known.update((post.field, post.value) for post in outcome.posts)
        assert outcome.complete == bool(self.bench.record["DMOV"])
        return self._take(outcome)

    def operate(self, operation):
        name, *arguments = operation
        getattr(self, name)(*arguments)
        r = self.bench.record
        self.forget_refused_jog()
        holds.coordinates(self.bench)
        holds.speeds(r)
        holds.told(r, self.known)
        self.bench.forget()

    def forget_refused_jog(self):
        """Do as whoever serves a record."""
        forgotten = self.bench.record.forget_refused_jog()
        if forgotten:
            self.bench.take(forgotten)

    def put(self, name, value):
        last = self.bench.record["LDVL"]
        before = self.bench.record.values()
        if self.bench.put(name, value) is None:
            assert before == self.bench.record.values()
        elif self.bench.record["FRAC"] <= 1:
            holds.target_within_limits(self.bench.record, last, self.bench.commands)

    def adv(self, count):
        for _ in range(count):
            self.bench.end_zero_delay()
            if self.bench.tick() is not None:
                holds.at_rest_when_done(self.bench)

    def settle(self):
        ended = self.bench.settle()[1]
        if not ended and self.bench.stepper.at_rest:  # perhaps since the last tick only
            ended = self.bench.settle()[1]
        self.forget_refused_jog()  # of a jog that a limit has ended, and that begins again
        holds.ends(self.bench, ended)

    def delay(self):
        self.bench.end_delay()

    def sim(self, knob, value):
        self.bench.stepper.turn(knob, value)


def tried(count):
    """Give a test its number of examples; a failure is made small and told as operations."""
    return settings(
        max_examples=count,
        deadline=None,
        database=None,
        derandomize=not LONG,
        suppress_health_check=list(HealthCheck),
    )


def test_a_put_that_waits_behind_a_refused_jog_ends():
    """A limit refuses both: nobody waits for ever."""
    trial = Trial({"MRES": 0.01, "VELO": 5, "RTRY": 0}, None)
    puts = [("VAL", -4.0), ("JOGF", 1), ("DHLM", -4.0), ("SPMG", 0)]
    later = [("VAL", -4.0), ("SPMG", 3)]
    for one in (*puts, None, *later, None):
        trial.operate(("put", *one) if one else ("settle",))
    assert trial.bench.record["DMOV"] == 1 and trial.bench.record["LVIO"] == 1


@tried(cases(60, 26_000))
@given(
    fields=started,
    ratio=st.sampled_from((None, None, 1.0, -2.0)),
    chosen=st.lists(operations, min_size=LENGTH - 20, max_size=LENGTH),
)
def test_what_holds_after_every_operation(fields, ratio, chosen):
    begun = time.perf_counter()
    trial = Trial(fields, ratio)
    for operation in chosen:
        trial.operate(operation)
    holds.types(trial.bench.record)
    Tally.done += len(chosen)
    Tally.seconds += time.perf_counter() - begun


WILD = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(-(2**40), 2**40),
    st.sampled_from((0, 1, 2, -1, 0.5, 1e-12, 1e9, -1e99)),
    st.text(max_size=6),
)


@tried(cases(150, 4000))
@given(
    fields=started,
    chosen=st.lists(st.tuples(st.sampled_from(sorted(FIELDS)), WILD), min_size=10, max_size=60),
)
def test_no_value_of_any_field_breaks_the_record(fields, chosen):
    trial = Trial(fields, None)
    for name, value in chosen:
        trial.put(name, value)
        trial.bench.ticks(2)
        if "MDEL" not in (one for one, _ in chosen):
            holds.told(trial.bench.record, trial.known)
        holds.types(trial.bench.record)
        trial.bench.forget()


@tried(cases(40, 3000))
@given(
    step=steps,
    distance=st.sampled_from((0.0, 0.5, -0.5, 0.07, -0.02)),
    direction=flags,
    offset=positions,
    ratio=st.sampled_from((None, 1.0, 2.0, -1.0)),
    retries=st.sampled_from((0, 3)),
    targets=st.lists(st.floats(-3, 3), min_size=1, max_size=8),
)
def test_a_move_ends_at_its_target_and_from_the_side_of_the_approach(
    step, distance, direction, offset, ratio, retries, targets
):
    fields = {"MRES": step, "DIR": direction, "OFF": offset, "BDST": distance, "RTRY": retries}
    fields |= {"VELO": 20, "BVEL": 5, "ERES": step / (ratio or 1)}
    bench = Trial(fields, ratio).bench
    if ratio:
        bench.put("UEIP", 1)
    last = None
    for target in targets:
        before = bench.stepper.position
        bench.put("VAL", offset + target)
        assert bench.settle()[1]
        assert abs(bench.record["RBV"] - offset - target) <= abs(step) * 0.501
        # The record reckons from target to target: to the last one once more it makes no approach,
        # also where the drive rounds half a step the other way this time.
        moved = bench.stepper.position != before and target != last
        if moved and abs(distance) >= abs(step):
            assert bench.stepper.forwards == (distance * step > 0)
        last = target


@only_long
def test_there_were_enough_operations():
    print(f"{Tally.done} operations, {Tally.done / Tally.seconds:.0f} per second")
    assert Tally.done >= WANTED
