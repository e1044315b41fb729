#!/bin/sh
# Runs the tests of first hits, shadows and mirrors with ray queries, on Mesa's software driver. Mesa has them from 25.0
# on. Debian 12 has it in its backports. It is not installed, but unpacked into target/mesa, 11 MB.
#   sh scripts/check_ray_queries.sh [FILTERS OF THE TESTS]
# On a system whose own driver has ray queries:
#   STEREOTRACE_RAY_QUERIES=1 sh scripts/test.sh --test it ray_queries
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=software
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"
have apt-get || fail 'this needs apt-get. With a driver of your own that has ray queries:
    STEREOTRACE_RAY_QUERIES=1 sh scripts/test.sh --test it ray_queries'

mesa=$root/target/mesa
icd=$mesa/lvp_icd.json
if [ ! -f "$icd" ]; then
    rm -rf "$mesa"
    mkdir -p "$mesa/lists/partial"
    say "unpacking Mesa of bookworm-backports into $mesa"
    key=/usr/share/keyrings/debian-archive-keyring.gpg
    echo "deb [signed-by=$key] http://deb.debian.org/debian bookworm-backports main" >"$mesa/backports.list"
    # Lists of packages of its own, so that the system's stay as they are.
    apt() {
        (cd "$mesa" && apt-get -qq -o APT::Sandbox::User=root -o Dir::Etc::sourcelist="$mesa/backports.list" \
            -o Dir::Etc::sourceparts=- -o Dir::State::lists="$mesa/lists" -o Dir::Cache::pkgcache= \
            -o Dir::Cache::srcpkgcache= "$@")
    }
    apt update && apt download mesa-vulkan-drivers || fail 'apt-get could not download mesa-vulkan-drivers of bookworm-backports'
    dpkg -x "$mesa"/mesa-vulkan-drivers_*.deb "$mesa"
    rm -rf "$mesa"/mesa-vulkan-drivers_*.deb "$mesa/lists"
    driver=$(ls "$mesa"/usr/lib/*/libvulkan_lvp.so)
    printf '{"file_format_version": "1.0.0", "ICD": {"library_path": "%s", "api_version": "1.4.305"}}\n' "$driver" >"$icd"
fi

[ $# -gt 0 ] || set -- ray_queries:: watertight::a_million twins::triangles
export VK_DRIVER_FILES="$icd" VK_ICD_FILENAMES="$icd" MESA_SHADER_CACHE_DIR="$mesa/cache"
export STEREOTRACE_ADAPTER=llvmpipe STEREOTRACE_RAY_QUERIES=1
log=$mesa/tests.log
code=0
cargo test --manifest-path "$root/Cargo.toml" --test it -- "$@" >"$log" 2>&1 || code=$?
cat "$log"
if grep -q 'skipped: no ray queries' "$log"; then fail "the driver of $icd has no ray queries"; fi
exit $code
