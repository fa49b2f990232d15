#!/usr/bin/env bash
# Runs a command and says that it goes on, every 20 s (or EVERY_S): still_running.sh LABEL COMMAND...
set -u
label=$1
shift
(
    # Whoever waits for our output or for a lock that we hold waits for the command alone.
    exec 9>&-
    while sleep "${EVERY_S:-20}" >/dev/null 2>&1; do echo "$label: still running (${SECONDS} s)"; done
) &
beat=$!
trap 'kill "$beat"' EXIT
"$@"
