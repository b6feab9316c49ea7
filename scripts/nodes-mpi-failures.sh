# shellcheck shell=bash disable=SC2154
# The part of scripts/nodes-mpi.sh that stops a node for two seconds, and kills mpirun. It uses the variables of that
# script. Processes outside of the show write down when each program draws each frame: the programs' own clocks are
# those of the show.

limit=300 # milliseconds of --time-out
launcher='' commands=() programs=() writers=()

# write_down NODE: writes the number of each frame of a node's program, and the time in microseconds, to a file.
write_down() {
    local line
    # Opened for writing, too, so that it does not end when the program closes the pipe.
    while read -r line; do
        echo "${line%% *} ${EPOCHREALTIME/[.,]/}"
    done <>"$folder/frames-$1" >"$folder/times-$1"
}

# drawn NODE: prints how many frames its program has begun.
drawn() {
    wc -l <"$folder/times-$1"
}

# wait_for WHAT COMMAND…: waits until the command succeeds, for 60 s.
wait_for() {
    local what=$1
    shift
    for _ in {1..600}; do
        ! "$@" || return 0
        sleep 0.1
    done
    fail "$what; see $folder/log"
}

# has_drawn NODE COUNT, is_said WORDS FILE, is_near NODE NODE: conditions for wait_for.
has_drawn() {
    [ "$(drawn "$1")" -ge "$2" ]
}
is_said() {
    grep -qs "$1" "$folder/$2"
}
is_near() {
    local distance=$(($(drawn "$1") - $(drawn "$2")))
    [ ${distance#-} -le 2 ]
}

# begin NAME: starts four nodes. Sets `launcher`, the process of mpirun, and `commands` and `programs`: those of the
# nodes.
begin() {
    folder=$out/$1 commands=() programs=()
    mkdir -p "$folder"
    for node in 0 1 2 3; do
        mkfifo "$folder/frames-$node"
        : >"$folder/times-$node"
        write_down $node &
        writers+=($!)
    done
    # shellcheck disable=SC2016 # the variables are those of the nodes
    FOLDER=$folder "${mpirun[@]}" -np 4 \
        sh -c 'echo $$ >"$FOLDER/process-${OMPI_COMM_WORLD_RANK:-$PMI_RANK}" && exec "$0" "$@"' \
        "$cupola" node "${common[@]}" --time-out $limit --log "$folder/said" -- "${program[@]}" >"$folder/log" 2>&1 &
    launcher=$!
    for node in 0 1 2 3; do
        wait_for "node $node shows no frames" has_drawn $node 100
        commands+=("$(cat "$folder/process-$node")")
        programs+=("$(pgrep -P "${commands[-1]}")")
    done
}

# end_show: ends what begin has started.
end_show() {
    local process
    for process in $launcher "${commands[@]}" "${programs[@]}" "${writers[@]}"; do
        kill -KILL "$process" 2>/dev/null || true
        wait "$process" 2>/dev/null || true
    done
    launcher='' commands=() programs=() writers=()
}

# pause FROM NODE…: prints the longest time in milliseconds in which one of the programs began no frame, from then on.
pause() {
    local from=$1 node
    shift
    for node in "$@"; do
        awk -v from="$from" -v to="${EPOCHREALTIME/[.,]/}" '
            function look(time) { if (time - last > most) most = time - last }
            BEGIN { last = from } $2 > from { look($2); last = $2 } END { look(to); printf "%d\n", most / 1000 }' \
            "$folder/times-$node"
    done | sort -n | tail -n 1
}

# expect_pause WHAT MILLISECONDS: prints a pause, and fails if it is much longer than the time-out and a frame.
expect_pause() {
    echo "longest time without a frame, $1: $2 ms, with a time-out of $limit ms"
    [ "$2" -lt $((limit + 700)) ] || fail "the others have waited too long; see $folder"
}

# once WORDS [FILE]: fails unless this is said, and once. The programs' messages are also in the file `said`.
once() {
    local file=${2:-log} count
    wait_for "it is not said that $1" is_said "$1" "$file"
    count=$(grep -c "$1" "$folder/$file")
    [ "$count" -eq 1 ] || fail "said $count times: $1; see $folder/$file"
    echo "said once: … $1 …"
}

trap 'end_show; kill $x_server 2>/dev/null || true' EXIT

say "a node stops for two seconds"
begin stopped
from=${EPOCHREALTIME/[.,]/}
kill -STOP "${commands[2]}" "${programs[2]}"
before=$(drawn 2)
sleep 2
[ $(($(drawn 2) - before)) -le 1 ] || fail "node 2 was not stopped"
expect_pause "of the others" "$(pause "$from" 0 1 3)"
from=${EPOCHREALTIME/[.,]/}
kill -CONT "${programs[2]}" "${commands[2]}"
once "node 2 has not reached frame"
once "node 2 is in step again"
wait_for "node 2 is not in step again" is_near 1 2
expect_pause "of the others until it is there again" "$(pause "$from" 0 1 3)"

say "only the command of a node stops for two seconds"
from=${EPOCHREALTIME/[.,]/}
kill -STOP "${commands[3]}"
sleep 2
expect_pause "of the others" "$(pause "$from" 0 1 2)"
expect_pause "of its program" "$(pause "$from" 3)"
kill -CONT "${commands[3]}"
once "node 3: the other nodes do not answer in time"
once "node 3: this program is in step with the other nodes again"
wait_for "node 3 is not in step again" is_near 1 3
end_show

say "mpirun is killed"
begin launcher
from=${EPOCHREALTIME/[.,]/}
# A shell that waits at once does not print that it was killed.
{ kill -KILL $launcher && wait $launcher; } 2>/dev/null || true
sleep 3
expect_pause "of the programs" "$(pause "$from" 0 1 2 3)"
for node in 0 1 2 3; do
    kill -0 "${programs[node]}" 2>/dev/null || fail "the program of node $node has ended; see $folder"
    count=$(awk -v from="$from" '$2 > from { count++ } END { print count + 0 }' "$folder/times-$node")
    if kill -0 "${commands[node]}" 2>/dev/null; then state="goes on"; else state="has ended"; fi
    echo "node $node: $count frames in 3 s; its cupola node $state"
done
for node in 0 1 2 3; do
    once "node $node: this program has lost the other nodes" said
done
end_show
