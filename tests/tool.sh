# For checks that need a command of Cargo's: `tool NAME VERSION FOLDER` installs exactly this version into the folder, unless it is
# there already, and puts it first on the path. Without optimisation and debug information: it is built in half the time, and waits for
# compilers anyway. To be sourced.
tool() {
    printf '== %s %s\n' "$1" "$2"
    env -u CARGO_TARGET_DIR CARGO_PROFILE_DEV_DEBUG=false cargo install -q --locked --debug --version "=$2" --root "$3" "$1"
    PATH=$3/bin:$PATH
}
