#!/bin/sh
# Compiles the kernels of GPUs by Mesa's driver for AMD's RDNA 3, without such a GPU, and compares registers, scratch
# memory and occupancy with scripts/shapes/shapes.tsv. More scratch or fewer waves are errors.
#   sh scripts/check_shapes.sh [--write]
# --write writes the table. Needs Mesa's radv, which Debian's mesa-vulkan-drivers contains on x86-64. Other versions of
# Mesa than the table's compile otherwise, so nothing is compared with them.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=software
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"

driver=
for file in /usr/share/vulkan/icd.d/radeon_icd*.json; do driver=$file; done
[ -f "$driver" ] || fail "there is no radeon_icd*.json in /usr/share/vulkan/icd.d: Mesa's driver for AMD is not installed"
rm -rf "$root/target/shapes" # a filter that names no test must not leave old modules to compile
cargo test --quiet --manifest-path "$root/Cargo.toml" --lib kernel::tests::modules_of_gpus
RADV_FORCE_FAMILY=${RADV_FORCE_FAMILY:-gfx1100} VK_DRIVER_FILES=$driver VK_ICD_FILENAMES=$driver NODEVICE_SELECT=1 \
    cargo run --quiet --manifest-path "$root/Cargo.toml" --bin stereotrace-shapes -- \
    "$root/scripts/shapes/shapes.tsv" "$root"/target/shapes/*.wgsl "$@"
