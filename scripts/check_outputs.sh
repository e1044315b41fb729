#!/bin/sh
# Writes pairs of built-in scenes in every format (examples/ground_truth.rs) and has other programs' readers check each file.
#   sh scripts/check_outputs.sh
# Needs Python 3.11 or newer, which it installs with its venv where apt-get can, and the Python package registry once: OpenCV, OpenEXR,
# Pillow, NumPy and FFmpeg are unpacked into target/outputs, 500 MB.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=software
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"
# shellcheck source=scripts/venv.sh
. "$root/scripts/venv.sh"

packages='numpy==2.4.6 opencv-python-headless==5.0.0.93 OpenEXR==3.5.3 pillow==13.0.0 imageio-ffmpeg==0.8.1'
venv=$root/target/outputs/venv
python_venv 3.11 "$venv" "$packages"

# With the command, whose features it then has: as the tests built it.
cargo build --quiet --manifest-path "$root/Cargo.toml" --example ground_truth
out=$root/target/outputs/pairs
rm -rf "$out"
pair() { STEREOTRACE_ADAPTER=software "$root/target/debug/examples/ground_truth" "$@"; }
pair hall-finished 480x360 "$out/match"
pair random-1000 320x240 "$out/ellipsoids"
pair spheres 321x201 "$out/off-axis" off-axis
pair three-spheres 97x64 "$out/sky"
pair hall 1x1 "$out/pixel"
"$venv/bin/python" "$root/scripts/check_outputs.py" \
    "$out/ellipsoids" "$out/off-axis" "$out/sky" "$out/pixel" --match "$out/match"
