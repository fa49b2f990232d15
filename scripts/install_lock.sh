#!/usr/bin/env bash
# Installs a lock file into a virtual environment as it is: install_lock.sh VENV LOCK
#
# The lock file is whole, so nothing is resolved: a release of tomorrow changes nothing. uv, pinned
# like all else, needs an eighth of pip's time. pip installs the same files where it is configured
# with an index of its own, and where uv cannot (a proxy that only pip knows).
set -Eeuo pipefail

python=$1/bin/python lock=$2
tools=$(dirname "${BASH_SOURCE[0]}")/../requirements.txt
pip=("$python" -m pip --disable-pip-version-check)
as_locked=(--quiet --no-deps --require-hashes)
export UV_LINK_MODE=copy # setup.sh edits what is installed; uv's cache must not change with it

# Prints the entry of a package in the project's lock file.
locked() {
    sed -n "/^$1==/,/[^\\]\$/p" "$tools"
}

# Source packages are built with the locked setuptools, not with the newest.
{ locked setuptools && locked uv; } >"$1/tools.txt"
"${pip[@]}" install "${as_locked[@]}" --only-binary :all: --requirement "$1/tools.txt"
if ! "${pip[@]}" config list | grep -q '\.index-url='; then
    "$1/bin/uv" pip install --python "$python" --no-build-isolation "${as_locked[@]}" \
        --requirement "$lock" && exit
    echo "install_lock: uv failed, see above; trying pip" >&2
fi
"${pip[@]}" install "${as_locked[@]}" --no-build-isolation --use-pep517 --requirement "$lock"
