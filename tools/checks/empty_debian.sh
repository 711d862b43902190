#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What a new user meets: an empty Debian in a folder, without Python or a compiler, and there
# what README.md, docs/INSTALL.md and docs/API.md tell to type. Prints a row for each command with
# its time; the exit status is 0 only if each ended as it should and none with a traceback.
#
#   empty_debian.sh FOLDER               the scenes sources, wheels, clone and examples
#   empty_debian.sh FOLDER SCENE...      some of sources, wheels, clone, examples, check
#
#   sources    pip installs the package from a copy of the sources, as INSTALL says
#   wheels     both wheels, built by tools/pixstep-dev here; there Python and the wheels alone, a
#              user without sudo: the small installation, the simulator, the drawings; scripts
#   clone      tools/demo in a fresh clone; a user with sudo, nothing but git installed
#   examples   in that clone: the scripts of docs/examples and the notebook
#   check      in that clone: tools/check
#
# Needs root, debootstrap, some gigabytes and the network. FOLDER/base, the empty system, is made
# once; the scenes begin with copies of it. The last commit of this clone is what is tried. SUITE
# in the environment names another system than bookworm, MIRROR where debootstrap finds it: noble
# and the address of Ubuntu's archive are Ubuntu 24.04.
set -euo pipefail

clone=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
user=anna
homes=/home
failed=0

die()
{
    printf 'empty_debian: %s\n' "$*" >&2
    exit 2
}

# inside ROOT WHO COMMAND: a shell in a root with nothing of this machine's environment but its way
# to the network. Its mounts end with it.
inside()
{
    local root=$1 who=$2 command=$3 home=/root name
    local -a keep=(TERM="${TERM:-dumb}")
    [ "$who" = root ] || home=$homes/$who
    for name in http_proxy https_proxy no_proxy PIP_DEFAULT_TIMEOUT NODE_EXTRA_CA_CERTS; do
        [ -z "${!name:-}" ] || keep+=("$name=${!name}")
    done
    cp /etc/resolv.conf "$root/etc/resolv.conf"
    # shellcheck disable=SC2016 # expanded by the inner shell
    unshare --mount --propagation private bash -c '
        root=$1 who=$2 home=$3 command=$4
        shift 4
        for place in proc sys dev; do
            mount --rbind "/$place" "$root/$place"
        done
        exec env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
            HOME="$home" USER="$who" "$@" chroot --userspec="$who:" "$root" \
            /bin/bash -c "cd && $command"
    ' - "$root" "$who" "$home" "$command" "${keep[@]}" </dev/null
}

# row ROOT WHO STATUS COMMAND: runs it, prints its time and whether it ended with this status.
row()
{
    local root=$1 who=$2 wanted=$3 command=$4 log start status=0 verdict=fine
    log=$root.log
    start=$(date +%s%N)
    inside "$root" "$who" "$command" >"$log.last" 2>&1 || status=$?
    if [ "$status" != "$wanted" ] || grep -q '^Traceback' "$log.last"; then
        verdict="WRONG, $wanted expected"
        failed=1
    fi
    printf '%-8s | %7.1f s | %3d %s | %s\n' "$(basename "$root")" \
        "$(($(date +%s%N) - start))e-9" "$status" "$verdict" "$command"
    [ "$verdict" = fine ] || tail -n 20 "$log.last"
    { printf '$ %s\n' "$command" && cat "$log.last"; } >>"$log"
}

# The system that all scenes begin with: the authorities of this machine's network are trusted.
make_base()
{
    local base=$folder/base
    [ ! -e "$base/ready" ] || return 0
    rm -rf "$base"
    debootstrap --variant=minbase "${SUITE:-bookworm}" "$base" ${MIRROR:+"$MIRROR"} \
        >"$folder/base.log" ||
        die "debootstrap failed: $folder/base.log"
    mkdir -p "$base/usr/local/share/ca-certificates"
    find /usr/local/share/ca-certificates -name '*.crt' \
        -exec cp {} "$base/usr/local/share/ca-certificates" \;
    inside "$base" root "useradd --create-home --shell /bin/bash $user"
    touch "$base/ready"
}

# fresh NAME: an empty system with this clone's last commit beside its user's home.
fresh()
{
    rm -rf "${folder:?}/$1" "$folder/$1.log"
    cp -a "$folder/base" "$folder/$1"
    git clone --quiet --bare --single-branch "$clone" "$folder/$1$homes/$user/origin.git"
    inside "$folder/$1" root "chown -R $user: $homes/$user"
}

scene_sources()
{
    local root=$folder/sources
    fresh sources
    git -C "$clone" archive --prefix=pixstep/ HEAD | tar -x -C "$root$homes/$user"
    inside "$root" root "chown -R $user: $homes/$user"
    row "$root" root 0 "apt-get update && apt-get install -y python3-dev python3-venv gcc cmake \
ninja-build gcc-avr avr-libc"
    row "$root" "$user" 0 "cd pixstep && python3 -m venv ~/pixstep-env"
    row "$root" "$user" 0 "cd pixstep && ~/pixstep-env/bin/pip install ."
    row "$root" "$user" 0 "cd pixstep && ~/pixstep-env/bin/pip wheel --no-deps ."
    row "$root" "$user" 0 "pixstep-env/bin/pixstep limits --board mega --pixel-hz 200"
    row "$root" "$user" 2 "pixstep-env/bin/pixstep demo"
}

# print_size ROOT: what pip has installed, byte code included, without pip itself.
print_size()
{
    inside "$1" "$user" 'du -sm --exclude="pip*" --exclude="setuptools*" --exclude=pkg_resources \
--exclude=_distutils_hack pixstep-env/lib/python3*/site-packages' |
        awk '{print "site-packages: " $1 " MB without pip"}'
}

scene_wheels()
{
    local root=$folder/wheels
    fresh wheels
    "$clone/tools/pixstep-dev" wheels --out "$root$homes/$user"
    row "$root" root 0 "apt-get update && apt-get install -y python3 python3-venv"
    row "$root" root 0 "! command -v gcc cc avr-gcc cmake git avrdude"
    row "$root" "$user" 0 "python3 -m venv ~/pixstep-env"
    row "$root" "$user" 0 "~/pixstep-env/bin/pip install pixstep-*.whl"
    print_size "$root"
    row "$root" "$user" 0 "mkdir work"
    small_commands "$root" "cd work && PATH=~/pixstep-env/bin:\$PATH"
    row "$root" "$user" 0 "~/pixstep-env/bin/pip install pixstep_sim-*.whl pixstep-*.whl"
    print_size "$root"
    row "$root" "$user" 0 "pixstep-env/bin/pixstep demo"
    wheel_commands "$root" "cd work && PATH=~/pixstep-env/bin:\$PATH"
    row "$root" "$user" 0 "~/pixstep-env/bin/pip install 'matplotlib>=3.8'"
    print_size "$root"
    row "$root" "$user" 0 "pixstep-env/bin/pixstep demo --out drawn && test -f drawn/motion.png"
    drawing_commands "$root" "cd work && PATH=~/pixstep-env/bin:\$PATH"
    wheel_scripts "$root"
    # No home, no terminal, the smallest locale, a narrow page, and a place that cannot be written.
    wheel_in_a_corner "$root" \
        "cd /etc && env -i PATH=$homes/$user/pixstep-env/bin:/usr/bin:/bin LANG=C COLUMNS=60"
}

small_commands()
{
    local root=$1 begin=$2 line="line.csv --decode smooth --backlash 250 --pixel-hz 30"
    local port="--port /dev/ttyACM0"
    row "$root" "$user" 0 "$begin pixstep --help"
    row "$root" "$user" 0 "$begin pixstep profile make --top-speed 1000 --max-acceleration 128 \
--max-jerk 64 --pixel-hz 30 --motor M39 --variant 1 --csv fast.csv"
    row "$root" "$user" 0 "$begin pixstep line make --profile AccProfM39-30Hz-1.PRN --speed 1000 \
--pixels 60 --pixel-hz 30 --backlash 250 -o line.csv"
    row "$root" "$user" 0 "$begin pixstep line check $line --board mega"
    row "$root" "$user" 0 "$begin pixstep line show $line"
    row "$root" "$user" 2 "$begin pixstep line show $line --plot line.png"
    row "$root" "$user" 0 "$begin pixstep ticks $line -o ticks.csv"
    row "$root" "$user" 0 "$begin pixstep limits --board mega --axes 2 --pixel-hz 200"
    row "$root" "$user" 2 "$begin pixstep trajectory circle --radius 3200 -o circle.trj"
    row "$root" "$user" 2 "$begin pixstep sim $line --board mega --out run"
    row "$root" "$user" 2 "$begin pixstep board simulate --board mega --pixel-hz 30"
    row "$root" "$user" 0 "$begin pixstep machine new --board mega --pixel-hz 30 --motor X:plain"
    row "$root" "$user" 0 "$begin pixstep machine check"
    row "$root" "$user" 0 "$begin pixstep machine show"
    row "$root" "$user" 0 "printf 'ABS LINEAR TA10 TS0 F20\nX4\nX0\n' >work/there.pmc"
    row "$root" "$user" 2 "$begin pixstep plan there.pmc --out there"
    row "$root" "$user" 0 "$begin pixstep flash --board mega $port --dry-run"
    row "$root" "$user" 2 "$begin pixstep flash --board mega $port"
    row "$root" "$user" 2 "$begin pixstep board info $port"
    row "$root" "$user" 2 "$begin pixstep board upload $line --arm $port"
}

wheel_commands()
{
    local root=$1 begin=$2 line="line.csv --decode smooth --backlash 250 --pixel-hz 30"
    row "$root" "$user" 0 "$begin pixstep trajectory circle --radius 3200 -o circle.trj"
    row "$root" "$user" 0 "$begin pixstep plan there.pmc --out there"
    row "$root" "$user" 0 "mkdir other && cp work/line.csv other"
    row "$root" "$user" 0 "${begin/work/other} pixstep sim $line --board mega --out run"
    row "$root" "$user" 0 "$begin pixstep-sim --help"
    row "$root" "$user" 2 "$begin pixstep plan there.pmc --out drawn --plot"
    row "$root" "$user" 0 "$begin timeout --preserve-status --signal=INT 5 pixstep board \
simulate --board mega --pixel-hz 30"
}

drawing_commands()
{
    local root=$1 begin=$2 line="line.csv --decode smooth --backlash 250 --pixel-hz 30"
    row "$root" "$user" 0 "$begin pixstep line show $line --plot line.png"
    row "$root" "$user" 0 "$begin pixstep plan there.pmc --out drawn --plot"
}

# The scripts of docs/examples and the notebook, without a clone.
wheel_scripts()
{
    local root=$1 name
    cp -r "$clone/docs/examples" "$root$homes/$user/examples"
    for name in own_profile four_axes locked_scan; do
        row "$root" "$user" 0 "cd work && ~/pixstep-env/bin/python ~/examples/$name.py"
    done
    row "$root" "$user" 0 "~/pixstep-env/bin/pip install notebook"
    row "$root" "$user" 0 "cd work && ~/pixstep-env/bin/jupyter execute --output=\$PWD/done.ipynb \
~/examples/first_line.ipynb"
}

wheel_in_a_corner()
{
    local root=$1 begin=$2 work=$homes/$user/work
    local line="$work/line.csv --decode smooth --backlash 250 --pixel-hz 30"
    row "$root" "$user" 0 "$begin pixstep --help"
    row "$root" "$user" 0 "$begin pixstep line check $line --board mega"
    row "$root" "$user" 0 "$begin pixstep limits --board mega --pixel-hz 200"
    row "$root" "$user" 0 "$begin HOME=/none pixstep line show $line --plot $work/other.png"
    row "$root" "$user" 2 "$begin pixstep line show $line --plot line.png"
    row "$root" "$user" 2 "$begin pixstep ticks $line -o ticks.csv"
    row "$root" "$user" 2 "$begin pixstep machine new --board mega --pixel-hz 30"
    row "$root" "$user" 2 "$begin pixstep limits --board mega --pixel-hz 200 >/dev/full"
}

scene_clone()
{
    local root=$folder/clone
    fresh clone
    row "$root" root 0 "apt-get update && apt-get install -y --no-install-recommends git sudo"
    inside "$root" root "echo '$user ALL=(ALL) NOPASSWD: ALL' >/etc/sudoers.d/$user"
    row "$root" "$user" 0 "git clone origin.git pixstep"
    row "$root" "$user" 0 "cd pixstep && tools/demo"
    row "$root" "$user" 0 "cd pixstep && test -z \"\$(git status --short)\""
}

scene_check()
{
    row "$folder/clone" "$user" 0 "cd pixstep && tools/check"
}

scene_examples()
{
    local root=$folder/clone begin="mkdir -p ~/own && cd ~/own &&" name
    for name in own_profile four_axes locked_scan; do
        row "$root" "$user" 0 "$begin ~/pixstep/build/venv/bin/python \
~/pixstep/docs/examples/$name.py"
    done
    row "$root" "$user" 0 "cd own; (cd ~/pixstep && exec build/host/bin/pixstep-sim --pixel-hz 30 \
--pty --board mega=build/mega/firmware/pixstep-mega.elf) >bench.txt & \
until grep -q /dev/pts bench.txt; do sleep 1; done; ~/pixstep/build/venv/bin/python \
~/pixstep/docs/examples/drive_board.py \$(cat bench.txt); status=\$?; kill \$!; exit \$status"
    row "$root" "$user" 0 "python3 -m venv ~/pixstep-env"
    row "$root" "$user" 0 "~/pixstep-env/bin/pip install ~/pixstep[plot] notebook"
    row "$root" "$user" 0 "$begin PIXSTEP_SIM=~/pixstep/build/host/bin/pixstep-sim \
~/pixstep-env/bin/jupyter execute --output=\$PWD/done.ipynb \
~/pixstep/docs/examples/first_line.ipynb"
}

main()
{
    [ $# -ge 1 ] || die "usage: empty_debian.sh FOLDER [sources|wheels|clone|examples|check]..."
    [ "$(id -u)" = 0 ] || die "needs root: it makes a system of its own in a folder"
    command -v debootstrap >/dev/null || die "debootstrap is missing: apt-get install debootstrap"
    mkdir -p "$1"
    folder=$(cd "$1" && pwd)
    shift
    [ $# -gt 0 ] || set -- sources wheels clone examples
    for scene in "$@"; do
        case $scene in
        sources | wheels | clone | examples | check) ;;
        *) die "what is '$scene'? sources, wheels, clone, examples or check" ;;
        esac
    done
    make_base
    for scene in "$@"; do
        "scene_$scene"
    done
    return "$failed"
}

main "$@"
