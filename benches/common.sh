# shellcheck shell=bash
# Functions that the benchmarks of complete programs share. Source this file after scripts/common.sh.
#
# Time per frame: the time of few frames is subtracted from that of many, and divided by the difference in frames. So
# start and planning cancel out.
#
# wall: elapsed time, which counts on an idle machine. cpu: processor time of all threads, which other load hardly
# changes.

# own_display PIXELS: makes a temporary folder, sets `work` to it, and starts an X server with a screen of PIXELS ×
# PIXELS.
own_display() {
    local size=$1 number
    work=$(mktemp -d)
    mkfifo "$work/display"
    Xvfb -displayfd 3 -screen 0 "${size}x${size}x24" -nolisten tcp -noreset 3>"$work/display" 2>/dev/null &
    server=$!
    trap 'kill $server 2>/dev/null || true; rm -rf "$work"' EXIT
    read -r number <"$work/display"
    export DISPLAY=:$number LIBGL_ALWAYS_SOFTWARE=1 vblank_mode=0
}

# Sets `cupola` to the command that the user named, or builds it.
own_cupola() {
    if [ -n "$cupola" ]; then
        cupola=$(realpath "$cupola")
    else
        need_cargo
        say "building"
        cargo build --release --lib --bins
        cupola=$PWD/target/release/cupola
    fi
}

# seconds COMMAND…: prints the seconds of wall clock and of all threads that a command takes.
seconds() {
    local TIMEFORMAT='%R %U %S'
    { time timeout 300 "$@" >/dev/null 2>>"$work/log"; } 2>&1 | awk '{ print $1, $2 + $3 }'
}

# measure NAME FEW MANY COMMAND…: adds a line to times.tsv; %N in the command is the number of frames.
measure() {
    local name=$1 few=$2 many=$3 wall cpu more_wall more_cpu
    shift 3
    read -r wall cpu < <(seconds "${@//%N/$few}")
    read -r more_wall more_cpu < <(seconds "${@//%N/$many}")
    awk -v name="$name" -v n=$((many - few)) -v a="$wall" -v b="$more_wall" -v c="$cpu" -v d="$more_cpu" \
        'BEGIN { print name "\t" 1000 * (b - a) / n "\t" 1000 * (d - c) / n }' >>"$work/times.tsv"
}

# median NAME COLUMN: prints the median of the measurements; column 2 is wall, 3 is cpu, in milliseconds.
median() {
    awk -F '\t' -v name="$1" -v column="$2" '$1 == name { print $column }' "$work/times.tsv" | sort -g |
        awk '{ all[NR] = $1 } END { print NR % 2 ? all[(NR + 1) / 2] : (all[NR / 2] + all[NR / 2 + 1]) / 2 }'
}

# table NAME…: prints the medians. Names are "SCENE WAY"; the ways of a scene are compared with its way "plain".
table() {
    local name
    printf '%-28s %10s %10s %10s %10s\n' "" "wall, ms" "cpu, ms" "wall, x" "cpu, x"
    for name in "$@"; do
        awk -v name="$name" -v a="$(median "$name" 2)" -v b="$(median "$name" 3)" -v c="$(median "${name%% *} plain" 2)" \
            -v d="$(median "${name%% *} plain" 3)" \
            'BEGIN { printf "%-28s %10.2f %10.2f %10.2f %10.2f\n", name, a, b, a / c, b / d }'
    done
}
