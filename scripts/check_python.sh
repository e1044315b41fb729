#!/bin/sh
# Builds the Python package as a wheel, installs it as a user would and runs its tests: types, pictures, data sets, Ray.
#   sh scripts/check_python.sh [ARGUMENTS OF pytest]
# The wheel is left in target/python/wheels. Needs Python 3.10 or newer, which it installs with its venv where apt-get
# can, and the Python package registry once: some 300 MB in target/python. STEREOTRACE_PROFILE is a profile of cargo;
# release by default. STEREOTRACE_EXTENSION is an extension that is built already, with the command beside it; the
# package is then installed without a wheel.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=software
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"
export STEREOTRACE_ADAPTER=software RAY_USAGE_STATS_ENABLED=0
# shellcheck source=scripts/venv.sh
. "$root/scripts/venv.sh"

packages='maturin==1.16.0 numpy==2.4.6 pyyaml==6.0.3 fsspec==2026.9.0 tqdm==4.70.1 pyarrow==26.0.1 ray[data]==2.60.0 trimesh==5.2.0 pillow==13.0.0 scipy==1.17.1 webdataset==1.0.2 opencv-python-headless==5.0.0.93 pytest==9.2.0 pytest-xdist==3.8.0 mypy==2.4.1 types-pyyaml==6.0.12.20261113 types-tqdm==4.70.0.20261106'
venv=$root/target/python/venv
python_venv 3.10 "$venv" "$packages"

profile=${STEREOTRACE_PROFILE:-release}
if [ -n "${STEREOTRACE_EXTENSION-}" ]; then
    site=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    rm -rf "$site"/stereotrace "$site"/stereotrace-*.dist-info
    cp -R "$root/python/stereotrace" "$site/"
    cp "$STEREOTRACE_EXTENSION" "$site/stereotrace/_stereotrace.abi3.so"
    (cd "$root/python" && PATH=$venv/bin:$PATH maturin pep517 write-dist-info --metadata-directory "$site" --interpreter "$venv/bin/python")
    built=$(dirname -- "$STEREOTRACE_EXTENSION")
else
    wheels=$root/target/python/wheels
    rm -rf "$wheels"
    (cd "$root/python" && PATH=$venv/bin:$PATH maturin build --quiet --profile "$profile" --locked --out "$wheels")
    "$venv/bin/pip" install --quiet --disable-pip-version-check --force-reinstall --no-deps "$wheels"/*.whl
    cargo build --quiet --profile "$profile" --manifest-path "$root/Cargo.toml" --package stereotrace-cli
    case $profile in dev) built=$root/target/debug ;; *) built=$root/target/$profile ;; esac
fi
export STEREOTRACE_COMMAND="$built/stereotrace"

# From here: no folder named stereotrace may hide the package that was installed.
cd "$root/target/python"
"$venv/bin/mypy" --config-file "$root/python/pyproject.toml" --package stereotrace
"$venv/bin/python" -m mypy.stubtest stereotrace._stereotrace --allowlist "$root/python/tests/stubtest-allow.txt"
"$venv/bin/pytest" -p no:cacheprovider -q --durations=5 -n 2 --dist loadfile "$root/python/tests" "$@"
