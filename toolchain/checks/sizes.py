"""Files stay under 400 lines and hold no unfinished marks. Usage: sizes.py ROOT"""
import pathlib
import re
import sys
import tree

LINES_MAX = 400
MARK = re.compile(r"\b(FIXME|XXX)\b|#if 0|\bTODO\b(?! \(when )")


def main(root):
    faults = []
    files = tree.sources(root)
    for path in files:
        lines = pathlib.Path(root, path).read_text().splitlines()
        if len(lines) > LINES_MAX:
            faults.append(f"{path}: {len(lines)} lines, {LINES_MAX} allowed")
        faults += [f"{path}:{n}: unfinished: {line.strip()}" for n, line in enumerate(lines, 1) if MARK.search(line)]
    return tree.report("sizes", faults, len(files))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
