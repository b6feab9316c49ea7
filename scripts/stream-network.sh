# shellcheck shell=bash disable=SC2154
# The part of scripts/stream that sends pictures over the network of this machine. It uses the functions of that
# script. A second ffmpeg receives and decodes them; the reader takes the numbers of the frames from its pixels.

side=$((side < 512 ? side : 512)) size=${side}x$side port=$((20000 + $$ % 20000)) status=0

# is_open: true if a program of this machine waits at the port.
is_open() {
    grep -qs ":$(printf %04X "$port") " /proc/net/tcp /proc/net/tcp6 /proc/net/udp /proc/net/udp6
}

# over NAME RECEIVED SENT [OPTION…]: sends pictures to the address SENT, and reads them from the address RECEIVED,
# with options of the receiver. PORT stands for a port.
over() {
    local name=$1 received=$2 sent=$3 receiver reader
    shift 3
    port=$((port + 2))
    if ! grep -qx " *${name%-*}" <<<"$protocols"; then
        echo "$name: left out, this ffmpeg does not have it"
        return
    fi
    rm -f "$out/pictures"
    mkfifo "$out/pictures"
    "$apps/index_reader" "$side" "$side" <"$out/pictures" >"$out/$name.reads" &
    reader=$!
    ffmpeg -nostdin -v error -probesize 4096 -analyzeduration 0 -fflags nobuffer -flags low_delay "$@" \
        -i "${received/PORT/$port}" -fps_mode passthrough -f rawvideo -pix_fmt rgba -y "$out/pictures" \
        2>"$out/$name.receiver" &
    receiver=$!
    for _ in {1..200}; do
        ! is_open || break
        sleep 0.05
    done
    start "$name"
    "$cupola" stream "${sent/PORT/$port}" --published "$ring" --frames "$frames" --stats "$out/$name.json" \
        2>"$out/$name.log" || { echo "$name: cupola stream failed; see $out/$name.log"; status=1; }
    wait "$program" || true
    # UDP and RIST do not tell the receiver that the pictures end. With RIST ffmpeg does not end by SIGTERM, either.
    for _ in {1..30}; do
        kill -0 $receiver 2>/dev/null || break
        sleep 0.1
    done
    kill -KILL $receiver 2>/dev/null || true
    wait $receiver 2>/dev/null || true
    wait $reader || true
    times "$name" || { status=1; return; }
    in_order "$name" >"$out/$name.order" || { cat "$out/$name.order"; status=1; }
    # The receiver joins with a key frame: there is one after each 60 pictures.
    awk -v name="$name" -v frames="$frames" -v lost="$(jq .lost "$out/$name.json")" '
        NR == 1 { first = $1 } NR > 1 { gaps += $1 - before - 1 } { before = $1 } END {
            printf "%-22s pictures %d to %d, %d between them are missing, %d were counted as lost\n", name, first,
                before, gaps, lost
            exit first > 130 || before < frames || gaps > lost
        }' "$out/$name.reads" || { echo "$name: pictures are missing; see $out/$name.receiver"; status=1; }
}

say "over the network of this machine, H.264, $size, $rate frames in a second, of which $frames are sent"
protocols=$(ffmpeg -v quiet -protocols | sed -n '/^Input:/,/^Output:/p')
over srt 'srt://127.0.0.1:PORT?mode=listener' 'srt://127.0.0.1:PORT?mode=caller' -f mpegts
over rist 'rist://@127.0.0.1:PORT' 'rist://127.0.0.1:PORT' -f mpegts
over udp 'udp://127.0.0.1:PORT?fifo_size=100000&overrun_nonfatal=1' 'udp://127.0.0.1:PORT?pkt_size=1316' -f mpegts
over tcp 'tcp://127.0.0.1:PORT?listen=1' 'tcp://127.0.0.1:PORT' -f mpegts
over rtmp 'rtmp://127.0.0.1:PORT/live/dome' 'rtmp://127.0.0.1:PORT/live/dome' -listen 1 -f flv
[ $status -eq 0 ] || fail "pictures were not received as they should be"
