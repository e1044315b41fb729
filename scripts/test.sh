#!/bin/sh
# Runs every test (unit, integration, documentation) on the software adapter, installing it where there is none.
#   sh scripts/test.sh [SCENES] [ARGUMENTS OF cargo test, from one that begins with a dash on]
# SCENES is a folder of unpacked scenes; without it the tests look into target/scenes.
# STEREOTRACE_ADAPTER, where it is set, chooses another adapter by a part of its name.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
export STEREOTRACE_ADAPTER="${STEREOTRACE_ADAPTER:-software}"
if [ "$STEREOTRACE_ADAPTER" = software ]; then adapter=software; else adapter=any; fi
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"

case ${1-} in
"" | -*) ;;
*)
    [ -d "$1" ] || fail "no folder of scenes at '$1'; usage: sh scripts/test.sh [SCENES] [ARGUMENTS OF cargo test]"
    STEREOTRACE_SCENES=$(CDPATH='' cd -- "$1" && pwd)
    export STEREOTRACE_SCENES
    shift
    ;;
esac
echo "tests: adapter rule STEREOTRACE_ADAPTER=$STEREOTRACE_ADAPTER, scenes from ${STEREOTRACE_SCENES:-target/scenes if it is there}"
exec cargo test --manifest-path "$root/Cargo.toml" "$@"
