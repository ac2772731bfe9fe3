# The cross toolchain, for the build scripts of emulated machines and boards. To be sourced.
# `toolchain OUT TRIPLE...` sets `cargo` (a command), `std` (its options) and `linker`: rustup's targets where they are or can be had,
# else the distribution's compiler and core's source. It adds packages to `missing`, installs them all, and says what it does.
say() { printf 'firmware: %s\n' "$*"; }

install() {
    local sudo=
    [ "$(id -u)" = 0 ] || sudo="sudo -n"
    say "installing $*"
    if ! { $sudo apt-get update -q && $sudo env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -q --no-install-recommends "$@"; } >"$out/install.log" 2>&1; then
        say "could not install them; see $out/install.log, or run: sudo apt-get install $*" >&2
        exit 2
    fi
}

have_rustup_targets() {
    local sysroot triple
    sysroot=$(rustc --print sysroot 2>/dev/null) || return 1
    for triple in "$@"; do
        [ -d "$sysroot/lib/rustlib/$triple" ] || return 1
    done
}

# what QEMU's packages are called
emulator_package() {
    command -v "$1" >/dev/null && return
    case $1 in
    qemu-system-riscv32) missing+=(qemu-system-misc) ;;
    *) missing+=(qemu-system-arm) ;;
    esac
}

toolchain() {
    local out=$1
    shift
    if ! have_rustup_targets "$@" && command -v rustup >/dev/null && [ ! -e "$out/rustup-unreachable" ]; then
        say "asking rustup for the targets"
        flock "$(rustup show home)" timeout 120 rustup target add "$@" >/dev/null 2>&1 || touch "$out/rustup-unreachable"
    fi
    if have_rustup_targets "$@"; then
        cargo=(cargo)
        std=()
    else
        [ -x /usr/bin/rustc ] && [ -x /usr/bin/cargo ] && [ -d /usr/lib/rustlib/src/rust/library/core ] ||
            missing+=(rustc-web cargo-web rust-web-src)
        cargo=(env RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 /usr/bin/cargo)
        std=(-Zbuild-std=core)
    fi
    linker=$(command -v rust-lld || command -v ld.lld-19 || command -v ld.lld || ls "$(rustc --print sysroot 2>/dev/null)"/lib/rustlib/*/bin/rust-lld 2>/dev/null | head -n 1 || true)
    [ -n "$linker" ] || missing+=(lld-19)
    if [ ${#missing[@]} != 0 ]; then
        mapfile -t missing < <(printf '%s\n' "${missing[@]}" | sort -u)
        install "${missing[@]}"
    fi
    [ -n "$linker" ] || linker=$(command -v ld.lld-19)
}
