"""The demo, end to end on the real Aravis path, judged by what does not depend on how busy the machine is.
Usage: demo.py BIN_FOLDER SOURCE_FOLDER SCRATCH_FOLDER"""
import os
import re
import subprocess
import sys

SECONDS = 8


def run(bin_folder, source, scratch):
    enter = ["unshare", "-n"] if os.geteuid() == 0 else ["unshare", "-Urn"]
    inside = 'ip link set lo up && ip addr add 127.0.0.2/8 dev lo && exec "$@"'
    command = [f"{bin_folder}/adit", "demo", "--scene", f"{source}/host/scenes/drive.yaml", "--seconds", str(SECONDS),
               "--out", scratch]
    done = subprocess.run(enter + ["bash", "-c", inside, "namespace"] + command, capture_output=True, text=True, timeout=120)
    print(done.stdout, done.stderr)
    return done.stdout


def figure(text, what):
    found = re.search(r"^  " + re.escape(what) + r"\s+(.*)$", text, re.M)
    if not found:
        sys.exit(f"no line '{what}' in the summary")
    return found.group(1)


def main(bin_folder, source, scratch):
    text = run(bin_folder, source, scratch)
    faults = []
    pairs = int(figure(text, "pairs").split()[0])
    if pairs < 60:
        faults.append(f"{pairs} pairs in {SECONDS} s")
    if not figure(text, "false positions").startswith("0 "):
        faults.append("a false position")
    for what in ("error against truth, 20-50 m", "CAN frames, CRC verified", "Modbus position"):
        if not figure(text, what).endswith(" good"):
            faults.append(f"{what}: {figure(text, what)}")
    for fault in faults:
        print("FAULT", fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:4]))
