# Sourced: refuses an option that a script does not know.
only() { # GIVEN LEGAL...: GIVEN is all that the script was called with, and may be empty
    local given=$1 legal
    shift
    [ -n "$given" ] || return 0
    for legal; do
        [ "$given" != "$legal" ] || return 0
    done
    printf '%s: %s is unknown; legal: %s\n' "$0" "$given" "$*" >&2
    exit 2
}
