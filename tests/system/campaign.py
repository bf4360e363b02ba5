"""`adit evaluate --suite`, `adit diff` and `adit inspect`. Usage: campaign.py ADIT GOLDEN"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ADIT = sys.argv[1]
GOLDEN = pathlib.Path(sys.argv[2])
FAULTS = []


def expect(condition, what):
    if not condition:
        FAULTS.append(what)
        print("FAILED:", what, flush=True)


def run(*arguments):
    return subprocess.run([ADIT, *map(str, arguments)], capture_output=True, text=True, check=False)


def ends(code, words, *arguments):
    done = run(*arguments)
    text = done.stdout + done.stderr
    expect(done.returncode == code and all(word in text for word in words),
           f"adit {' '.join(map(str, arguments))}: exit {done.returncode}, not {code}, or without {words}: {text}")
    return done.stdout


def suites(work):
    figures = work / "figures.json"
    lamps = ["evaluate", "--suite", "underground", "--case", "lamps", "--count", "240", "--seed", "3", "--json", figures,
             "--report", work / "page.html"]
    first = ends(0, ["positions reported", "holds"], *lamps)
    case = json.loads(figures.read_text())["cases"][0]
    expect(case["case"] == "lamps" and case["holds"] and case["figures"][0]["value"] == 0, "the JSON says the same")
    expect("Every bar holds." in (work / "page.html").read_text(), "the page says the same")
    expect(first == run(*lamps).stdout, "the same seed gives the same figures")
    ends(0, ["found within 30 s", "holds"], "evaluate", "--suite", "watch", "--case", "step", "--count", "1")
    ends(2, ["--suite", "'tunnel'", "underground"], "evaluate", "--suite", "tunnel")
    ends(2, ["--case", "'lmaps'", "swaps, lamps, mirror"], "evaluate", "--suite", "underground", "--case", "lmaps")
    ends(2, ["--track"], "evaluate")


def calibrations(work):
    """Every case with three calibrations: simulated centroids, clutter, rendered recordings, the seed's tables."""
    figures = work / "calibrations.json"
    ends(0, ["clutter", "rendered"], "evaluate", "--suite", "calibration", "--count", "3", "--json", figures)
    cases = json.loads(figures.read_text())["cases"]
    expect(len(cases) == 6 and all(case["holds"] for case in cases), f"six cases hold: {cases}")
    ends(2, ["--case", "'posse'", "pose, intrinsics"], "evaluate", "--suite", "calibration", "--case", "posse")
    ends(0, ["5.1", "5.6"], "evaluate", "--suite", "seed", "--count", "3")


def diffs(work):
    track = GOLDEN / "track.csv"
    ends(0, ["the same"], "diff", track, track)
    moved = work / "moved.csv"
    moved.write_text(re.sub(r"bar_c,tracked,[^,]*", "bar_c,tracked,9.0", track.read_text()))
    ends(1, ["different"], "diff", track, moved, "--tolerance-m", "0.01", "--json", work / "diff.json")
    expect(not json.loads((work / "diff.json").read_text())["same"], "the JSON of a diff says different")
    ends(1, ["none.csv"], "diff", track, work / "none.csv")


def inspections(work):
    rec = work / "rec"
    ends(0, [], "simulate", GOLDEN / "scene.yaml", "--out", rec, "--frames", "8")
    ends(0, [], "train", "--target", GOLDEN / "bar_c.yaml", "--camera", rec / "cam0/sensor.yaml", "--out", work / "c.yaml")
    common = ["inspect", rec, "--rig", rec / "rig_true.yaml", "--model", work / "c.yaml", "--out", work / "why.png"]
    ends(0, ["bar_c: found", "taken"], *common, "--at", "0.1")
    expect((work / "why.png").read_bytes()[:4] == b"\x89PNG", "a PNG is written")
    ends(2, ["--frame", "8", "0 to 7"], *common, "--frame", "8")
    ends(2, ["--at"], *common, "--at", "7.5")
    ends(2, [], *common)


def main():
    with tempfile.TemporaryDirectory(prefix="adit_campaign_") as folder:
        for step in [suites, calibrations, diffs, inspections]:
            print(f"-- {step.__name__}", flush=True)
            step(pathlib.Path(folder))
    print(f"{len(FAULTS)} faults")
    return 1 if FAULTS else 0


if __name__ == "__main__":
    sys.exit(main())
