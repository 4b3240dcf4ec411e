# What .ci/run and .ci/full share: steps with their times, Debian's packages, a display without a screen.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

steps=()
current=
times_file=$(mktemp)

# Sets `cpu` to the user and system seconds of all child processes that have ended. A subshell would say its own.
measure_cpu() {
    times >"$times_file"
    cpu=$(awk -F '[ms ]' 'NR == 2 { print $1 * 60 + $2 + $4 * 60 + $5 }' "$times_file")
}

end_step() {
    [ -n "$current" ] || return 0
    measure_cpu
    steps+=("$(awk -v wall="$((SECONDS - began))" -v cpu="$cpu" -v before="$cpu_before" -v name="$current" \
        'BEGIN { printf "%8d %8.0f  %s", wall, cpu - before, name }')")
    current=
}

# step NAME: ends the step before and begins another one.
step() {
    end_step
    printf '\n== %s\n' "$*"
    current=$*
    began=$SECONDS
    measure_cpu
    cpu_before=$cpu
}

# The table of all steps so far, also when one has failed.
print_steps() {
    end_step
    rm -f "$times_file"
    [ "${#steps[@]}" -gt 0 ] || return 0
    printf '\n%8s %8s  %s\n' seconds 'of CPU' step
    printf '%s\n' "${steps[@]}"
}
trap print_steps EXIT

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

is_installed() { dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null | grep -qx installed; }

# install PACKAGE...: brings those of Debian's packages that are not there.
install() {
    local package missing=()
    for package in "$@"; do
        is_installed "$package" || missing+=("$package")
    done
    [ "${#missing[@]}" -gt 0 ] || return 0
    step "packages: ${missing[*]}"
    as_root apt-get update -qq
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install --yes -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# Mesa's Vulkan driver in software, or nothing.
software_driver() {
    find /usr/share/vulkan/icd.d /usr/local/share/vulkan/icd.d -name 'lvp_icd*.json' 2>/dev/null | head -n 1 || true
}

# on_display COMMAND...: runs it in a virtual display with the software driver.
on_display() {
    local folder server result=0
    folder=$(mktemp -d)
    Xvfb -displayfd 3 -screen 0 1280x720x24 -nolisten tcp -noreset 3>"$folder/display" 2>/dev/null &
    server=$!
    for _ in $(seq 100); do
        [ -s "$folder/display" ] && break
        sleep 0.1
    done
    env -u WAYLAND_DISPLAY DISPLAY=":$(cat "$folder/display")" XDG_RUNTIME_DIR="$folder" \
        WGPU_BACKEND=vulkan VK_DRIVER_FILES="$(software_driver)" VK_ICD_FILENAMES="$(software_driver)" "$@" || result=$?
    kill "$server" 2>/dev/null || true
    wait "$server" 2>/dev/null || true
    rm -rf "$folder"
    return "$result"
}

# What has to be found in tests and not by users.
checked=(--config .ci/checked.toml)

# monkey TIME: a monkey uses the editor for this time, in a window where there is a display and a driver. Its bounds are of memory, threads, files,
# undo and saving; how long frames take depends on the machine and is not judged here.
monkey() {
    local command=(cargo run --release "${checked[@]}" --quiet -- edit scenes/cornell-box-water.xml scenes/materials.xml --monkey "$1" --longest-frame none)
    if command -v Xvfb >/dev/null && [ -n "$(software_driver)" ]; then
        step "the monkey in a window for $1"
        on_display "${command[@]}"
    else
        step "the monkey without a window for $1"
        "${command[@]}" --no-window
    fi
}

# All scripts of the repository, as far as their language can tell without running them.
check_syntax() {
    local script
    git ls-files --stage | awk '$1 == 100755 { print $4 }' | while read -r script; do
        case $(head -n 1 "$script") in
            *python3) python3 - "$script" <<<'import ast, sys; ast.parse(open(sys.argv[1]).read(), sys.argv[1])' ;;
            *bash) bash -n "$script" ;;
            *sh) sh -n "$script" ;;
            *) echo "$script: neither Python nor a shell" >&2; return 1 ;;
        esac
    done
}
