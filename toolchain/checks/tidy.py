"""Names and function sizes by clang-tidy (.clang-tidy), all cores. Usage: tidy.py ROOT BUILD [FILE...]"""
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tree


# The checks that follow a function's control flow cost as much as reading it: the product gets them, tests only the law.
# Of the libraries' templates they use few: what is not used is not parsed. Names of one test shadow those of another where
# the build joins them: no fault.
TEST_OPTIONS = ["--checks=-*,readability-identifier-naming,readability-function-size", "--extra-arg=-fdelayed-template-parsing", "--extra-arg=-Wno-shadow"]


def check(commands, path, more):
    done = subprocess.run(["clang-tidy", "--quiet", "--extra-arg=-Wno-unknown-warning-option", "-p", str(commands), *more, path], capture_output=True, text=True)
    lines = [line for line in done.stdout.splitlines() if "error:" in line or "warning:" in line]
    if done.returncode != 0 and not lines:
        lines = [f"{path}: clang-tidy failed: {done.stderr.strip()[:500]}"]
    return lines


def without_precompiled(build):
    """A folder with the compile commands as they are without precompiled headers, so that each source must name what it uses."""
    commands = json.loads(pathlib.Path(build, "compile_commands.json").read_text())
    for entry in commands:
        entry["command"] = re.sub(r" -Winvalid-pch -include \S*cmake_pch\S*", "", entry["command"])
    folder = build / "tidy"
    folder.mkdir(exist_ok=True)
    (folder / "compile_commands.json").write_text(json.dumps(commands))
    return folder, {entry["file"] for entry in commands if "cmake_pch" not in entry["file"]}


def main(root, build, only):
    root, build = pathlib.Path(root).resolve(), pathlib.Path(build).resolve()
    # Where the build joins sources into unity files, these are read: each header once instead of ten times.
    commands, compiled = without_precompiled(build)
    files = sorted(path for path in compiled if not only or any(o in path for o in only))
    tests = tuple(str(folder / "tests") + os.sep for folder in (root, build))
    jobs = [(path, TEST_OPTIONS if path.startswith(tests) else []) for path in files]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        faults = sorted({line for lines in pool.map(lambda job: check(commands, *job), jobs) for line in lines})
    return tree.report("tidy", faults, len(files))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], sys.argv[3:]))
