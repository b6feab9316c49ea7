# shellcheck shell=bash
# Functions that the scripts share. Source this file: it changes to the project's folder.

cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit

# Prints a heading.
say() {
    printf '\n== %s\n' "$*"
}

fail() {
    printf '%s: %s\n' "$(basename "$0")" "$*" >&2
    exit 1
}

# Sets the array `missing` to those of the named Debian packages that are not installed.
find_missing_packages() {
    local package
    missing=()
    for package in "$@"; do
        if [ "$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then
            missing+=("$package")
        fi
    done
}

# announce MINUTES GIGABYTES PACKAGE…: prints what the complete script needs on a machine where nothing is built yet:
# processor time, disk space in target/, and packages.
announce() {
    local minutes=$1 gigabytes=$2 missing free
    shift 2
    find_missing_packages "$@"
    printf 'Takes about %s processor minutes if nothing is built yet (this machine has %s cores), and %s GB of disk.\n' \
        "$minutes" "$(nproc)" "$gigabytes"
    if [ ${#missing[@]} -eq 0 ]; then
        printf 'Debian packages: all %s are installed.\n' $#
    else
        printf 'Debian packages to install: %s of %s, and their dependencies: %s\n' ${#missing[@]} $# "${missing[*]}"
    fi
    free=$(df --output=avail --block-size=1G . | tail -n 1)
    if [ "$free" -lt "$gigabytes" ]; then
        printf 'Warning: only %s GB of this disk are free.\n' "${free// /}"
    fi
}

# Installs those of the named Debian packages that are missing. If none is missing, uses neither network nor apt.
need_packages() {
    local missing
    find_missing_packages "$@"
    if [ ${#missing[@]} -eq 0 ]; then
        return
    fi
    command -v apt-get >/dev/null ||
        fail "these Debian packages are needed and there is no apt-get to install them: ${missing[*]}"
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || fail "run this as root, or install sudo; packages to install: ${missing[*]}"
        as_root=(sudo)
    fi
    "${as_root[@]}" apt-get update
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "${missing[@]}"
}

# Checks for a Rust toolchain. It does not install Debian's, which is too old.
need_cargo() {
    if ! command -v cargo >/dev/null && [ -x "$HOME/.cargo/bin/cargo" ]; then
        PATH="$HOME/.cargo/bin:$PATH"
    fi
    command -v cargo >/dev/null || fail "cargo is missing; install Rust from https://rustup.rs"
}

# start_x_server FOLDER: starts a private X server, which ends with the script, and sets DISPLAY. The server chooses the
# number of its display itself and writes it to a pipe in the folder.
start_x_server() {
    local number pipe=$1/display.$$
    mkfifo "$pipe"
    Xvfb -displayfd 3 -screen 0 1280x1024x24 -nolisten tcp -noreset 3>"$pipe" 2>/dev/null &
    x_server=$!
    trap 'kill $x_server 2>/dev/null || true' EXIT
    read -r number <"$pipe"
    rm "$pipe"
    export DISPLAY=:$number
}

# stop PROCESS: ends a process of this shell, and waits until it has ended.
stop() {
    kill "$1" 2>/dev/null || true
    wait "$1" 2>/dev/null || true
}

# A script queues its steps with add_step and then runs them all, so that the number of steps is always known.
step_titles=()
step_commands=()

# add_step TITLE COMMAND…: queues a step.
add_step() {
    step_titles+=("$1")
    shift
    step_commands+=("${*@Q}")
}

# Runs the queued steps in their order; the first one that fails ends the script.
run_steps() {
    local step count=${#step_titles[@]}
    for ((step = 0; step < count; step++)); do
        say "step $((step + 1)) of $count, elapsed $(elapsed): ${step_titles[step]}"
        eval "${step_commands[step]}"
    done
}

# Prints the time since the script's start as mm:ss.
elapsed() {
    printf '%02d:%02d' $((SECONDS / 60)) $((SECONDS % 60))
}

# processor_minutes FILE: prints the processor time of all that the script ran. FILE is temporary: `times` is not called
# in a subshell, because a subshell has only its own times.
processor_minutes() {
    times >"$1"
    awk 'NR == 2 { split($1, own, "[ms]"); split($2, kernel, "[ms]")
        printf "%.0f processor minutes\n", own[1] + kernel[1] + (own[2] + kernel[2]) / 60 }' "$1"
    rm "$1"
}

# Packages to build the C programs and to run OpenGL without a graphics card.
# shellcheck disable=SC2034 # used by the scripts that source this file
gl_packages=(
    gcc g++ make binutils pkg-config
    libgl-dev libegl-dev libgles-dev libx11-dev libxdamage-dev libglfw3-dev
    libgl1-mesa-dri libglx-mesa0 libegl-mesa0 xvfb
    libvulkan1 libvulkan-dev mesa-vulkan-drivers vulkan-tools vulkan-validationlayers glslang-tools
)
