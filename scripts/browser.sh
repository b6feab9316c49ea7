# shellcheck shell=bash
# Functions for a headless Chromium, controlled by its WebDriver. Source this file after common.sh. Needs the packages
# below.

# shellcheck disable=SC2034 # used by the scripts that source this file
browser_packages=(chromium chromium-driver curl jq)

# start_browser FOLDER WIDTH HEIGHT [phone]: starts a browser whose pages have this size, perhaps that of a phone.
# stop_browser ends it. If browser_nice is set, it is a command that starts the browser, such as "nice -n 19".
start_browser() {
    local folder=$1 port=0 answer phone={}
    [ "${4-}" != phone ] || phone="{ \"mobileEmulation\": { \"deviceMetrics\": { \"width\": $2, \"height\": $3, \"pixelRatio\": 2, \"touch\": true } } }"
    # The driver prints the port that it has chosen.
    # shellcheck disable=SC2086 # several words
    # It is read before the driver may have begun.
    : >"$folder/driver.txt"
    ${browser_nice-} chromedriver --port=0 >"$folder/driver.txt" 2>&1 &
    browser_driver=$!
    for _ in {1..100}; do
        port=$(sed -n 's/.*started successfully on port \([0-9]*\).*/\1/p' "$folder/driver.txt")
        [ -z "$port" ] || break
        sleep 0.1
    done
    [ -n "$port" ] || fail "chromedriver did not start: $(cat "$folder/driver.txt")"
    browser=http://127.0.0.1:$port
    # Chromium's sandbox refuses to run as root, and this may run as root; the page is trusted. As Chromium does by itself
    # without a graphics card, SwiftShader draws WebGL, and the rest of the page is put together without it.
    answer=$(driver POST session "$(jq --null-input --arg size "$2,$3" --argjson phone "$phone" '{ capabilities: { alwaysMatch: { "goog:chromeOptions": ($phone + { args: [
        "--headless=new", "--no-sandbox", "--hide-scrollbars", "--use-angle=swiftshader-webgl", "--enable-unsafe-swiftshader", "--window-size=" + $size ] }), timeouts: { script: 3600000 } } } }')")
    browser=$browser/session/$(jq --raw-output .sessionId <<<"$answer")
    [ "${4-}" != phone ] || return 0
    # The window contains bars beside the page.
    answer=$(driver POST execute/sync '{ "script": "return outerHeight - innerHeight", "args": [] }')
    driver POST window/rect "{ \"width\": $2, \"height\": $(($3 + answer)) }" >/dev/null
}

stop_browser() {
    [ -n "${browser_driver-}" ] || return 0
    (driver DELETE "") >/dev/null 2>&1 || true
    stop "$browser_driver"
    browser_driver=
}

# driver METHOD PATH [JSON]: sends a command to the driver, and prints the value of its answer.
driver() {
    local answer
    answer=$(curl --silent --noproxy '*' --max-time 3700 --request "$1" --data "${3:-{\}}" "$browser${2:+/$2}")
    jq --exit-status '.value | if type == "object" and has("error") then error(.message) else true end' \
        <<<"$answer" >/dev/null || fail "the browser: $answer"
    jq '.value' <<<"$answer"
}

# open_page ADDRESS
open_page() {
    # If only the part behind # changes, the browser does not load the page again.
    driver POST url '{ "url": "about:blank" }' >/dev/null
    driver POST url "$(jq --null-input --arg url "$1" '{ url: $url }')" >/dev/null
}

# in_page SCRIPT [ARGUMENT…]: runs the body of an asynchronous function in the page, and prints what it returns as JSON.
in_page() {
    local script=$1
    shift
    driver POST execute/async "$(jq --null-input --arg script "const done = arguments[arguments.length - 1], given = arguments;
        (async () => { $script })().then(value => done({ value }), error => done({ failed: String(error) }));" \
        '{ script: $script, args: $ARGS.positional }' --args "$@")" |
        jq 'if has("failed") then error(.failed) else .value end'
}

# click SELECTOR: clicks in the middle of an element.
click() {
    click_at "$1" 0.5
}

# click_at SELECTOR PART [touch]: clicks at a part of the element's width, or touches it there.
click_at() {
    local element offset
    element=$(element_of "$1")
    # shellcheck disable=SC2016 # JavaScript
    offset=$(in_page 'const box = document.querySelector(given[0]); box.scrollIntoView({ block: "center" });
        return Math.round((given[1] - 0.5) * (box.clientWidth - 2));' "$1" "$2")
    driver POST actions "{ \"actions\": [{ \"type\": \"pointer\", \"id\": \"pointer\", \"parameters\": { \"pointerType\": \"${3-mouse}\" }, \"actions\": [
        { \"type\": \"pointerMove\", \"duration\": 0, \"origin\": { \"element-6066-11e4-a52e-4f735466cecf\": $element }, \"x\": $offset, \"y\": 0 },
        { \"type\": \"pointerDown\", \"button\": 0 }, { \"type\": \"pointerUp\", \"button\": 0 }] }] }" >/dev/null
}

# element_of SELECTOR: prints the driver's reference of an element, as JSON.
element_of() {
    driver POST element "$(jq --null-input --arg value "$1" '{ using: "css selector", value: $value }')" | jq '.[]'
}

# type_in SELECTOR TEXT: replaces the text of a field by keys of the keyboard, and presses Enter.
type_in() {
    local element clear=$'\uE009a\uE009\uE017' enter=$'\uE007'
    element=$(element_of "$1" | jq --raw-output .)
    driver POST "element/$element/value" "$(jq --null-input --arg text "$clear$2$enter" '{ text: $text }')" >/dev/null
}

# drag_by SELECTOR X Y RIGHT DOWN [KEY]: presses the button of the mouse at X, Y from an element's middle, moves it in
# four steps, and lets it go; with a key of the keyboard held.
drag_by() {
    local moves='' step keys=''
    for step in 1 2 3 4; do
        moves+=", { \"type\": \"pointerMove\", \"duration\": 30, \"origin\": \"pointer\", \"x\": $(($4 / 4)), \"y\": $(($5 / 4)) }"
    done
    [ -z "${6-}" ] || keys=", { \"type\": \"key\", \"id\": \"keys\", \"actions\": [{ \"type\": \"keyDown\", \"value\": \"$6\" }] }"
    driver POST actions "{ \"actions\": [{ \"type\": \"pointer\", \"id\": \"pointer\", \"parameters\": { \"pointerType\": \"mouse\" }, \"actions\": [
        { \"type\": \"pointerMove\", \"duration\": 0, \"origin\": { \"element-6066-11e4-a52e-4f735466cecf\": $(element_of "$1") }, \"x\": $2, \"y\": $3 },
        { \"type\": \"pointerDown\", \"button\": 0 }$moves, { \"type\": \"pointerUp\", \"button\": 0 }] }$keys] }" >/dev/null
    (driver DELETE actions) >/dev/null
}

# screenshot FILE
screenshot() {
    driver GET screenshot | jq --raw-output . | base64 --decode >"$1"
}
