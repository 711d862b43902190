# SPDX-License-Identifier: MIT
"""One or two command lines for the help of every command."""

_PRN = "AccProfM39-30Hz-1.PRN"
_SMOOTH = "line.csv --decode smooth --backlash 250"
_PORT = "--port /dev/ttyACM0"
_MOVE = "fast.csv --steps 40000"
_LOAD = '"home=2000,hyst=8,travel=-500..4000,start=123,delay=8000"'
_SCALE = '--scale "1638400 steps/in"'

EXAMPLES = {
    "bench": ("bench --board uno --only rates", "bench --compare"),
    "board arm": ("board arm --axis 0",),
    "board clear": ("board clear", "board clear --unit all"),
    "board disable": ("board disable --axis 0 --axis 1",),
    "board disarm": ("board disarm",),
    "board enable": ("board enable --axis 0",),
    "board features": ("board features --unit all",),
    "board get": ("board get status 'axis0.*'", f"board get {_PORT} --json"),
    "board home": ("board home fast.csv --axis 1 --direction minus",),
    "board info": (f"board info {_PORT}", "board info --unit 1,2 --json"),
    "board log events": ("board log events --follow",),
    "board log records": ("board log records --axis 0 -o log.csv",),
    "board measure-play": (
        "board measure-play fast.csv --axis 1 --hysteresis 8",
        "board measure-play fast.csv --hysteresis 8 --repeat 10 --save",
    ),
    "board move": (f"board move {_MOVE} --axis 2",),
    "board permit": ("board permit on",),
    "board scan": (f"board scan {_PORT} --bauds",),
    "board selftest": ("board selftest --axis 0", "board selftest --yes --json"),
    "board set": ("board set pixel_hz=30000/1001 dir_setup_us=30 --store",),
    "board settings defaults": ("board settings defaults --store",),
    "board settings diff": ("board settings diff mine.toml",),
    "board settings export": ("board settings export mine.toml", "board settings export -"),
    "board settings import": ("board settings import mine.toml --skip unit_address --store",),
    "board settings store": ("board settings store --unit all",),
    "board simulate": (
        "board simulate --board mega --pixel-hz 30 --link /tmp/mega",
        "board simulate --board uno --pixel-hz 100 --script accident.txt --json",
    ),
    "board start": ("board start --unit 1,2 --wait",),
    "board stop": ("board stop", "board stop --unit 1 --axis 0"),
    "board run": (
        "board run square.pmc",
        "board run square.pmc --no-check --mode lookahead --window 200",
    ),
    "board trajectory": (
        "board trajectory circle.trj --play 7485 --pixel-hz 100.13",
        "board trajectory circle.trj --play 7485 --run original",
    ),
    "board upload": (
        f"board upload {_SMOOTH} --arm --wait",
        "board upload a.csv b.csv --decode smooth --decode plain --axis 0",
    ),
    "board watch": ("board watch", "board watch --once --json"),
    "completion": ("completion bash", "completion zsh -o -"),
    "demo": ("demo --out demo",),
    "file check": (f"file check {_PRN} --decode smooth",),
    "file convert": (
        "file convert line.csv line.csb",
        "file convert line.csb - --to csv --drop-header",
    ),
    "file info": ("file info line.csb --json",),
    "flash": (f"flash --board mega {_PORT}", f"flash --board uno {_PORT} --dry-run"),
    "home sim": (
        f"home sim fast.csv --board mega --axis 1 --pixel-hz 30 --plant {_LOAD} --out home --plot",
    ),
    "job check": ("job check print.pxjob", "job check print.pxjob --boards --json"),
    "job export": ("job export print.pxjob --out lines",),
    "job make": (
        "job make --image-size 450x1000 --scan X=200 --step Y=40 -o print.pxjob",
        "job make --useq grid.yaml --axis-of X=x --axis-of Y=y --lead-in 8 -o print.pxjob",
    ),
    "job pause": ("job pause print.pxrun",),
    "job report": ("job report print.pxrun", "job report print.pxrun --measured encoder.csv"),
    "job resume": ("job resume print.pxrun", "job resume print.pxrun --redo 7 --skip 8 --homed"),
    "job run": (
        "job run print.pxjob --folder monday.pxrun",
        "job run print.pxjob --to-start --accept-amber",
    ),
    "job simulate": (
        "job simulate print.pxjob",
        "job simulate print.pxjob --scheduler tcp://lab7:8786 --out print.pxsim --json",
    ),
    "job status": ("job status print.pxrun",),
    "job show": ("job show print.pxjob", "job show print.pxjob --line 7 --json"),
    "job show-config": ("job show-config print.pxjob", "job show-config print.pxjob --out copy"),
    "line check": (f"line check {_SMOOTH}", "line check many.csb --line 2 --decode plain --json"),
    "line compensate": (
        "line compensate ideal.csv --play 40 --max-acceleration 10 --start-stop 4 -o made.csv",
    ),
    "ioc": ("ioc --prefix LAB:", "ioc --prefix LAB: --list", "ioc --simulate"),
    "limits": ("limits --board mega --axes 2 --pixel-hz 200",),
    "line import": (
        "line import positions.csv --decode plain --column 2 -o line.csv",
        "line import steps.txt --decode plain --quantity steps -o line.csv",
    ),
    "line make": (
        f"line make --profile {_PRN} --speed 1000 --pixels 60 --pixel-hz 30 -o line.csv",
    ),
    "line show": (f"line show {_SMOOTH} --plot line.png",),
    "machine check": ("machine check", "machine check printer.toml"),
    "machine new": ("machine new --board mega --pixel-hz 30 --motor M39:smooth --motor M40:plain",),
    "machine show": ("machine show", "machine show printer.toml --json"),
    "move make": (f"move make {_MOVE} --pixel-hz 30 -o move.csv",),
    "move show": (f"move show {_MOVE} --pixel-hz 30 --plot move.png",),
    "move sim": (f"move sim {_MOVE} --pixel-hz 30 --board mega --out move --plot",),
    "plan": (
        "plan square.pmc --out square --plot",
        "plan square.pmc --mode mode1 --json",
    ),
    "profile check": (f"profile check {_PRN}", "profile check fast.csv --decode plain"),
    "profile make": (
        "profile make --top-speed 30000steps/s --max-acceleration 115200steps/s2 --max-jerk 40 "
        "--pixel-hz 30 --motor M39 --variant 2",
    ),
    "profile repair": ("profile repair tens.csv -o mended.csv",),
    "profile show": (f"profile show {_PRN} --speed 1000 --plot profile.png",),
    "serve": (f"serve {_PORT}", f"serve {_PORT} --status"),
    "sim": (
        f"sim {_SMOOTH} --board mega --pixel-hz 30 --out run",
        "sim a.csv b.csv --board mega --decode smooth --decode plain --pixel-hz 30 --serial-load "
        "--out run",
    ),
    "trajectory circle": (
        f"trajectory circle --diameter 0.125in {_SCALE} --lead-in 128 -o circle.trj",
    ),
    "trajectory compensate": (
        "trajectory compensate circle.trj --play 7485 --pixel-hz 100.13 -o made.trj",
    ),
    "trajectory export": ("trajectory export circle.trj -o circle.parquet",),
    "trajectory import": ("trajectory import mine.csv -o mine.trj",),
    "trajectory show": (
        f"trajectory show circle.trj --play 7485 --pixel-hz 100.13 {_SCALE} --plot circle.png",
    ),
    "trajectory sim": (
        f"trajectory sim circle.trj --board mega --pixel-hz 100.13 --play 7485 {_SCALE} "
        "--out circle --plot",
    ),
    "ticks": (f"ticks {_SMOOTH} --pixel-hz 30000/1001 -o ticks.csv",),
    "watch": ("watch print.pxrun", "watch print.pxrun --web", "watch --web --port /dev/ttyACM0"),
}
