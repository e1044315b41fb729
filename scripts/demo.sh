#!/bin/sh
# Renders a stereo pair and its anaglyph on whatever adapter is there, installing a software one where there is none.
#   sh scripts/demo.sh [COMMAND AND ARGUMENTS OF stereotrace, such as --help]
# Without arguments: render, which is the built-in hall, into out/. Paths are relative to where you are, not to the
# repository. STEREOTRACE_PROFILE is a profile of cargo; release by default. STEREOTRACE_COMMAND is a command that is
# built already.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=any
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"

[ $# -gt 0 ] || set -- render
[ -z "${STEREOTRACE_COMMAND-}" ] || exec "$STEREOTRACE_COMMAND" "$@"
exec cargo run --profile "${STEREOTRACE_PROFILE:-release}" --manifest-path "$root/Cargo.toml" --package stereotrace-cli -- "$@"
