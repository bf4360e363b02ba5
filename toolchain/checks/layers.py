"""Who may include whom. Usage: layers.py ROOT"""
import re
import sys
import pathlib
import tree

# A room sees itself, what stands here, and what these see ("firmware/base" is seen by all).
STAGES = ["capture", "detect", "identify", "stereo", "track", "georef", "publish"]
SEES = {
    "firmware/base": [],
    "firmware/optics": [],
    "firmware/capture": ["firmware/optics"],
    "firmware/detect": ["firmware/optics"],
    # a stage sees optics and the record of the stage just before it
    "firmware/identify": ["firmware/optics", "firmware/detect/blob_set.h"],
    "firmware/stereo": ["firmware/optics", "firmware/identify/sighting_set.h"],
    # no stage: nothing comes after it. It reads stereo's records and repeats its fit, so it sees all of stereo
    "firmware/watch": ["firmware/optics", "firmware/stereo"],
    # .. and the track says what it expects of the next pair
    "firmware/track": ["firmware/optics", "firmware/stereo/point_set.h", "firmware/stereo/expectation.h"],
    "firmware/georef": ["firmware/optics", "firmware/track/target_state.h"],
    "firmware/publish": ["firmware/optics", "firmware/georef/geo_fix.h"],
    "firmware/config": [],
    "firmware/pipeline": ["firmware/optics"] + ["firmware/" + s for s in STAGES],
    "firmware/app": ["firmware/pipeline", "firmware/config", "firmware/optics", "firmware/watch", "hal", "board"] + ["firmware/" + s for s in STAGES],
    "hal": [],
    # the operating system has one room, which the other drivers share
    "drivers/sim": ["hal", "firmware/optics", "drivers/linux"],
    "drivers": ["hal", "drivers/linux"],
    "board": ["hal", "drivers"],
    "host": ["firmware", "hal", "drivers", "board"],
    "tests": ["firmware", "hal", "drivers", "board", "host"],
}
FORBIDDEN = {"host": ["firmware/app"]}
# Headers of operating systems and devices: not for the box outside its drivers.
OS_HEADER = re.compile(r"^(sys/|linux/|net/|netinet/|arpa/|unistd\.h|fcntl\.h|poll\.h|pthread\.h|sched\.h|termios\.h|signal\.h|arv|modbus|gpiod|spawn\.h)")
# The oracles of the tests are not used by the stages.
ORACLE = re.compile(r"^(opencv2/|ceres/)")
INCLUDE = re.compile(r'^\s*#\s*include\s+(["<])([^">]+)[">]')


def room_of(path):
    """The longest entry of SEES that holds this path."""
    text = str(path)
    best = None
    for room in SEES:
        if text.startswith(room + "/") and (best is None or len(room) > len(best)):
            best = room
    return best


def fault_of(path, room, kind, target):
    if kind == "<":
        if OS_HEADER.match(target) and not (room.startswith("drivers") or room in ("tests", "host")):
            return f"<{target}> belongs to drivers"
        if ORACLE.match(target) and (room.startswith("firmware") or room == "hal"):
            return f"<{target}> is for hosts and tests"
        return None
    if target.startswith("firmware/base/") or target.startswith(room + "/"):
        return None
    if any(target.startswith(bad + "/") for bad in FORBIDDEN.get(room, [])):
        return f"{room} may not include {target}"
    if any(target == seen or target.startswith(seen + "/") for seen in SEES[room]):
        return None
    return f"{room} may not include {target}"


def main(root):
    faults, checked = [], 0
    for path in tree.sources(root):
        room = room_of(path)
        checked += 1
        if room is None:
            faults.append(f"{path}: stands in no room")
            continue
        for number, line in enumerate(pathlib.Path(root, path).read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            if match:
                fault = fault_of(path, room, *match.groups())
                if fault:
                    faults.append(f"{path}:{number}: {fault}")
    return tree.report("layers", faults, checked)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
