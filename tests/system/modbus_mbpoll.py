"""mbpoll reads a box's Modbus map. Usage: modbus_mbpoll.py STAND (prints its port, ends with its input)"""
import re
import shutil
import subprocess
import sys

SKIPPED = 77


def poll(port, first, count, kind, unit=1, *more):
    """The values that mbpoll prints, by address; None if it failed."""
    command = ["mbpoll", "-m", "tcp", "-p", str(port), "-a", str(unit), "-0", "-1", "-B", "-r", str(first), "-c", str(count),
               "-t", kind, *more, "127.0.0.1"]
    run = subprocess.run(command, capture_output=True, text=True, timeout=20)
    if run.returncode != 0:
        return None
    return {int(a): v.split()[0] for a, v in re.findall(r"^\[(\d+)\]:\s+(\S.*)$", run.stdout, re.M)}


# What the stand's epoch must read as: (first, count, mbpoll's type, unit) -> values.
EXPECTED = [
    ((0, 4, "3:hex", 1), ["0x4144", "0x4954", "0x0100", "0x002A"]),
    ((4, 1, "3:int", 1), [str(0x12345678)]),
    ((6, 1, "3:float", 1), ["123.456"]),
    ((8, 1, "3", 1), ["65534"]),
    ((100, 3, "3", 1), ["77", "2", "1"]),
    ((104, 3, "3:int", 1), ["123456", "-9000", "40000000"]),
    ((104, 3, "4:int", 255), ["123456", "-9000", "40000000"]),
    ((110, 1, "3:int", 1), ["-2147483648"]),
    ((0, 4, "1", 1), ["1", "1", "0", "0"]),
    ((9, 1, "3", 1), None),
    ((0, 1, "3", 9), None),
]


def main(stand):
    if shutil.which("mbpoll") is None:
        print("mbpoll is not installed")
        return SKIPPED
    faults = 0
    with subprocess.Popen([stand], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as box:
        port = int(box.stdout.readline())
        for question, expected in EXPECTED:
            got = poll(port, *question)
            values = None if got is None else list(got.values())
            if values != expected:
                faults += 1
                print(f"{question}: {values}, not {expected}")
        box.stdin.close()
        faults += box.wait(10) != 0
    print(f"{len(EXPECTED)} questions, {faults} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
