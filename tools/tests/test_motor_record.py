# SPDX-License-Identifier: MIT
"""The motor record where no recording reaches, or where a rule is worth a test of its own."""

from pathlib import Path

import pytest

from motor_bench import commands, motor, posted, settled
from pixstep.motor_record import Mip, MotorRecord, Msta, PutRefusedError, Status
from pixstep_trials.motor_traces.stepper import Stepper

ROOT = Path(__file__).resolve().parents[2]


def fields(bench, *names):
    return tuple(bench.record[name] for name in names)


# --- moves -------------------------------------------------------------------------------------


def test_a_move_is_asked_for_and_ends():
    bench = motor()
    outcome = bench.put("VAL", 2.0)
    assert commands(bench) == [
        "SET_VELOCITY 100",
        "SET_VEL_BASE 0",
        "SET_ACCEL 500",
        "MOVE_ABS 200",
        "GO",
    ]
    assert not outcome.complete
    assert fields(settled(bench), "RBV", "RRBV", "DMOV", "MIP") == (2.0, 200, 1, Mip.DONE)


def test_dmov_falls_first_and_rises_last():
    """Who waits for DMOV has the position; a value is posted before what follows from it."""
    bench = motor(BDST=0.5, BVEL=0.5)
    began = bench.put("VAL", 2.0)
    names = [name for name, _ in posted(began)]
    assert names[0] == "DMOV"
    assert names.index("VAL") < names.index("MIP")
    assert posted(began, "DMOV", "VAL", "MIP") == [("DMOV", 0), ("VAL", 2.0), ("MIP", Mip.MOVE)]
    seen = []
    while not bench.record["DMOV"]:
        outcome = bench.tick()
        if outcome is not None:
            seen += posted(outcome, "DMOV", "MIP", "MOVN", "RBV")
    states = [one for one in seen if one[0] != "RBV"]
    assert states == [
        ("MOVN", 1),
        ("MIP", Mip.MOVE_BL),
        ("MOVN", 0),
        ("MOVN", 1),
        ("MIP", Mip.DONE),
        ("MOVN", 0),
        ("DMOV", 1),
    ]
    assert seen.index(("RBV", 2.0)) < seen.index(("DMOV", 1))
    assert outcome.complete


@pytest.mark.parametrize(("name", "value"), [("VAL", 0.0), ("VAL", 99.0), ("DVAL", 0.001)])
def test_a_write_that_moves_nothing_pulses_dmov(name, value):
    bench = motor()
    outcome = bench.put(name, value)
    assert posted(outcome, "DMOV") == [("DMOV", 0), ("DMOV", 1)]
    assert outcome.complete and commands(bench) in ([], ["GET_INFO"])


@pytest.mark.parametrize(
    ("name", "value"), [("HLM", 40.0), ("SYNC", 1), ("STOP", 1), ("EGU", "mm")]
)
def test_a_write_of_no_target_pulses_nothing(name, value):
    assert posted(motor().put(name, value), "DMOV") == []


def test_a_refused_target_is_taken_back_and_told():
    bench = motor()
    assert ("VAL", 0.0) in posted(bench.put("VAL", 99.0))
    assert fields(bench, "VAL", "DVAL", "RVAL", "LVIO") == (0.0, 0.0, 0, 1)
    bench.put("VAL", 1.0)
    assert bench.record["LVIO"] == 0


def test_a_target_beyond_the_motors_counter_is_refused():
    bench = motor(DHLM=0, DLLM=0)
    bench.put("VAL", 1e90)
    assert fields(bench, "VAL", "DMOV") == (0.0, 1)
    assert not any(one.verb == "GO" for one in bench.commands)


@pytest.mark.parametrize(("button", "way"), [("TWF", 0.5), ("TWR", -0.5)])
@pytest.mark.parametrize("direction", ["Pos", "Neg"])
def test_a_tweak_moves_by_its_distance_and_clears_itself(button, way, direction):
    bench = motor(DIR=direction, OFF=3)
    bench.put(button, 1)
    assert fields(settled(bench), "RBV", button) == (3 + way, 0)


def test_a_distance_is_taken_once():
    bench = motor()
    for _ in range(2):
        bench.put("RLV", 0.25)
        settled(bench)
    assert fields(bench, "RBV", "RLV") == (0.5, 0.0)


def test_a_raw_target_moves_by_steps():
    bench = motor(DIR="Neg")
    bench.put("RVAL", 150.9)  # a whole number is kept of it
    assert fields(settled(bench), "RVAL", "DVAL", "VAL") == (150, 1.5, -1.5)


# --- backlash ----------------------------------------------------------------------------------


@pytest.mark.parametrize("step", [0.01, -0.01])
@pytest.mark.parametrize("distance", [0.5, -0.5])
@pytest.mark.parametrize("encoder", [False, True])
def test_the_four_signs_of_step_and_distance(step, distance, encoder):
    """A far move against the approach goes beyond; near ones and approaches do not."""
    bench = motor(
        Stepper(ratio=1.0 if encoder else None),
        MRES=step,
        ERES=step,
        BDST=distance,
        BVEL=0.5,
        RTRY=3,
        DHLM=0,
        DLLM=0,
    )
    if encoder:
        bench.put("UEIP", "Yes")
        settled(bench)
    bench.forget()
    away = -1.0 if distance > 0 else 1.0
    bench.put("DVAL", away)
    verb = "MOVE_REL" if encoder else "MOVE_ABS"
    beyond = (away - distance) / step
    assert f"{verb} {beyond:.10g}" in commands(bench)
    settled(bench)
    last = [one for one in bench.commands if one.verb == verb][-1]
    assert last.argument == pytest.approx(distance / step if encoder else away / step)
    assert bench.record["DRBV"] == pytest.approx(away)


def test_a_near_move_in_the_direction_of_the_approach_is_one_leg():
    bench = motor(BDST=0.5, BVEL=0.5)
    outcome = bench.put("VAL", 0.4)
    assert outcome.second_leg == ()
    assert commands(bench)[0] == "SET_VELOCITY 50"


def test_the_second_leg_is_told_with_the_first():
    bench = motor(BDST=0.5, BVEL=0.5)
    told = bench.put("VAL", 2.0).second_leg
    bench.forget()
    settled(bench)
    assert tuple(bench.commands) == told
    assert [str(one) for one in told] == ["SET_VELOCITY 50", "SET_ACCEL 100", "MOVE_ABS 200", "GO"]


def test_a_limit_counts_for_the_point_beyond_the_target():
    bench = motor(BDST=0.5, BVEL=0.5, DLLM=-1)
    bench.put("VAL", -0.8)  # the way goes to -1.3 first
    assert fields(bench, "LVIO", "VAL") == (1, 0.0)


# --- coordinates -------------------------------------------------------------------------------


@pytest.mark.parametrize("direction", [1, -1])
def test_set_with_a_variable_offset_asks_nothing(direction):
    bench = motor(DIR="Pos" if direction > 0 else "Neg")
    bench.put("VAL", 2.0)
    settled(bench).put("SET", "Set")
    bench.forget()
    bench.put("VAL", 7.0)
    assert commands(bench) == []
    assert fields(bench, "RBV", "OFF", "DVAL") == (7.0, 5.0, 2.0 * direction)
    assert fields(bench, "HLM", "DMOV") == (55.0, 1)


def test_set_with_a_frozen_offset_loads_the_position():
    bench = motor(FOFF="Frozen", OFF=1)
    bench.put("SSET", 1)
    bench.forget()
    outcome = bench.put("VAL", 3.0)
    assert commands(bench) == ["LOAD_POS 200", "GET_INFO"]
    assert posted(outcome, "DMOV") == [("DMOV", 0)]
    assert fields(settled(bench), "RBV", "DRBV", "OFF", "MIP") == (3.0, 2.0, 1.0, Mip.DONE)
    bench.put("SUSE", 1)
    assert bench.record["SET"] == 0


def test_set_of_the_dial_position_keeps_the_users():
    bench = motor()
    bench.put("SET", 1)
    bench.put("DVAL", 4.0)
    assert fields(settled(bench), "DRBV", "RBV", "OFF") == (4.0, 0.0, -4.0)


def test_igset_lets_set_have_no_effect():
    bench = motor(SET=1, IGSET=1)
    bench.put("VAL", 1.0)
    assert fields(settled(bench), "RBV", "RRBV") == (1.0, 100)


def test_foff_by_its_buttons():
    bench = motor()
    bench.put("FOF", 1)
    assert bench.record["FOFF"] == 1
    bench.put("VOF", 1)
    assert bench.record["FOFF"] == 0


def test_sync_makes_targets_the_position():
    bench = motor()
    bench.stepper.position = 70.0
    bench.stepper.status_wanted = True
    bench.tick()
    bench.put("SYNC", 1)
    assert fields(bench, "VAL", "DVAL", "RVAL", "SYNC") == (pytest.approx(0.7), 70 * 0.01, 70, 0)


def test_sync_reads_the_link():
    bench = motor(links={"RDBL": 0.0}, URIP=1, RRES=1)
    bench.record.set_link("RDBL", 2.5)
    bench.put("SYNC", 1)
    assert fields(bench, "VAL", "RBV", "RRBV") == (2.5, 2.5, 250)


def test_the_choice_of_an_encoder_sets_no_position():
    bench = motor(Stepper(ratio=2.0), ERES=0.005)
    bench.put("VAL", 1.0)
    settled(bench).put("UEIP", "Yes")
    settled(bench)
    assert not any(one.verb == "LOAD_POS" for one in bench.commands)
    assert fields(bench, "RBV", "RRBV") == (1.0, 200)


# --- resolution and speeds ---------------------------------------------------------------------


def test_a_step_and_a_revolution_agree():
    bench = motor(SREV=400)
    bench.put("UREV", 2.0)
    assert bench.record["MRES"] == 0.005
    bench.put("MRES", 0.01)
    assert bench.record["UREV"] == 4.0


@pytest.mark.parametrize(("name", "value"), [("MRES", 0), ("UREV", 0.0), ("MRES", "1e-13")])
def test_no_step_is_refused(name, value):
    with pytest.raises(PutRefusedError, match=f"{name}: .* is refused: at least 1e-12 is wanted"):
        motor().record.put(name, value)


def test_no_speed_divides_by_nothing():
    bench = motor(ACCU="Use ACCS")
    for name, value in (("VELO", 0), ("ACCU", 0), ("VELO", 1), ("ACCU", 1), ("ACCL", -1)):
        bench.put(name, value)
    assert bench.record["ACCL"] == 0.1


def test_what_is_given_in_revolutions_counts_at_the_start():
    assert fields(motor(SREV=100, S=2, VELO=9), "VELO", "S") == (2.0, 2.0)


# --- the start ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mode", "dial", "raw", "loads"),
    [
        ("Never", 2.0, 0, False),
        ("Always", 2.0, 700, True),
        ("NearZero", 2.0, 0, True),
        ("NearZero", 2.0, 700, False),
        ("NearZero", 0.005, 0, False),
        ("Conditional", 2.0, 0, True),
        ("Conditional", 2.0, 700, False),
    ],
)
def test_a_restart_sets_the_position_where_rstm_says_so(mode, dial, raw, loads):
    record = MotorRecord({"MRES": 0.01, "RSTM": mode, "DVAL": dial, "RTRY": 0})
    asked = record.initialise(Status(raw)).commands
    assert ("LOAD_POS 200" in map(str, asked)) is loads
    assert record["DRBV"] == (dial if loads else raw * 0.01)
    assert record["VAL"] == record["RBV"]


def test_conditional_restores_where_moves_are_relative():
    record = MotorRecord({"MRES": 0.01, "RSTM": 3, "DVAL": 2, "UEIP": 1, "ERES": 0.01})
    asked = record.initialise(Status(700, 700, Msta.DONE | Msta.EA_PRESENT)).commands
    assert "LOAD_POS 200" in map(str, asked)


def test_user_limits_are_there_before_the_motor_has_answered():
    record = MotorRecord({"DHLM": 3, "DLLM": -1, "OFF": 1})
    assert (record["LLM"], record["HLM"]) == (0, 4)


def test_a_position_outside_is_told_at_the_start():
    record = MotorRecord({"MRES": 0.01, "DHLM": 1, "DLLM": -1})
    record.initialise(Status(700))
    assert record["LVIO"] == 1


# --- stop, pause, jog, home --------------------------------------------------------------------


def test_stop_makes_the_target_the_position():
    bench = motor(NTM=0)
    bench.put("VAL", 10)
    bench.ticks(20)
    bench.put("STOP", 1)
    assert commands(bench)[-1] == "STOP_AXIS"
    settled(bench)
    assert fields(bench, "VAL", "STOP", "MIP") == (bench.record["RBV"], 0, Mip.DONE)
    assert 0 < bench.record["VAL"] < 1


@pytest.mark.parametrize("later", [(), (-3.0,)])
def test_stop_ends_a_move_that_a_target_behind_has_begun(later):
    """The record makes such a move as a retry; a newer target may wait for its end."""
    bench = motor(RTRY=10)
    bench.put("VAL", 2.0)
    bench.ticks(20)
    bench.put("VAL", -2.0)  # behind: the record stops the motor, then goes there
    bench.ticks(40)
    for target in later:
        bench.put("VAL", target)
    assert bench.record["MIP"] & Mip.RETRY and bench.record["MOVN"]
    bench.put("STOP", 1)
    assert bench.record["DMOV"] == 0  # it still moves
    settled(bench)
    rests = bench.record["RBV"]
    assert -2.0 < rests < 2.0
    assert (bench.record["VAL"], bench.record["MIP"]) == (rests, Mip.DONE)


def test_a_target_that_is_refused_during_a_retry_does_not_end_it():
    bench = motor(RTRY=10, DHLM=5, DLLM=-5)
    bench.put("VAL", 2.0)
    bench.ticks(20)
    bench.put("VAL", -2.0)
    bench.ticks(40)
    assert bench.record["MIP"] & Mip.RETRY and bench.record["MOVN"]
    bench.put("VAL", -9.0)
    assert fields(bench, "VAL", "LVIO", "DMOV") == (-2.0, 1, 0)
    assert settled(bench).record["RBV"] == -2.0
    assert bench.stepper.at_rest


def test_stop_counts_while_a_target_behind_stops_the_motor():
    bench = motor(RTRY=10)
    bench.put("VAL", 2.0)
    bench.ticks(20)
    bench.put("VAL", -2.0)
    while not bench.record["MIP"] & Mip.STOP:
        bench.tick()
    bench.put("STOP", 1)
    settled(bench)
    assert bench.record["RBV"] > 0
    assert bench.record["VAL"] == bench.record["RBV"]


def test_pause_keeps_the_target_and_go_resumes():
    bench = motor(RTRY=1)
    bench.put("VAL", 1.0)
    bench.ticks(10)
    bench.put("SPMG", "Pause")
    bench.ticks(10)
    assert bench.stepper.at_rest and bench.record["VAL"] == 1.0
    bench.put("SPMG", "Go")
    assert settled(bench).record["RBV"] == 1.0


def test_move_goes_once():
    bench = motor(SPMG="Go")
    bench.put("SPMG", "Move")
    bench.put("VAL", 1.0)
    settled(bench)
    assert bench.record["SPMG"] == 1  # Pause
    bench.put("VAL", 2.0)
    assert not bench.settle()[1]  # a write with completion waits
    bench.put("SPMG", "Go")
    assert settled(bench).record["RBV"] == 2.0


def test_stop_by_spmg_stays():
    bench = motor()
    bench.put("VAL", 5)
    bench.ticks(10)
    bench.put("SPMG", "Stop")
    settled(bench)
    assert bench.record["VAL"] == bench.record["RBV"] < 1


@pytest.mark.parametrize("button", ["JOGF", "JOGR"])
@pytest.mark.parametrize("direction", ["Pos", "Neg"])
@pytest.mark.parametrize("step", [0.01, -0.01])
def test_a_jog_goes_the_users_way_until_released(button, direction, step):
    bench = motor(DIR=direction, MRES=step)
    bench.put(button, 1)
    bench.ticks(50)
    bench.put(button, 0)
    settled(bench)
    assert bench.record["RBV"] * (1 if button == "JOGF" else -1) == pytest.approx(1.0)
    assert bench.record["VAL"] == bench.record["RBV"]


def test_a_jog_changes_its_speed():
    bench = motor()
    bench.put("JOGF", 1)
    bench.forget()
    bench.put("JVEL", 2)
    assert commands(bench) == ["SET_ACCEL 500", "JOG_VELOCITY 200"]


def test_a_jog_keeps_one_second_from_a_limit():
    bench = motor(DHLM=3, DLLM=-3)
    bench.put("JOGF", 1)
    settled(bench)
    assert 1.98 <= bench.record["RBV"] <= 2.04
    assert fields(bench, "LVIO", "JOGF") == (1, 0)


def test_stop_forgets_a_jog_that_was_refused():
    """The record keeps the request of a refused jog: the next write would begin it."""
    bench = motor(DHLM=0.5, DLLM=-0.5)
    bench.put("JOGF", 1)
    assert fields(bench, "LVIO", "JOGF", "MIP") == (1, 0, Mip.JOG_REQ)
    bench.put("STOP", 1)
    settled(bench).put("VAL", 0.2)
    assert settled(bench).record["RBV"] == 0.2


def test_a_jog_against_backlash_ends_with_two_legs():
    bench = motor(BDST=0.2, BVEL=0.5)
    bench.put("JOGF", 1)
    bench.ticks(50)
    bench.forget()
    bench.put("JOGF", 0)
    settled(bench)
    assert [str(one) for one in bench.commands if one.verb in ("MOVE_ABS", "STOP_AXIS")] == [
        "STOP_AXIS",
        "MOVE_ABS 80",
        "MOVE_ABS 100",
    ]


def test_homing_begins_goes_and_clears_its_button():
    bench = motor(Stepper(home=50.0))
    bench.put("HOMF", 1)
    assert commands(bench)[-2:] == ["HOME_FOR", "GO"]
    with pytest.raises(PutRefusedError, match="looks for the home switch already"):
        bench.record.put("HOMR", 1)
    assert fields(settled(bench), "RRBV", "HOMF", "ATHM", "VAL") == (50, 0, 1, 0.5)


def test_homing_during_a_move_stops_first():
    bench = motor(Stepper(home=150.0))
    bench.put("VAL", 1.0)
    bench.ticks(10)
    bench.forget()
    bench.put("HOMF", 1)
    assert commands(bench) == ["STOP_AXIS"]
    assert fields(settled(bench), "RRBV", "HOMF") == (150, 0)


# --- switches, faults, alarms, others ----------------------------------------------------------


def test_a_switch_ends_a_move_only_in_its_direction():
    bench = motor(Stepper(hi=100.0))
    bench.put("VAL", 5)
    settled(bench)
    assert fields(bench, "RBV", "HLS", "LLS", "MIP") == (1.0, 1, 0, Mip.DONE)
    bench.put("VAL", 0.5)
    assert fields(settled(bench), "RBV", "HLS") == (0.5, 0)


@pytest.mark.parametrize(
    ("flags", "alarm"),
    [
        (Msta.DONE, (0, 0)),
        (Msta.DONE | Msta.SLIP_STALL, (7, 2)),
        (Msta.DONE | Msta.PROBLEM, (7, 2)),
        (Msta.DONE | Msta.COMM_ERR, (9, 3)),
        (Msta.DONE | Msta.COMM_ERR | Msta.PROBLEM, (9, 3)),
        (Msta.DONE | Msta.PLUS_LS, (4, 1)),
        (Msta.DONE | Msta.MINUS_LS | Msta.COMM_ERR, (6, 1)),
    ],
)
def test_alarms(flags, alarm):
    bench = motor(HLSV="MINOR")
    bench.record.update(Status(0, 0, flags))
    assert fields(bench, "STAT", "SEVR") == alarm


def test_motion_by_others_is_followed():
    bench = motor()
    bench.record.update(Status(5, 0, Msta.MOVING | Msta.DIRECTION))
    assert fields(bench, "DMOV", "MOVN", "MIP") == (0, 1, Mip.EXTERNAL)
    outcome = bench.record.update(Status(90, 0, Msta.DONE | Msta.DIRECTION))
    assert fields(bench, "DMOV", "MOVN", "VAL", "MIP") == (1, 0, 0.9, Mip.DONE)
    assert outcome.complete


def test_closed_loop_position_is_held_where_the_driver_can():
    bench = motor()
    bench.put("CNEN", "Enable")
    assert not any("TORQUE" in one for one in commands(bench))
    bench.record.update(Status(0, 0, Msta.DONE | Msta.GAIN_SUPPORT | Msta.EA_POSITION))
    assert bench.record["CNEN"] == 1
    asked = bench.record.put("CNEN", 0).commands
    assert str(asked[0]) == "DISABL_TORQUE 0"
    assert [str(one) for one in bench.record.put("PCOF", 1.5).commands] == ["SET_PGAIN 1"]


def test_a_status_is_asked_for_once():
    bench = motor()
    bench.put("STUP", "ON")
    assert commands(bench) == ["GET_INFO"]
    with pytest.raises(PutRefusedError, match="a status is awaited already"):
        bench.record.put("STUP", 1)
    bench.ticks(1)
    assert bench.record["STUP"] == 0


# --- encoder, links, retries, delays -----------------------------------------------------------


def test_there_is_no_encoder_where_the_motor_has_none():
    bench = motor()
    bench.put("UEIP", "Yes")
    assert bench.record["UEIP"] == 0


def test_encoder_and_link_exclude_each_other():
    bench = motor(Stepper(ratio=1.0), links={"RDBL": 0.0}, RRES=1)
    bench.put("URIP", 1)
    settled(bench)
    bench.put("UEIP", 1)
    assert fields(bench, "UEIP", "URIP") == (1, 0)
    settled(bench)
    bench.put("URIP", 1)
    assert fields(bench, "UEIP", "URIP") == (0, 1)


def test_a_dead_readback_link_stops_a_move_and_refuses_the_next():
    bench = motor(links={"RDBL": 0.0}, URIP=1, RRES=1)
    bench.put("VAL", 5)
    bench.ticks(5)
    bench.record.set_link("RDBL", None)
    bench.ticks(5)
    assert bench.stepper.at_rest and bench.commands[-1].verb == "STOP_AXIS"
    bench.forget()
    bench.put("VAL", 3)
    assert not any(one.verb == "GO" for one in bench.commands)


def test_retries_end_with_miss():
    bench = motor(Stepper(ratio=1.0, slip=-20.0), RTRY=3, ERES=0.01)
    bench.put("UEIP", 1)
    settled(bench)
    bench.stepper.slip = 0.0
    bench.put("VAL", 1.0)
    bench.ticks(3)
    bench.stepper.stuck = 1.0
    bench.stepper.motion = type(bench.stepper.motion).REST
    bench.stepper.status_wanted = True
    for _ in range(10):
        bench.tick()
        bench.stepper.motion = type(bench.stepper.motion).REST
    assert fields(bench, "MISS", "RCNT", "DMOV", "MIP") == (1, 4, 1, Mip.DONE)


def test_a_delay_holds_dmov_and_asks_for_the_position_again():
    bench = motor(DLY=0.5)
    bench.put("VAL", 0.1)
    bench.ticks(20)
    assert bench.delay_s == 0.5 and bench.record["DMOV"] == 0
    bench.forget()
    bench.end_delay()
    assert commands(bench) == ["GET_INFO"]
    bench.ticks(1)
    assert fields(bench, "DMOV", "RBV", "MIP") == (1, 0.1, Mip.DONE)


def test_a_delay_that_nobody_waits_for_is_nothing():
    bench = motor()
    outcome = bench.record.delay_over()
    assert (outcome.commands, outcome.posts) == ((), ())


def test_targets_from_a_link_move_at_each_processing():
    bench = motor(links={"DOL": 1.5}, OMSL="closed_loop")
    bench.put("PROC", 1)
    assert settled(bench).record["RBV"] == 1.5
    bench.put("TWF", 1)
    assert settled(bench).record["RBV"] == 1.5  # buttons have no effect
    bench.record.set_link("DOL", None)
    bench.put("PROC", 1)
    assert fields(bench, "STAT", "SEVR", "RBV") == (17, 3, 1.5)


def test_closed_loop_without_a_link_leaves_targets_to_clients():
    bench = motor(OMSL="closed_loop", DOL="3.5")
    bench.put("VAL", 1.0)
    assert settled(bench).record["RBV"] == 1.0


# --- the document ------------------------------------------------------------------------------


def test_the_example_of_the_document_says_what_it_prints(capsys):
    page = (ROOT / "docs" / "MOTOR-RECORD.md").read_text()
    example = page.split("```python\n")[1].split("```")[0]
    exec(compile(example, "MOTOR-RECORD.md", "exec"), {})
    promised = [
        row.split("  # ")[1]
        for row in example.splitlines()
        if row.startswith("print") and "#" in row
    ]
    assert capsys.readouterr().out.splitlines() == promised


# --- monitors and access -----------------------------------------------------------------------


def test_rbv_is_posted_beyond_its_dead_band_only():
    bench = motor(MDEL=0.31, ADEL=100)
    bench.put("VAL", 1.0)
    seen = []
    while not bench.record["DMOV"]:
        outcome = bench.tick()
        seen += [] if outcome is None else posted(outcome, "RBV")
    assert [value for _, value in seen] == pytest.approx([0.32, 0.64, 0.96])


def test_what_is_locked_takes_no_write():
    bench = motor(DISP=1)
    with pytest.raises(PutRefusedError, match="DISP is 1"):
        bench.record.put("VAL", 1)
    assert bench.put("DISP", 0) is not None
    assert bench.put("VAL", 1) is not None


def test_a_disabled_record_does_not_act():
    bench = motor(DISA=1)
    outcome = bench.put("VAL", 1)
    assert commands(bench) == [] and posted(outcome, "DMOV") == []
