# shellcheck shell=bash
# Tests of the controls of the page of `cupola serve`. Source this file after browser.sh; scripts/page has the functions
# that it calls.

# value_of KEY: prints the value of a key in the rig, as JSON.
value_of() {
    ctl get "$1" | jq --compact-output .value
}

# eventually NAME WANTED COMMAND…: like expect, for what a command prints; waits for it up to 5 seconds.
eventually() {
    local name=$1 wanted=$2 is='' _
    shift 2
    for _ in {1..25}; do
        is=$("$@")
        [ "$is" != "$wanted" ] || break
        sleep 0.2
    done
    same "$name" "$is" "$wanted"
}

# same NAME VALUE WANTED: a line of the table; the run fails if the value is another one.
same() {
    if [ "$2" = "$3" ]; then
        row "$1" "$2"
    else
        row "$1" "$2  WRONG, expected: $3"
        failures=$((failures + 1))
    fi
}

# choose SELECT VALUE: chooses a value as the mouse does.
choose() {
    # shellcheck disable=SC2016 # JavaScript
    in_page 'const list = document.querySelector(given[0]); list.value = given[1]; setTimeout(() => list.onchange());' "$1" "$2" >/dev/null
    sleep 0.5
}

# row_of KEY CONTROL: selector of a control of a key.
row_of() {
    printf '[data-key="%s"] %s' "$1" "$2"
}

# open_table GROUP…: opens sections of keys.
open_table() {
    # shellcheck disable=SC2016 # JavaScript
    in_page 'for (const group of given) {
            if (typeof group !== "string") continue;
            document.querySelector(`[data-group="${group}"]`).open = true;
            await new Promise(done => setTimeout(done, 100));
        }' "$@" >/dev/null
}

# Drags in the picture: the aim and the place of a projector, the viewer's place, and the panel.
drags() {
    local before after version
    click '#labels span'
    same "a click on the label of a projector selects it" "$(in_page 'return cupola.dome.selected;')" '"front"'
    version=$(in_page 'return cupola.state.version;')
    before=$(in_page 'return cupola.dome.orbit.yaw;')
    drag_by '#view' -200 60 80 0
    after=$(in_page 'return cupola.dome.orbit.yaw;')
    expect "a drag with Look turns the picture" "$before -> $after" "sqrt(($before - $after - 0.48) ^ 2) < 0.01"
    sleep 1.5
    same "  and changes nothing" "$(in_page 'return cupola.state.version;')" "$version"
    click '[data-drag=aim]'
    drag_by '#view' -200 60 60 -40
    eventually "a drag with Aim by 60, 40 pixels: yaw" 6 value_of output.front.yaw
    eventually "  pitch" 39 value_of output.front.pitch
    click '#undo'
    eventually "  Undo takes back the whole drag: yaw" 0 value_of output.front.yaw
    eventually "  pitch" 35 value_of output.front.pitch
    click '[data-drag=move]'
    drag_by '#view' -200 60 60 -40
    sleep 1
    after=$(value_of output.front.position)
    expect "a drag with Move: new place" "$after" \
        "$(jq '(.[0] * .[0] + (.[2] - 4.6) * (.[2] - 4.6) | sqrt | . > 1 and . < 2 | if . then 1 else 0 end)' <<<"$after") && $(jq '.[1]' <<<"$after") == -0.1"
    drag_by '#view' -200 60 0 -40 $'\uE008'
    sleep 1
    before=$after after=$(value_of output.front.position)
    expect "  with Shift it goes up" "$after" "$(jq '.[1]' <<<"$after") > 0.5 && $(jq '.[0]' <<<"$after") == $(jq '.[0]' <<<"$before")"
    click '[data-drag=viewer]'
    drag_by '#view' -200 60 20 0
    sleep 1
    after=$(value_of viewer.position)
    expect "a drag with Viewer: place" "$after" "$(jq '.[0] * .[0] + .[2] * .[2] | sqrt' <<<"$after") > 0.3 && $(jq '.[1]' <<<"$after") == 0"
    before=$(in_page 'return probe.marked();')
    click '[data-drag=panel]'
    drag_by '#view' -200 60 -100 -40
    eventually "a drag with Panel: yaw" -10 value_of overlay.yaw
    eventually "  pitch" 24 value_of overlay.pitch
    after=$(in_page 'return probe.marked();')
    expect "  pixels of its outline and of the projector" "$before -> $after" "$after > $before + 100"
    click '[data-drag=look]'
    for _ in 1 2 3 4; do click '#undo'; done
    eventually "four clicks on Undo: viewer" null value_of viewer.position
    eventually "  and projector" '[0,-0.1,4.6]' value_of output.front.position
    click '#redo'
    eventually "a click on Redo: the projector is moved again" 1 moved_away
    click '#undo'
}

moved_away() {
    value_of output.front.position | jq 'if .[2] != 4.6 then 1 else 0 end'
}

# Places of the eye, and what else the dome shows.
overlays() {
    local found kind
    found=$(in_page 'return [cupola.dome.camera().eye, probe.litPixels()];')
    click '[data-place=seat]'
    same "a click on Seat: the eye is at" "$(in_page 'return cupola.dome.camera().eye;' | jq --compact-output .)" '[0,0,0]'
    expect "  pixels that are lit" "$(in_page 'return probe.litPixels();')" "$(in_page 'return probe.litPixels();') > 0.1"
    choose '#seat' left
    same "the seat on the left: the eye is at" "$(in_page 'return cupola.dome.camera().eye;' | jq --compact-output .)" '[-2.5,0,0]'
    choose '#seat' viewer
    click '[data-place=outside]'
    same "a click on Outside: the eye is where it was" "$(in_page 'return cupola.dome.camera().eye;' | jq --compact-output .)" "$(jq --compact-output '.[0]' <<<"$found")"
    for kind in coverage light density resolution; do
        choose '#overlay' $kind
        found=$(in_page 'return probe.values();')
        row "$kind: least, median, greatest; legend" "$(jq --raw-output '"\(.least), \(.median), \(.greatest); \(.legend)"' <<<"$found")"
        same "  the painted dome has its colors" "$(jq .isPainted <<<"$found")" true
        case $kind in
        coverage) same "  one and two outputs light the dome" "$(jq --compact-output .different <<<"$found")" '[1,2]' ;;
        light) expect "  the light is even" "$(jq .median <<<"$found")" "sqrt(($(jq .median <<<"$found") - 1) ^ 2) < 0.02" ;;
        density) expect "  the views have enough texels" "$(jq .median <<<"$found")" "$(jq .median <<<"$found") > 0.7" ;;
        # 2560 pixels for 118 degrees are 13.4 to 50 pixels in a degree from the lens, the viewer is farther from one half.
        resolution) expect "  pixels in a degree" "$(jq .median <<<"$found")" "$(jq .median <<<"$found") > 10 && $(jq .median <<<"$found") < 60" ;;
        esac
    done
    found=$(in_page 'cupola.dome.values = null; return (await probe.values()).isPainted;')
    same "  control: the picture has other colors" "$found" false
    choose '#overlay' error
    found=$(in_page 'return probe.errorFree();')
    expect "error from the viewer's seat: part without error" "$found" "$found > 0.98"
    choose '#seat' left
    found=$(in_page 'return probe.errorFree();')
    expect "  from the left" "$found" "$found < 0.5"
    choose '#seat' viewer
    choose '#overlay' picture
}

# The search, the tab of outputs, and other rigs.
tabs() {
    local found
    type_in '#find' gamma
    found=$(in_page 'return probe.shownKeys();')
    same "keys that a search for gamma shows" "$(jq --compact-output . <<<"$found")" '["output.front.blend.gamma","output.back.blend.gamma"]'
    type_in '#find' ''
    found=$(in_page 'return probe.shownKeys();')
    expect "  without a search" "$(jq length <<<"$found") keys" "$(jq 'map(select(test("gamma"))) | length' <<<"$found") == 1 && $(jq length <<<"$found") > 20"
    click '[data-tab=outputs]'
    in_page 'return probe.settle();' >/dev/null
    found=$(in_page 'return probe.outputs();')
    same "outputs in their tab" "$(jq --compact-output 'map(.name)' <<<"$found")" '["front","back"]'
    expect "  brightness of their pictures" "$(jq --compact-output 'map(.mean)' <<<"$found")" "$(jq 'map(.mean) | min' <<<"$found") > 0.3"
    click '#outputs [data-name=back]'
    same "  a click selects" "$(in_page 'return cupola.dome.selected;')" '"back"'
    click '[data-tab=rig]'
}

# Text, lists, keys and tables that the file lacks, and removing keys.
keys() {
    local text
    text=$(in_page 'return cupola.keys.map(key => key.key);' | jq --raw-output '.[]' | sort | uniq --repeated)
    same "keys that have two controls" "$text" ''
    same "keys whose controls cannot be opened" "$(in_page 'return probe.keysWithoutControl();' | jq --compact-output .)" '["passthrough"]'
    open_table '' output.front views camera window
    type_in "$(row_of name input)" 'Dome "of" mine'
    eventually "text in a field: name of the rig" '"Dome \"of\" mine"' value_of name
    type_in "$(row_of name input)" ''
    eventually "  the empty field removes it" null value_of name
    type_in "$(row_of output.front.keystone textarea)" '[[-1, -1], [1, -1'
    eventually "a list that is no TOML: the reason is beside it" 1 reasons output.front.keystone 'not valid TOML'
    type_in "$(row_of output.front.keystone textarea)" '[[-1, -1], [1, -1], [1, 1]]'
    eventually "  of three corners" 1 reasons output.front.keystone 'four corners'
    same "  the rig has none" "$(ctl get output.front.keystone | jq .toml)" null
    type_in "$(row_of output.front.keystone textarea)" '[[-1, -1], [1, -1], [0.9, 1], [-1, 1]]'
    eventually "  of four: the rig has it" '"[[-1, -1], [1, -1], [0.9, 1], [-1, 1]]"' toml_of output.front.keystone
    eventually "  and the reason is gone" 0 reasons output.front.keystone .
    click "$(row_of output.front.keystone .drop)"
    eventually "a click on × removes it" null toml_of output.front.keystone
    eventually "  Undo brings it back" 1 undone output.front.keystone
    expect "views.cells has lines in its field" "$(in_page 'return document.querySelector("[data-key=\"views.cells\"] textarea").value.split("\n").length;')" \
        "$(in_page 'return document.querySelector("[data-key=\"views.cells\"] textarea").value.split("\n").length;') == 8"
    type_in "$(row_of camera.zoom 'input[type=number]')" ''
    eventually "an empty field of a number removes it" null value_of camera.zoom
    click "$(row_of output.front.fov .drop)"
    eventually "what the rig needs is not removed" 1 reasons output.front.fov 'is missing'
    same "a table that the file lacks" "$(table_state window)" 'not in the file'
    type_in "$(row_of window.swap_interval 'input[type=number]')" 1
    eventually "  is there when one of its keys is set" '' table_state window
    click "$(row_of window.swap_interval .drop)"
    eventually "  and not when it is removed" 'not in the file' table_state window
    open_table output.front.fisheye
    type_in "$(row_of output.front.fisheye.aperture 'input[type=number]')" 170
    eventually "a key of another lens takes the place of fov" null value_of output.front.fov
    click '#undo'
    eventually "  and Undo brings it back" '[118,92.26]' value_of output.front.fov
    in_page 'document.getElementById("several").open = true;
        document.getElementById("several-lines").value = "output.front.kind = \"domemaster\"\noutput.front.fov =\noutput.front.position=\noutput.front.yaw=\noutput.front.pitch=\noutput.front.roll=\noutput.front.keystone=\noutput.front.blend.overlap=";' >/dev/null
    click '#several-apply'
    eventually "several changes at once: another kind" '"domemaster"' value_of output.front.kind
    click '#undo'
    eventually "  Undo" '"projector"' value_of output.front.kind
}

toml_of() {
    ctl get "$1" | jq .toml
}

# reasons KEY TEXT: number of reasons beside a key that have this text.
reasons() {
    in_page "return document.querySelector('$(row_of "$1" .wrong)').textContent;" | jq --arg text "$2" 'if test($text) then 1 else 0 end'
}

# table_state GROUP: what the heading of a table says.
table_state() {
    in_page "return document.querySelector('[data-group=\"$1\"] small').textContent;" | jq --raw-output .
}

undone() {
    [ "$(toml_of "$1")" != null ] || click '#undo'
    toml_of "$1" | jq 'if . == null then 0 else 1 end'
}

# Opens another rig while this one has changes that are not saved, and comes back.
rigs() {
    local program
    program=$(ctl stats | jq .program.process)
    # shellcheck disable=SC2016 # JavaScript
    choose '#rigs' fisheye
    driver POST alert/dismiss >/dev/null
    eventually "another rig, not without the changes: outputs" '["front","back"]' rig_outputs
    choose '#rigs' fisheye
    driver POST alert/accept >/dev/null
    eventually "another rig: its outputs" '["dome"]' rig_outputs
    eventually "  sections of the page" '["dome"]' in_page_sections
    same "  the program is the same process" "$(ctl stats | jq .program.process)" "$program"
    choose '#rigs' "${work:?}/dome.toml"
    eventually "the first rig again: its outputs" '["front","back"]' rig_outputs
    zoom_of 6
}

rig_outputs() {
    ctl stats | jq --compact-output .rig.outputs
}

in_page_sections() {
    in_page 'return [...document.querySelectorAll("#keys > details")].map(one => one.dataset.group).filter(one => one.startsWith("output.")).map(one => one.slice(7));' | jq --compact-output .
}

# All tests of this file, on a page of their own.
controls() {
    local found
    open
    drags
    overlays
    tabs
    keys
    rigs
    # The page without a control.
    found=$(in_page 'showKeys = () => {}; rows.get("camera.zoom").row.remove(); return probe.keysWithoutControl();')
    same "control: keys whose controls cannot be opened" "$(jq --compact-output sort <<<"$found")" '["camera.zoom","passthrough"]'
    open
}
