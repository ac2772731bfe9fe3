"""What the checks of `sdp3 classify` share: they are called with SDP3, the program, and FOLDER, where they work."""

import subprocess
import sys
from pathlib import Path

SDP3, WORK = sys.argv[1], Path(sys.argv[2])
count = 0


def check(holds, what):
    global count
    count += 1
    if not holds:
        sys.exit(f"FAILED: {what}")


def run(*arguments, legal=(0,), stdin=None):
    """Standard output of the program, or standard error where it refuses."""
    done = subprocess.run([SDP3, *map(str, arguments)], capture_output=True, input=stdin)
    out, err = done.stdout.decode(), done.stderr.decode()
    check(done.returncode in legal, f"{arguments}: exit {done.returncode}: {err[-600:]}")
    return out if done.returncode == 0 else err
