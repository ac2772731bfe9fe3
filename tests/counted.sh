# For checks that run tests by a filter: `counted LEAST COMMAND...` runs the command and fails if it fails, or if fewer than LEAST
# tests passed. To be sourced.
counted() {
    local least=$1 ran out
    shift
    out=$(mktemp)
    if ! "$@" 2>&1 | tee "$out"; then
        rm -f "$out"
        return 1
    fi
    ran=$(sed -n 's/^test result: ok\. \([0-9]*\) passed.*/\1/p' "$out" | awk '{ sum += $1 } END { print sum + 0 }')
    rm -f "$out"
    printf '%d tests passed; at least %d must\n' "$ran" "$least"
    [ "$ran" -ge "$least" ]
}
