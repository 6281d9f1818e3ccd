# Sourced by the tools: makes virtual environments under .venvs, and leaves one alone that is up to date.

find_python() {
    local candidate
    for candidate in "${PYTHON:-}" python3 python3.14 python3.13 python3.12 python3.11; do
        if [ -n "$candidate" ] && "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            echo "$candidate"
            return
        fi
    done
    echo "Python 3.11 or newer is needed and was not found; set PYTHON to one." >&2
    return 1
}

# make_environment NAME PIP_ARGUMENT...: .venvs/NAME with those things installed.
# A stamp holds the arguments and a checksum of pyproject.toml: while both are the same nothing is installed again.
make_environment() {
    local name=$1 folder=.venvs/$1 python stamp
    shift
    python=$(find_python)
    stamp="$* $(cksum pyproject.toml) $("$python" --version)"
    if [ -f "$folder/stamp" ] && [ "$(cat "$folder/stamp")" = "$stamp" ]; then
        return
    fi
    echo "installing into $folder"
    rm -rf "$folder"
    "$python" -m venv "$folder"
    # Dependency groups need pip 25.1.
    "$folder/bin/python" -m pip install --quiet --disable-pip-version-check --upgrade "pip>=25.1"
    "$folder/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
    echo "$stamp" >"$folder/stamp"
}

# make_locked_environment NAME LOCK: .venvs/NAME with the packages of requirements/LOCK.txt and no others. A file whose
# hash is not listed there is refused. Nothing is installed again while the list is the same.
make_locked_environment() {
    local folder=.venvs/$1 list=requirements/$2.txt python stamp
    python=$(find_python)
    stamp="$(cksum "$list") $("$python" --version)"
    if [ -f "$folder/stamp" ] && [ "$(cat "$folder/stamp")" = "$stamp" ]; then
        return
    fi
    echo "installing $list into $folder"
    rm -rf "$folder"
    "$python" -m venv "$folder"
    "$folder/bin/python" -m pip install --quiet --disable-pip-version-check --require-hashes --no-deps -r "$list"
    echo "$stamp" >"$folder/stamp"
}
