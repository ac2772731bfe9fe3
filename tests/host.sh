# For checks that call the tool. SDP3 may name a ready binary; otherwise the host is built, however old the binary is that lies
# there. Sets SDP3 and target. To be sourced in the repository's root.
target=${CARGO_TARGET_DIR:-$PWD/target}
if [ -z "${SDP3:-}" ]; then
    printf '== build the host (the first time this takes minutes: burn)\n'
    cargo build --release
    SDP3=$target/release/sdp3
fi
[ -x "$SDP3" ] || {
    printf 'SDP3 = %s is no program\n' "$SDP3" >&2
    exit 2
}
SDP3=$(realpath "$SDP3")
mkdir -p "$target"
target=$(realpath "$target")
