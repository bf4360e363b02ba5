"""Tests that can fail: each has a check, none is switched off, no two have one name. Usage: tests.py ROOT"""
import pathlib
import re
import sys
import tree

TEST = re.compile(r"^TEST\((\w+),\s*(\w+)\)\s*\{", re.MULTILINE)
# CppUTest's checks, own macros built on them (COMPLAINS), and helpers of a test that check (CheckSame, Stress, Refuses).
CHECK = re.compile(r"\b([A-Z_]*(CHECK|EQUAL|CONTAINS|FAIL|COMPLAINS)[A-Z_]*|mock\(\)\.\w+)\s*\(")
OFF = re.compile(r"\b(IGNORE_TEST|TEST_IGNORE|XTEST)\s*\(")
CALL = re.compile(r"\b([A-Z]\w*)\s*(?:<[\w:, ]*>)?\s*\(")
HELPER = re.compile(r"^\s*(?:template <[^>]*>\s*)?(?:static )?[\w:<>&\* ]+?\b([A-Z]\w*)\s*\([^;{}]*\)\s*(?:const )?\{", re.MULTILINE)


def body_from(text, brace):
    """The text between the brace at `brace` and the one that closes it; strings may hold no lone brace."""
    depth = 0
    for i in range(brace, len(text)):
        depth += (text[i] == "{") - (text[i] == "}")
        if depth == 0:
            return text[brace:i]
    return text[brace:]


def without_literals(text):
    text = re.sub(r'R"(\w*)\(.*?\)\1"', '""', text, flags=re.DOTALL)
    text = re.sub(r'"(\\.|[^"\\\n])*"', '""', text)
    text = re.sub(r"'(\\.|[^'\\\n])'", "' '", text)
    return re.sub(r"//[^\n]*", "", text)


def checking_helpers(text):
    """Names of functions that check, directly or through another of them."""
    bodies = {}
    for match in HELPER.finditer(text):
        bodies[match.group(1)] = bodies.get(match.group(1), "") + body_from(text, match.end() - 1)
    checking = {name for name, body in bodies.items() if CHECK.search(body)}
    while True:
        more = {n for n, body in bodies.items() if n not in checking and checking & set(CALL.findall(body))}
        if not more:
            return checking
        checking |= more


def main(root):
    faults, seen, files = [], {}, [p for p in tree.sources(root) if str(p).startswith("tests/")]
    texts = {path: without_literals(pathlib.Path(root, path).read_text()) for path in files}
    shared = set().union(*(checking_helpers(text) for text in texts.values()))
    for path, text in texts.items():
        for match in OFF.finditer(text):
            faults.append(f"{path}:{text.count(chr(10), 0, match.start()) + 1}: {match.group(1)} is no test; mend or delete it")
        for match in TEST.finditer(text):
            line = text.count("\n", 0, match.start()) + 1
            name = ".".join(match.groups())
            body = body_from(text, match.end() - 1)
            if not CHECK.search(body) and not shared & set(CALL.findall(body)):
                faults.append(f"{path}:{line}: {name} checks nothing")
            key = (path.parent, name)
            if key in seen:
                faults.append(f"{path}:{line}: {name} stands in {seen[key]} too")
            seen[key] = path
    return tree.report("tests", faults, len(seen))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
