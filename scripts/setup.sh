#!/usr/bin/env bash
# Builds .venv from requirements.txt and the ROS 2 workspace into install/.
#
# Each step leaves a stamp when it is whole, keyed on all that it was made from; a step without
# a fresh stamp starts anew. So a second call does nothing, and an interrupted one is never taken
# for done. PYTHON names the interpreter to use.
set -Eeuo pipefail
shopt -s nullglob
trap 'echo "setup: stopped; correct what is said above, then call make setup again" >&2' ERR

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
venv=$root/.venv

# What is sourced in the calling shell must not leak into the build.
unset AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH LD_LIBRARY_PATH PYTHONHOME PYTHONPATH
unset ROS_DISTRO ROS_VERSION ROS_PYTHON_VERSION _ROS_WHEELS_BOOTSTRAP_COMPLETE
unset COLCON_DEFAULTS_FILE MAKEFLAGS MFLAGS MAKELEVEL PYTHONDONTWRITEBYTECODE VIRTUAL_ENV

fail() {
    echo "setup: $*" >&2
    exit 1
}

# Prints why an interpreter cannot be used, or nothing.
unfit() {
    "$1" - <<'END' 2>/dev/null || echo "no working Python 3; sudo apt install python3 python3-venv python3-dev"
import os, sys, sysconfig
version = "%d.%d" % sys.version_info[:2]
if not (3, 11) <= sys.version_info[:2] <= (3, 13):
    print("Python 3.11 to 3.13 is needed, %s is %s; install one and call make setup PYTHON=python3.12"
          % (sys.executable, version))
else:
    try:
        import ensurepip, venv
    except ImportError:
        print("the venv module is missing; sudo apt install python%s-venv" % version)
    else:
        if not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")):
            print("the headers of Python are missing; sudo apt install python%s-dev" % version)
END
}

find_python() {
    local candidate problem first_problem="" candidates=(python3 python3.12 python3.13 python3.11)
    [ -z "${PYTHON:-}" ] || candidates=("$PYTHON")
    for candidate in "${candidates[@]}"; do
        problem=$(unfit "$candidate")
        if [ -z "$problem" ]; then
            echo "$candidate"
            return
        fi
        first_problem=${first_problem:-$problem}
    done
    fail "$first_problem"
}

check_machine() {
    [ "$(uname -s)-$(uname -m)" = Linux-x86_64 ] ||
        fail "the ROS 2 wheels are for Linux on x86-64; elsewhere use an apt installation of ROS 2 Jazzy"
    local tool
    for tool in "${CXX:-c++}" "${CC:-cc}" make; do
        tool=${tool%% *} # without options
        command -v "$tool" >/dev/null || fail "$tool is missing; sudo apt install build-essential"
    done
}

install_packages() {
    local python
    check_machine
    python=$(find_python) || exit 1
    echo "setup: installing packages into .venv"
    rm -rf build install log
    "$python" -m venv --clear "$venv"
    scripts/still_running.sh setup scripts/install_lock.sh "$venv" requirements.txt
    "$venv/bin/python" scripts/fix_ros_wheels.py
}

colcon_build() { # folders...
    scripts/still_running.sh setup env PATH="$venv/bin:$PATH" \
        AMENT_PREFIX_PATH="$venv" CMAKE_PREFIX_PATH="$venv" \
        LD_LIBRARY_PATH="$venv/lib" COLCON_HOME="$root/build" MAKEFLAGS="-j$(nproc)" \
        "$venv/bin/colcon" --log-level error build --merge-install --base-paths "$@" \
        --cmake-args -DBUILD_TESTING=OFF "-DPython3_EXECUTABLE=$venv/bin/python"
}

build_messages() {
    echo "setup: building the ROS 2 messages into install/ (about a minute)"
    rm -rf build install log
    colcon_build shoecal_msgs
    # They are found from .venv without sourcing anything.
    ln -sfnr install/lib/libshoecal_msgs__*.so "$venv/lib/"
    ln -sfnr install/lib/python3.*/site-packages/shoecal_msgs "$venv"/lib/python3.*/site-packages/
}

build_python_packages() {
    echo "setup: building the Python packages into install/"
    # A path entry, not an import hook: else the folder shoecal_core/ of the checkout comes first.
    "$venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-deps \
        --no-build-isolation --use-pep517 --config-settings editable_mode=compat \
        --editable shoecal_core --editable shoecal_ros
    colcon_build shoecal_core shoecal_ros
    "$venv/bin/python" -c 'import rclpy, shoecal_core, shoecal_msgs.msg, shoecal_ros'
}

# Runs a step unless its stamp says that it is whole and made from just these files.
step() { # name stamp files...
    local name=$1 stamp=$2 key
    shift 2
    key=$({ echo "$root"; sha256sum "$@"; } | sha256sum)
    if ! [ -f "$stamp" ] || [ "$(cat "$stamp")" != "$key" ]; then
        rm -f "$stamp"
        "$name"
        echo "$key" >"$stamp"
    fi
}

files_of() { # folder...
    find "$@" -type f -not -name '*.pyc' | LC_ALL=C sort
}

main() {
    local messages config
    exec 9<"${BASH_SOURCE[0]}"
    flock 9 # two calls at once: the second waits

    [ -x "$venv/bin/python" ] || rm -f "$venv/.complete"
    step install_packages "$venv/.complete" requirements.txt \
        scripts/{setup.sh,install_lock.sh,fix_ros_wheels.py}

    mapfile -t messages < <(files_of shoecal_msgs)
    step build_messages "$root/install/.messages" "$venv/.complete" "${messages[@]}"

    mapfile -t config < <(files_of config)
    step build_python_packages "$root/install/.complete" "$root/install/.messages" "${config[@]}" \
        shoecal_ros/launch/*.launch.py shoecal_ros/{rviz,foxglove,plotjuggler}/* \
        shoecal_core/{package.xml,setup.cfg,setup.py} shoecal_ros/{package.xml,setup.cfg,setup.py}
}

main # read to here before anything runs: the script may be replaced meanwhile
exit
