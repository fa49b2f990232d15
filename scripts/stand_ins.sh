#!/usr/bin/env bash
# Builds the messages of test/interfaces into build/stand_ins: stand-ins for those of robots'
# drivers, which no wheel holds. Only tests of the adapters need them; a second call does nothing.
set -Eeuo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
venv=$root/.venv
out=$root/build/stand_ins

main() {
    local key
    exec 9<"${BASH_SOURCE[0]}"
    flock 9 # two calls at once: the second waits
    key=$({ echo "$root"; cat "$venv/.complete"; find test/interfaces -type f | LC_ALL=C sort | xargs sha256sum; } | sha256sum)
    if [ -f "$out/.complete" ] && [ "$(cat "$out/.complete")" = "$key" ]; then
        return
    fi
    echo "stand_ins: building messages for the tests of adapters (a minute or two)"
    rm -rf "$out"
    scripts/still_running.sh stand_ins env PATH="$venv/bin:$PATH" \
        AMENT_PREFIX_PATH="$venv" CMAKE_PREFIX_PATH="$venv" \
        LD_LIBRARY_PATH="$venv/lib" COLCON_HOME="$root/build" \
        MAKEFLAGS="-j$(nproc)" \
        "$venv/bin/colcon" --log-base "$out/log" --log-level error build --merge-install \
        --build-base "$out/build" --install-base "$out/install" --base-paths test/interfaces \
        --cmake-args -DBUILD_TESTING=OFF "-DPython3_EXECUTABLE=$venv/bin/python"
    echo "$key" >"$out/.complete"
}

main
exit
