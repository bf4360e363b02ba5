"""The C++ files of the project, for the checks beside this file."""
import pathlib

ROOMS = ("firmware", "hal", "drivers", "board", "host", "tests")


def sources(root, endings=(".h", ".cpp", ".inl")):
    """Paths of all C++ files below the rooms, sorted, relative to root."""
    found = []
    for room in ROOMS:
        for path in sorted(pathlib.Path(root, room).rglob("*")):
            if path.suffix in endings:
                found.append(path.relative_to(root))
    return found


def report(name, faults, checked):
    """Prints each fault, then a closing line; the exit code."""
    for fault in faults:
        print(fault)
    print(f"{name}: {checked} files, {len(faults)} faults")
    return 1 if faults or checked == 0 else 0
