# Runs checks two at a time, or SDP3_JOBS at a time: `check` names each, `run_checks BUILDS` runs them, the first BUILDS of which are builds.
# What a check printed follows when it has ended. To be sourced; tests/runner tests it.
jobs=${SDP3_JOBS:-2}
[[ $jobs =~ ^[1-9][0-9]?$ ]] || {
    printf 'tests/run: SDP3_JOBS is %s; legal: 1 to 99\n' "$jobs" >&2
    exit 2
}
log=$(mktemp -d)
trap 'rm -rf "$log"' EXIT
trap 'for pid in "${!running[@]}"; do kill -- "-$pid"; done 2>/dev/null; exit 130' INT TERM
# check AFTER WHAT COMMAND...: AFTER is `-` for nothing, `built` for the builds, which make what the check runs, and `cargo` for
# the builds and, as cargo would wait for itself, every other check of that kind. Those that can begin do so in the order given.
after=() what=() commands=()
check() {
    after+=("$1") what+=("$2")
    shift 2
    commands+=("$(printf '%q ' "$@")")
}
# begins the K-th check, as a process group of its own, so that it ends as a whole
begin() {
    printf 'begun: %s\n' "${what[$1]}"
    # shellcheck disable=SC2016 # /proc counts in clock ticks
    setsid bash -c 'code=0; eval "$1" || code=$?; read -r -a stat </proc/$$/stat
        echo "$SECONDS $(((stat[15] + stat[16]) / $(getconf CLK_TCK)))" >"$2.took"; exit "$code"' \
        check "${commands[$1]}" "$log/$1" >"$log/$1" 2>&1 </dev/null &
    running[$!]=$1
}
# whether the K-th check can begin
can_begin() {
    local pid
    case ${after[$1]} in
    -) return 0 ;;
    cargo) for pid in "${!running[@]}"; do [ "${after[${running[$pid]}]}" != cargo ] || return 1; done ;;
    esac
    [ "$built" = "$builds" ]
}
# waits for a check to end, and shows it
finish() {
    local pid k code=0 elapsed=0 processor=0
    while :; do
        for pid in "${!running[@]}"; do kill -0 "$pid" 2>/dev/null || break 2; done
        sleep 0.1
    done
    wait "$pid" || code=$?
    k=${running[$pid]}
    unset "running[$pid]"
    printf '\n== %s\n' "${what[$k]}"
    cat "$log/$k"
    read -r elapsed processor <"$log/$k.took" || true
    all=$((all + processor))
    if [ "$code" = 0 ]; then
        passed=$((passed + 1))
        [ "$k" -ge "$builds" ] || built=$((built + 1))
        printf 'passed in %d s\n' "$elapsed"
    else
        failed=$((failed + 1))
        printf 'FAILED: %s\n' "${commands[$k]}"
        broken+=("${what[$k]}")
    fi
    took+=("$(printf '%4d s  %5d s of a processor  %s' "$elapsed" "$processor" "${what[$k]}")")
}
declare -A running=()
took=() broken=() built=0 passed=0 failed=0 all=0
# exit code 1 if a check failed, or did not run
run_checks() {
    local builds=$1 waiting place k
    mapfile -t waiting < <(seq 0 $((${#what[@]} - 1)))
    while [ ${#waiting[@]} != 0 ] || [ ${#running[@]} != 0 ]; do
        for place in "${!waiting[@]}"; do
            [ ${#running[@]} -lt "$jobs" ] || break
            k=${waiting[$place]}
            can_begin "$k" || continue
            unset "waiting[$place]"
            begin "$k"
        done
        # nothing can begin without the builds
        [ ${#running[@]} != 0 ] || break
        finish
    done
    printf '\n== the longest\n'
    printf '%s\n' "${took[@]}" | sort -rn | head -n 12
    [ "$failed" = 0 ] || printf 'FAILED: %s\n' "${broken[@]}"
    [ ${#waiting[@]} = 0 ] || printf '%d checks NOT RUN: they run what the builds make\n' "${#waiting[@]}"
    printf '\n%d passed, %d failed in %d s, %d s of a processor\n' "$passed" "$failed" "$SECONDS" "$all"
    [ "$failed" = 0 ]
}
