#!/usr/bin/env python3
"""console_windows.py WINE PSIM.EXE STATE.csv: Ctrl-C in a console ends a run after its frame, with its report and files.

Wine has a console where its input is a terminal: this script is one. Called by tools/cross windows.
"""
import os
import pty
import select
import sys
import time

WAIT_S, END_S = 5, 60


def main():
    wine, psim, state = sys.argv[1:]
    process, terminal = pty.fork()
    if process == 0:
        os.environ["TERM"] = "xterm"
        os.execvp(wine, [wine, psim, "--particles", "1000", "--frames", "1000000000", "--state", state])
    begin, shown, asked = time.monotonic(), b"", False
    while time.monotonic() - begin < END_S:
        if not asked and time.monotonic() - begin > WAIT_S:
            os.write(terminal, b"\x03")
            asked = True
        if select.select([terminal], [], [], 0.2)[0]:
            try:
                part = os.read(terminal, 65536)
            except OSError:  # the other side has ended
                break
            if not part:
                break
            shown += part
    else:
        os.kill(process, 9)
    status = os.waitpid(process, 0)[1]
    print(f"status {status}, asked {asked}, {len(shown)} bytes shown, state {os.path.exists(state)}")
    return 0 if status == 0 and asked and os.path.exists(state) else 1


if __name__ == "__main__":
    sys.exit(main())
