# shellcheck shell=bash disable=SC2154
# The part of scripts/nodes that checks nodes of mpirun. It uses the functions of that script's common.sh.

need_packages "${gl_packages[@]}"
if [ -z "${MPIRUN:-}" ]; then need_packages openmpi-bin; fi
if [ -z "${CUPOLA:-}" ]; then need_packages libopenmpi-dev libclang-dev; fi
need_cargo
read -ra mpirun <<<"${MPIRUN:-mpirun --enable-recovery --oversubscribe}"
# MPICH kills all commands if one is killed, and what is in their process groups.
if [[ ${mpirun[*]} == *--enable-recovery* ]]; then recovers=yes own_group=(); else recovers=no own_group=(setsid); fi
cupola=${CUPOLA:-$PWD/target/mpi/debug/cupola} out=$PWD/out/nodes-mpi
if [ -z "${CUPOLA:-}" ]; then
    say "building"
    cargo build --lib --bin cupola --features mpi --target-dir target/mpi
    cargo build --package cupola_clock --target-dir target/mpi
fi
rm -rf "$out"
mkdir -p "$out"
make -s -C tests/apps OUT="$out/apps" CUPOLA="$(dirname "$cupola")" "$out/apps/by_time"
start_x_server "$out"
export LP_NUM_THREADS=1 vblank_mode=0 LIBGL_ALWAYS_SOFTWARE=1 CUPOLA_CACHE=$out/results
# Open MPI refuses to run for root otherwise.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
# It leaves files when it is killed: here, and not in /dev/shm.
export OMPI_MCA_btl_vader_backing_directory=$out
sed 's/^size = .*/size = [96, 54]/' src/rig/presets/planetarium-6.toml >"$out/dome.toml"
common=(--rig "$out/dome.toml" --size 96x96 --offscreen)
# The program writes a line for each frame to a file of its node in FOLDER.
# shellcheck disable=SC2016 # the variables are those of the nodes
program=("${own_group[@]}" sh -c 'exec "$0" "$@" --answers "$FOLDER/frames-${CUPOLA_NODE%/*}"'
    "$out/apps/by_time" --frames 0 --size 96x96)

# nodes NAME OPTION…: runs the program on four nodes; fails if mpirun does.
nodes() {
    local folder=$out/$1
    shift
    mkdir -p "$folder"
    FOLDER=$folder "${mpirun[@]}" -np 4 "$cupola" node "${common[@]}" --capture "$folder/x.png" "$@" -- \
        "${program[@]}" >"$folder/log" 2>&1 || fail "mpirun failed; see $folder/log"
}

# one FRAME: runs the program alone, with the same clock and random numbers, until a frame.
one() {
    local folder=$out/one-$1
    mkdir -p "$folder"
    FOLDER=$folder "$cupola" run --clock 60 --seed 7 "${common[@]}" --frames "$1" --capture "$folder/x.png" -- \
        "${program[@]}" >"$folder/log" 2>&1 || fail "cupola run failed; see $folder/log"
}

# equal FOLDER FOLDER: prints how many pictures of the first are the same in the second.
equal() {
    local picture count=0
    for picture in "$out/$1"/*.png; do
        ! cmp -s "$picture" "$out/$2/$(basename "$picture")" || count=$((count + 1))
    done
    echo $count
}

say "four nodes of mpirun and one process"
for frame in 1 40 200; do
    nodes "four-$frame" --unpaced --time-out 60000 --seed 7 --frames $frame
    one $frame
    count=$(equal "one-$frame" "four-$frame")
    echo "frame $frame: $count of 6 pictures are equal, byte for byte"
    grep "frames on 4 nodes" "$out/four-$frame/log" || true
    [ "$count" -eq 6 ] || fail "pictures differ; see $out/one-$frame and $out/four-$frame"
    grep -q "all alike" "$out/four-$frame/log" || fail "the nodes were not alike; see $out/four-$frame/log"
done
count=$(equal one-40 four-200)
echo "control, frames 40 and 200: $count of 6 pictures are equal"
[ "$count" -lt 6 ] || fail "the pictures do not change"

say "control: without the common clock"
nodes control --unpaced --time-out 60000 --own-clocks --frames 40
count=$(equal one-40 control)
echo "$count of 6 pictures are equal"
[ "$count" -lt 6 ] || fail "the control is equal"
grep -q "draws something else than the others" "$out/control/log" || fail "nodes that differ are not named"

# drawn NODE: prints how many frames its program has begun.
drawn() {
    if [ -f "$killed/frames-$1" ]; then wc -l <"$killed/frames-$1"; else echo 0; fi
}

# Kills the command of a node.
killed() {
    say "a node is killed"
    local frames=1000 launcher node orphan before count own name others
    killed=$out/killed
    mkdir -p "$killed"
    # Each node writes the number of its process to a file.
    # shellcheck disable=SC2016 # the variables are those of the nodes
    FOLDER=$killed "${mpirun[@]}" -np 4 \
        sh -c 'echo $$ >"$FOLDER/process-${OMPI_COMM_WORLD_RANK:-$PMI_RANK}" && exec "$0" "$@"' \
        "$cupola" node "${common[@]}" --unpaced --time-out 300 --seed 7 --frames $frames \
        --capture "$killed/x.png" -- "${program[@]}" >"$killed/log" 2>&1 &
    launcher=$!
    for _ in {1..600}; do
        [ "$(drawn 2)" -lt 100 ] || break
        sleep 0.05
    done
    node=$(cat "$killed/process-2")
    orphan=$(pgrep -P "$node" || true)
    kill -KILL "$node"
    before=$(drawn 0)
    [ "$before" -lt $((frames - 100)) ] || fail "the node was killed too late, after $before frames"
    for _ in {1..600}; do
        [ "$(drawn 0)" -lt $frames ] || break
        sleep 0.1
    done
    # Its program goes on alone.
    [ -z "$orphan" ] || kill "$orphan" 2>/dev/null || true
    wait $launcher || true
    echo "killed after $before frames; frames that the others have drawn: $(drawn 0) $(drawn 1) $(drawn 3)"
    grep -E "node 2 has (ended unexpectedly|not reached frame)" "$killed/log" ||
        fail "nothing was said about node 2; see $killed/log"
    one $frames
    for node in 0 1 3; do
        [ "$(drawn $node)" -ge $frames ] || fail "node $node has not gone on; see $killed/log"
    done
    own=$(sed -n 's/.*node 2 of 4 .* shows //p' "$killed/log")
    [ -n "$own" ] || fail "it is not known what node 2 shows; see $killed/log"
    for name in ${own//,/ }; do
        rm -f "$killed/x-$name.png"
    done
    count=$(equal one-$frames killed) others=$((6 - $(wc -w <<<"$own")))
    echo "frame $frames: $count of the $others pictures of the others are equal to those of one process"
    [ "$count" -eq $others ] || fail "pictures of the others differ; see $killed"
}

if [ $recovers = yes ]; then killed; fi

# shellcheck source=scripts/nodes-mpi-failures.sh
. scripts/nodes-mpi-failures.sh
