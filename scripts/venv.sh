# A Python environment for checks that want packages of the registry. Sourced behind setup.sh:
#   python_venv 3.10 FOLDER PACKAGES     (the packages with their versions, in one text)
# Installs Python and its venv where apt-get can; an environment that has these packages already stays.
# shellcheck shell=sh disable=SC2154 # setup.sh has `have`, `fail` and `apt_install`

python_is_new_enough() { have python3 && python3 -c "import sys; sys.exit(sys.version_info < ($(echo "$1" | tr . ,)))"; }
python_has_venv() { python3 -c 'import ensurepip, venv' 2>/dev/null; }

python_venv() { # python_venv OLDEST FOLDER PACKAGES
    if ! python_is_new_enough "$1" || ! python_has_venv; then
        have apt-get || fail "this needs Python $1 or newer with venv: see https://www.python.org"
        apt_install python3 python3-venv
        python_is_new_enough "$1" || fail "this needs Python $1 or newer, found $(python3 --version)"
    fi
    if [ "$(cat "$2/packages" 2>/dev/null)" != "$3" ]; then
        rm -rf "$2"
        mkdir -p "$(dirname "$2")"
        python3 -m venv "$2" || fail "python3 could not make $2"
        # shellcheck disable=SC2086 # a list of packages
        "$2/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: $3 ||
            fail "pip could not install $3: is the package registry within reach? Nothing was checked"
        echo "$3" >"$2/packages"
    fi
}
