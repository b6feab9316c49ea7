# shellcheck shell=bash disable=SC2034,SC2154
# The part of scripts/stream for PipeWire. It uses the functions and variables of that script.

export XDG_RUNTIME_DIR=$out/run XDG_STATE_HOME=$out/state
unset PIPEWIRE_REMOTE PIPEWIRE_RUNTIME_DIR
mkdir -p "$XDG_RUNTIME_DIR"
chmod 700 "$XDG_RUNTIME_DIR"
source=cupola-$$
# A daemon without sound cards, cameras and real-time threads.
cat >"$out/pipewire.conf" <<'END'
context.properties = { support.dbus = false core.daemon = true core.name = pipewire-0 mem.allow-mlock = false }
context.spa-libs = { support.* = support/libspa-support }
context.modules = [
    { name = libpipewire-module-protocol-native }
    { name = libpipewire-module-metadata }
    { name = libpipewire-module-spa-node-factory }
    { name = libpipewire-module-client-node }
    { name = libpipewire-module-access }
    { name = libpipewire-module-adapter }
    { name = libpipewire-module-link-factory }
    { name = libpipewire-module-session-manager }
]
END
pipewire -c "$out/pipewire.conf" >"$out/pipewire.log" 2>&1 &
daemon=$!
trap 'kill $x_server $daemon 2>/dev/null || true' EXIT
for _ in {1..50}; do
    [ ! -S "$XDG_RUNTIME_DIR/pipewire-0" ] || break
    sleep 0.1
done
wireplumber >"$out/session.log" 2>&1 &
sleep 1

# send NAME [OPTION…]: starts cupola stream, with its options.
send() {
    local name=$1
    shift
    "$cupola" stream "pipewire:$source" --published "$ring" --stats "$out/$name.json" "$@" 2>"$out/$name.log" &
    sender=$!
}

# receive: writes the pixels that a receiver gets to the standard output, as soon as there is a source.
receive() {
    until pw-cli ls Node 2>/dev/null | grep -q "\"$source\""; do
        sleep 0.1
    done
    exec gst-launch-1.0 -q pipewiresrc "target-object=$source" ! video/x-raw,format=RGBx ! fdsink fd=1 sync=false \
        2>>"$out/receiver.log"
}

# ended NAME: waits for program and sender; prints the numbers of the sender.
ended() {
    wait "$program" || true
    wait "$sender" || fail "$1: cupola stream failed: $(cat "$out/$1.log")"
    jq -c . "$out/$1.json"
}

# number NAME KEY: prints a number of the sender.
number() {
    jq ".$2 // 0" "$out/$1.json"
}

# same RECEIVED PUBLISHED SIDE SHIFT: prints how many of the received pictures are the published ones with the same
# number plus SHIFT, byte for byte, and how many were received.
same() {
    local bytes=$(($3 * $3 * 4)) number place=0 equal=0 published
    declare -A at=()
    while read -r number _; do
        at[$number]=$((place++))
    done < <("$apps/index_reader" "$3" "$3" <"$2")
    place=0
    while read -r number _; do
        published=${at[$((number + $4))]:-}
        if [ -n "$published" ] && cmp -s -n $bytes -i $((place * bytes)):$((published * bytes)) "$1" "$2"; then
            equal=$((equal + 1))
        fi
        place=$((place + 1))
    done < <("$apps/index_reader" "$3" "$3" <"$1")
    echo "$equal of $place"
}

wanted_frames=$frames wanted_size=$size

say "pixels of 90 pictures"
frames=150 size=256x256
start pixels
"$cupola" stream - --format raw --published "$ring" >"$out/published.raw" 2>/dev/null &
copier=$!
send pixels --frames 90
receive >"$out/received.raw" &
receiver=$!
ended pixels
wait "$copier" || true
stop "$receiver"
read -r equal _ received < <(same "$out/received.raw" "$out/published.raw" 256 0)
echo "$equal of $received pictures are equal, byte for byte"
if [ "$received" -lt 85 ] || [ "$equal" -ne "$received" ]; then
    fail "pictures differ, or are missing"
fi
read -r equal _ received < <(same "$out/received.raw" "$out/published.raw" 256 1)
[ "$equal" -eq 0 ] || fail "the control: $equal of $received pictures are equal to the next ones"

say "a new size"
moving=$rate,90,320x240
start resized
send resized
receive >"$out/resized.raw" &
receiver=$!
ended resized
stop "$receiver"
bytes=$((320 * 240 * 4))
tail -c $bytes "$out/resized.raw" >"$out/last.raw"
"$apps/index_reader" 320 240 <"$out/last.raw" >"$out/last.reads"
echo "the last picture is number $(cut -d ' ' -f 1 "$out/last.reads"), with 320x240 pixels"
[ "$(cut -d ' ' -f 1 "$out/last.reads")" -gt 120 ] || fail "no pictures of the new size were received"
moving=$rate

say "without a receiver"
start alone
send alone
ended alone
rate_of alone
if [ "$(number alone sent)" -ne 0 ] || [ "$(number alone without_receiver)" -le 100 ]; then
    fail "frames are counted wrongly"
fi

say "a receiver that takes a tenth of a second for each picture"
frames=300
start slow
send slow
receive > >("$apps/index_reader" 256 256 100 >"$out/slow.reads") &
receiver=$!
ended slow
stop "$receiver"
sleep 1
rate_of slow
in_order slow
[ "$(number slow lost)" -gt 50 ] || fail "a slow receiver loses no frames"

say "from the swap to the receiver, $wanted_size, $rate frames in a second, of which $wanted_frames are read"
frames=$wanted_frames size=$wanted_size
start delay
send delay --frames "$frames"
receive > >("$apps/index_reader" "$side" "$side" >"$out/delay.reads") &
receiver=$!
ended delay
stop "$receiver"
sleep 1
times delay

say "the daemon ends"
frames=100 size=256x256
start daemon
send daemon
sleep 1
kill $daemon
status=0
wait "$sender" || status=$?
cat "$out/daemon.log"
if [ $status -ne 1 ] || ! grep -q "PipeWire takes no more pictures" "$out/daemon.log"; then
    fail "exit code $status"
fi
wait "$program" || true
status=0
"$cupola" stream "pipewire:$source" 2>"$out/missing.log" || status=$?
cat "$out/missing.log"
if [ $status -ne 1 ] || ! grep -q XDG_RUNTIME_DIR "$out/missing.log"; then
    fail "exit code $status"
fi
