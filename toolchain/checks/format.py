"""Every file is as clang-format leaves it. Usage: format.py ROOT [--fix]"""
import subprocess
import sys
import tree


def main(root, fix):
    files = [str(path) for path in tree.sources(root)]
    arguments = ["clang-format", "-i"] if fix else ["clang-format", "--dry-run", "-Werror"]
    done = subprocess.run(arguments + files, cwd=root, capture_output=True, text=True)
    faults = [line for line in done.stderr.splitlines() if "error:" in line]
    if done.returncode != 0 and not faults:
        faults = [done.stderr.strip()]
    return tree.report("format", faults, len(files))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], "--fix" in sys.argv))
