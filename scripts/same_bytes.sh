#!/bin/sh
# Compares, to the bit, what every method makes with what it made at another commit: for changes that may not change a
# picture.
#   sh scripts/same_bytes.sh COMMIT
# Some minutes, of which most is compiling the other commit, once, in target/same-bytes.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
[ $# = 1 ] || { echo "usage: sh scripts/same_bytes.sh COMMIT" >&2; exit 2; }
commit=$(git -C "$root" rev-parse --verify "$1^{commit}")
export STEREOTRACE_ADAPTER="${STEREOTRACE_ADAPTER:-software}"
work=$root/target/same-bytes
other=$work/tree
mkdir -p "$work"
hashes() { # of the tree in a folder, into a file
    (cd "$1" && STEREOTRACE_BYTES=$2 cargo test --quiet --test it -- --ignored bytes::)
}
if [ ! -f "$work/$commit.txt" ]; then
    git -C "$root" worktree remove --force "$other" 2>/dev/null || rm -rf "$other"
    git -C "$root" worktree add --quiet --detach "$other" "$commit"
    CARGO_TARGET_DIR=$work/target hashes "$other" "$work/$commit.part"
    git -C "$root" worktree remove --force "$other"
    mv "$work/$commit.part" "$work/$commit.txt"
fi
hashes "$root" "$work/now.txt"
# The text of a refusal may differ.
for list in "$commit" now; do sed 's/ refused: .*/ refused/' "$work/$list.txt" >"$work/$list.compared"; done
if diff "$work/$commit.compared" "$work/now.compared"; then
    echo "$(wc -l <"$work/now.txt") pictures, all as at $commit"
else
    echo "error: pictures differ from those of $commit" >&2
    exit 1
fi
