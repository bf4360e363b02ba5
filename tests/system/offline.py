"""The chain of the workstation tools on rendered recordings. Usage: offline.py ADIT SCENES"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ADIT = sys.argv[1]
SCENES = pathlib.Path(sys.argv[2])
FAULTS = []


def expect(condition, what):
    if not condition:
        FAULTS.append(what)
        print("FAILED:", what, flush=True)


def run(*arguments):
    return subprocess.run([ADIT, *map(str, arguments)], capture_output=True, text=True, check=False)


def must(*arguments):
    """Runs a step that must succeed, and say nothing on stderr, for no person watches a pipe."""
    done = run(*arguments)
    if done.returncode != 0 or done.stderr != "":
        sys.exit(f"FAILED: adit {' '.join(map(str, arguments))}: exit {done.returncode}: {done.stderr}")
    print(done.stdout, end="", flush=True)
    return done.stdout


def shortened(work, scene, rate_hz, frames):
    """The scene with fewer triggers a second, so that few frames cover its whole course."""
    text = (work / "scenes" / scene).read_text()
    text = re.sub(r"(?m)^rate_hz: .*$", f"rate_hz: {rate_hz}", text)
    text = re.sub(r"(?m)^frames: .*$", f"frames: {frames}", text)
    path = work / "scenes" / f"short_{scene}"
    path.write_text(text)
    return path


def figures(work, track, truth):
    out = work / "figures.json"
    must("evaluate", "--track", work / track, "--truth", truth, "--json", out, "--report", work / "evaluate.html")
    return json.loads(out.read_text())


def render_and_train(work):
    must("simulate", shortened(work, "wave.yaml", 2, 120), "--out", work / "wave")
    must("simulate", shortened(work, "drive.yaml", 4, 80), "--out", work / "drive")
    must("simulate", shortened(work, "lamps.yaml", 8, 40), "--out", work / "lamps")
    must("train", "--target", work / "scenes/bar_a.yaml", "--recording", work / "wave", "--out", work / "a.yaml",
         "--report", work / "train.html", "--json", work / "train.json")
    must("train", "--target", work / "scenes/bar_b.yaml", "--camera", work / "wave/cam0/sensor.yaml", "--out",
         work / "b.yaml")


def calibrate(work):
    arguments = ["calibrate", "--recording", work / "wave", "--model", work / "a.yaml", "--camera",
                 work / "wave/cam0/sensor.yaml", "--camera", work / "wave/cam1/sensor.yaml", "--out"]
    must(*arguments, work / "rig.yaml", "--report", work / "calibrate.html", "--json", work / "calibrate.json")
    must(*arguments, work / "again.yaml")
    table = {part["key"]: part["rows"] for part in json.loads((work / "calibrate.json").read_text())["parts"]
             if "rows" in part}
    expect([row["distance_m"] for row in table["predictions"]] == [30, 70, 110], f"predictions: {table['predictions']}")
    expect({row["parameter"] for row in table["intrinsics"]} == {"fu", "fv", "cu", "cv", "k1"}, "the lenses are told")
    rig = (work / "rig.yaml").read_text()
    expect(rig == (work / "again.yaml").read_text(), "the same recording gives the same rig file")
    baseline_m = float(re.search(r"baseline_m: (\S+)", rig).group(1))
    expect(abs(baseline_m - 9) < 0.003, f"baseline {baseline_m} m is 9 m within 3 mm")
    told = must(*arguments, work / "lit.yaml", "--lights-at-rest", "--json", work / "lit.json")
    used, left, right = map(int, re.search(r"lights +(\d+) at rest used; (\d+) .* cam0, (\d+)", told).groups())
    expect(1 <= used <= min(left, right), f"of the four lamps some are at rest in both images: {told}")
    parts = json.loads((work / "lit.json").read_text())["parts"]
    region = next(part["facts"]["wave_next"] for part in parts if "facts" in part)
    expect(re.fullmatch(r"((upper|lower) )?(left|middle|right), \d+ to \d+ m", region) and region in told,
           f"the region to wave next is in the text and the JSON: {region}")


def track_drive(work):
    arguments = ["track", "--recording", work / "drive", "--rig", work / "rig.yaml", "--model", work / "a.yaml",
                 "--model", work / "b.yaml", "--out"]
    must(*arguments, work / "drive.csv")
    must(*arguments, work / "drive_again.csv")
    expect((work / "drive.csv").read_bytes() == (work / "drive_again.csv").read_bytes(),
           "two runs over a recording give the same bytes")
    result = figures(work, "drive.csv", work / "drive/truth.csv")
    expect(result["false_positions"] == 0, "no false position on the drive")
    whole = [f for f in result["figures"] if f["to_m"] == 1000]
    expect(len(whole) == 2, "both bars are evaluated")
    for f in whole:
        expect(f["visible"] >= 60, f"{f['target']}: visible in {f['visible']} of 80 frames")
        expect(f["tracked_pct"] >= 99, f"{f['target']}: {f['tracked_pct']} % tracked, 99 are due")
        expect(f["flips"] == 0, f"{f['target']}: turned round {f['flips']} times")
    for f in result["figures"]:
        if f["to_m"] <= 50:
            expect(f["bar_mae_m"] < 0.005, f"{f['target']} to {f['to_m']} m: bar off by {f['bar_mae_m']} m")
            expect(f["rms_m"] < 0.005, f"{f['target']} to {f['to_m']} m: position off by {f['rms_m']} m")


def track_lamps(work):
    must("track", "--recording", work / "lamps", "--rig", work / "rig.yaml", "--model", work / "a.yaml", "--model",
         work / "b.yaml", "--out", work / "lamps.csv")
    rows = [line.split(",") for line in (work / "lamps.csv").read_text().splitlines()[1:]]
    expect(len(rows) == 2 * 40, f"{len(rows)} rows for 40 pairs and two targets")
    found = [row for row in rows if row[3] != "lost"]
    expect(not found, f"nothing is reported among sixty lamps, but: {found[:1]}")


def read_reports(work):
    for name, plots in [("train", 5), ("calibrate", 7), ("evaluate", 4)]:
        page = (work / f"{name}.html").read_text()
        expect(page.count("<svg ") == plots, f"{name}: {page.count('<svg ')} drawings, not {plots}")
        expect("http" not in page and "<script" not in page, f"{name}: the page needs something from elsewhere")
    for name in ["train", "calibrate"]:
        expect(json.loads((work / f"{name}.json").read_text())["tool"] == name, f"{name}: JSON names its tool")


def design_targets(work):
    told = must("target", "design", "--length-m", "1", "--distance-m", "110", "--noise-px", "0.05", "--count", "15",
                "--out", work / "bars")
    expect(told.count("leds_m: [") == 15, f"15 bars of 1 m at 110 m: {told}")
    must("train", "--target", work / "bars/bar_15.yaml", "--other", work / "a.yaml", "--out", work / "bar_15.yaml")


def refused(work, code, parts, *arguments):
    """The command must end with `code` and one line that holds `parts`, and leave nothing behind."""
    before = sorted(path.name for path in work.iterdir())
    done = run(*arguments)
    name = " ".join(str(a) for a in arguments)
    expect(done.returncode == code, f"exit {done.returncode}, not {code}: {name}: {done.stderr}")
    expect(done.stderr.count("\n") == 1 and done.stderr.endswith("\n"), f"not one line: {name}: {done.stderr!r}")
    for part in parts:
        expect(part in done.stderr, f"'{part}' is not in: {done.stderr}")
    expect(done.stdout == "", f"stdout is not empty: {name}: {done.stdout}")
    after = sorted(path.name for path in work.iterdir())
    expect(before == after, f"left behind by {name}: {set(after) - set(before)}")


def edited(work, source, name, old, new):
    text = (work / source).read_text()
    changed = re.sub(old, new, text, count=1)
    if changed == text:
        sys.exit(f"FAILED: nothing to edit in {source}: {old}")
    (work / name).write_text(changed)
    return work / name


def refuse_files(work):
    def track(rig, model, recording=work / "drive", out=work / "x.csv"):
        return ["track", "--recording", recording, "--rig", rig, "--model", model, "--out", out]

    rig, model = work / "rig.yaml", work / "a.yaml"
    refused(work, 1, ["none.yaml"], *track(work / "none.yaml", model))
    refused(work, 1, ["none"], *track(rig, model, work / "none"))
    refused(work, 1, ["folder"], *track(rig, model, out=work / "folder/x.csv"))
    bad = edited(work, "rig.yaml", "bad_rig.yaml", r"intrinsics: \[", "intrinsics: [[")
    refused(work, 2, ["bad_rig.yaml:"], *track(bad, model))
    bad = edited(work, "rig.yaml", "bad_rig.yaml", r"calibration_id", "calibration_idd")
    refused(work, 2, ["bad_rig.yaml: calibration_idd"], *track(bad, model))
    bad = edited(work, "rig.yaml", "bad_rig.yaml", r"(- \[0\.9[^\]]*, )-(8\.\d+\])", r"\1\2")
    refused(work, 2, ["bad_rig.yaml: cam1.T_cn_cnm1", "baseline sign"], *track(bad, model))
    bad = edited(work, "rig.yaml", "bad_rig.yaml", r"1400, 1024", "1280, 1024")
    refused(work, 2, [".png", "1400 x 1024", "1280 x 1024", "bad_rig.yaml"], *track(bad, model))
    bad = edited(work, "a.yaml", "bad_model.yaml", r"leds_m: .*", "leds_m: [0, 0.25, 1.5]")
    refused(work, 2, ["bad_model.yaml: leds_m", "a list of 4"], *track(rig, bad))
    bad = edited(work, "a.yaml", "bad_model.yaml", r"epicenter_m", "epicentre_m")
    refused(work, 2, ["bad_model.yaml: epicenter_m"], *track(rig, bad))
    refused(work, 2, ["a.yaml", "name"], *track(rig, model), "--model", model)


def refuse_work(work):
    target, sensor = work / "scenes/bar_a.yaml", work / "wave/cam0/sensor.yaml"
    refused(work, 2, ["--distances", "'110:5'"], "train", "--target", target, "--distances", "110:5", "--out",
            work / "x.yaml")
    refused(work, 1, ["lamps", "'bar_a'"], "train", "--target", target, "--recording", work / "lamps", "--out",
            work / "x.yaml")
    refused(work, 2, ["--discard 77", "no image"], "train", "--target", target, "--recording", work / "drive",
            "--discard", "77", "--out", work / "x.yaml")
    refused(work, 2, ["--apply", "--recording"], "train", "--target", target, "--apply", "--out", work / "x.yaml")
    refused(work, 1, ["--count 99", "more than fit"], "target", "design", "--length-m", "1", "--distance-m", "110",
            "--noise-px", "0.05", "--count", "99")
    calibrate_lamps = ["calibrate", "--recording", work / "lamps", "--model", work / "a.yaml", "--out",
                       work / "x.yaml", "--camera", sensor]
    refused(work, 2, ["--camera", "twice"], *calibrate_lamps)
    refused(work, 1, ["lamps", "bars identified in both images"], *calibrate_lamps, "--camera", sensor)
    # The same bars again would make every sigma too small.
    again = ["--recording", work / "wave", "--recording", f"{work}/./wave/", "--out", work / "x.yaml"]
    refused(work, 2, ["wave", "named twice"], "calibrate", *again, "--model", work / "a.yaml", "--camera", sensor,
            "--camera", sensor)
    refused(work, 2, ["wave", "named twice"], "train", *again, "--target", target)
    other = edited(work, "wave/cam0/sensor.yaml", "small.yaml", r"1400, 1024", "700, 512")
    refused(work, 2, [".png", "1400 x 1024", "700 x 512", "small.yaml"], *calibrate_lamps, "--camera", other)
    cut = work / "cut.csv"
    cut.write_text((work / "drive.csv").read_text()[:2000])
    refused(work, 2, ["cut.csv"], "evaluate", "--track", cut, "--truth", work / "drive/truth.csv")
    refused(work, 1, ["truth.csv", "nothing to compare"], "evaluate", "--track", work / "lamps.csv", "--truth",
            work / "lamps/truth.csv")
    refused(work, 2, ["--trackk"], "evaluate", "--track", cut, "--truth", cut, "--trackk", cut)


def main():
    with tempfile.TemporaryDirectory(prefix="adit_offline_") as folder:
        work = pathlib.Path(folder)
        shutil.copytree(SCENES, work / "scenes")
        for step in [render_and_train, calibrate, track_drive, track_lamps, read_reports, design_targets, refuse_files, refuse_work]:
            print(f"-- {step.__name__}", flush=True)
            step(work)
    print(f"{len(FAULTS)} faults")
    return 1 if FAULTS else 0


if __name__ == "__main__":
    sys.exit(main())
