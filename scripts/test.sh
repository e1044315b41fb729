#!/bin/sh
# Runs every test (unit, integration, documentation) on the software adapter, installing it where there is none.
#   sh scripts/test.sh [SCENES] [ARGUMENTS OF cargo test, from one that begins with a dash on]
# SCENES is a folder of unpacked scenes; without it the tests look into target/scenes.
# STEREOTRACE_ADAPTER, where it is set, chooses another adapter by a part of its name.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
export STEREOTRACE_ADAPTER="${STEREOTRACE_ADAPTER:-software}"
# Tests compile more than they trace. Without its optimisations, llvmpipe takes a sixth to a quarter less time for both.
export GALLIVM_PERF="${GALLIVM_PERF-nopt}"
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
if [ $# -gt 0 ] || ! command -v flock >/dev/null; then exec cargo test --manifest-path "$root/Cargo.toml" "$@"; fi

# A test program has one device at work and waits for it half of its time: two of them at once take two cores well. Their output comes whole,
# one after the other, and one that fails stops no other.
cd "$root"
mkdir -p target
programs=target/test-programs
: >target/test-skipped
cargo test --no-run --message-format=json-render-diagnostics >"$programs.json"
sed -n 's/.*"manifest_path":"\([^"]*\)\/Cargo.toml".*"profile":{[^}]*"test":true}.*"executable":"\([^"]*\)".*/\1\n\2/p' "$programs.json" >"$programs"
[ -s "$programs" ] || fail 'cargo built no test program'
# shellcheck disable=SC2016 # a text for another shell
one='
log=$(mktemp)
code=0
(cd "$1" && "$2") >"$log" 2>&1 || code=$?
flock "$0" sh -c "printf \"\n     Running %s\n\" \"$2\"; cat \"$log\"; sed -n \"/^skipped: /p\" \"$log\" >>target/test-skipped"
rm -f "$log"
[ $code = 0 ] || printf "error: test program %s failed, exit status %d\n" "$2" $code >&2
exit $((code != 0))'
xargs -d '\n' -P 2 -n 2 sh -c "$one" "$programs.json" <"$programs"
cargo test --doc
sort target/test-skipped | uniq -c
echo "tests: $(wc -l <target/test-skipped) skipped"
