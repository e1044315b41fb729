#!/bin/sh
# Writes a VR photo, films of both eyes, of quilts, and of 360 and 180 degrees. Reads their metadata back by exiftool
# and ffprobe. The films all around are made by the lines in docs/FORMATS.md. Needs apt-get where FFmpeg, mkvtoolnix or
# exiftool are not there.
#   sh scripts/check_panorama.sh
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=software
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"
have ffmpeg || apt_install ffmpeg
have mkvpropedit || apt_install mkvtoolnix
have exiftool || apt_install libimage-exiftool-perl

cargo build --quiet --manifest-path "$root/Cargo.toml" --package stereotrace-cli
command=$(cargo metadata --manifest-path "$root/Cargo.toml" --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/debug/stereotrace
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# Fails unless the text has the line.
expect() { printf '%s\n' "$1" | grep -qx "$2" || fail "no line '$2' in: $1"; }

"$command" render builtin:hall --quiet --projection 180 --size 64x64 --out photo.vr.jpg
told=$(exiftool -s -XMP-GPano:all -XMP-GImage:ImageMimeType photo.vr.jpg)
for line in 'ProjectionType *: equirectangular' 'FullPanoWidthPixels *: 128' 'CroppedAreaLeftPixels *: 32' 'ImageMimeType *: image/jpeg'; do
    expect "$told" "$line"
done
exiftool -b -XMP-GImage:ImageData photo.vr.jpg > right.jpg
expect "$(exiftool -s -ImageSize right.jpg)" 'ImageSize *: 64x64'
"$command" render builtin:hall --quiet --projection 360 --size 64x32 --out all
expect "$(exiftool -s -XMP-GPano:all all/left.png)" 'ProjectionType *: equirectangular'

"$command" sequence builtin:hall --quiet --packing side-by-side --size 64x36 --orbit 3 --out pair.mp4
told=$(ffprobe -loglevel error -count_frames -show_streams pair.mp4)
for line in codec_name=h264 width=128 height=36 nb_read_frames=3 color_space=bt709 'type=side by side' inverted=0; do
    expect "$told" "$line"
done
# The stream itself has the frame packing message, which televisions read.
ffmpeg -loglevel error -i pair.mp4 -c copy -f h264 pair.h264
expect "$(ffprobe -loglevel error -show_frames pair.h264)" 'side_data_type=Stereo 3D'
"$command" sequence builtin:hall --quiet --quilt 3x2 --size 31x25 --orbit 2 --out quilt_qs3x2a1.24.mp4
told=$(ffprobe -loglevel error -show_streams quilt_qs3x2a1.24.mp4)
for line in width=92 height=50 nb_frames=2; do expect "$told" "$line"; done

"$command" sequence builtin:hall --quiet --projection 360 --size 128x64 --orbit 3 --fps 30 --out film.mkv
mkvpropedit -q film.mkv --edit track:v1 --set projection-type=1
ffmpeg -loglevel error -i film.mkv -c copy -strict unofficial film_360_TB.mp4
told=$(ffprobe -loglevel error -show_streams film_360_TB.mp4)
for line in width=128 height=128 'type=top and bottom' inverted=0 projection=equirectangular; do
    expect "$told" "$line"
done

"$command" sequence builtin:hall --quiet --projection 180 --size 64x64 --orbit 3 --fps 30 --out half.mkv
mkvpropedit -q half.mkv --edit track:v1 --set projection-type=1 \
    --set projection-private=0000000000000000000000004000000040000000
ffmpeg -loglevel error -i half.mkv -c copy -strict unofficial film_180x180_3dh.mp4
told=$(ffprobe -loglevel error -show_streams film_180x180_3dh.mp4)
for line in width=128 height=64 'type=side by side' 'projection=tiled equirectangular' bound_top=0 bound_bottom=0; do
    expect "$told" "$line"
done
say "panoramas: every reader found what was written"
