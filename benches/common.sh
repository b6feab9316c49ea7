# shellcheck shell=bash
# What the benchmarks of whole programs share; to be sourced after scripts/common.sh.
#
# Time per frame is that of many frames less that of few, divided by the difference: start and planning cancel out.
# wall: on an idle machine the time that counts; cpu: of all threads, which other load hardly changes.

# Sets `work`, a folder of its own, and an X server with a screen of that many pixels squared.
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

# Sets `cupola` to the one that was asked for, or builds it.
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

# Seconds of wall clock and of all threads that a command takes.
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

# median NAME COLUMN: of what was measured; column 2 is wall, 3 is cpu, in milliseconds.
median() {
    awk -F '\t' -v name="$1" -v column="$2" '$1 == name { print $column }' "$work/times.tsv" | sort -g |
        awk '{ all[NR] = $1 } END { print NR % 2 ? all[(NR + 1) / 2] : (all[NR / 2] + all[NR / 2 + 1]) / 2 }'
}

# table NAME…: the medians; names are "SCENE WAY", and the way "plain" of a scene is what others are compared with.
table() {
    local name
    printf '%-28s %10s %10s %10s %10s\n' "" "wall, ms" "cpu, ms" "wall, x" "cpu, x"
    for name in "$@"; do
        awk -v name="$name" -v a="$(median "$name" 2)" -v b="$(median "$name" 3)" -v c="$(median "${name%% *} plain" 2)" \
            -v d="$(median "${name%% *} plain" 3)" \
            'BEGIN { printf "%-28s %10.2f %10.2f %10.2f %10.2f\n", name, a, b, a / c, b / d }'
    done
}
