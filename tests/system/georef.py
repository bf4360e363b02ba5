"""adit georef and aditd on a rendered recording. Usage: georef.py ADIT ADITD SCENES"""
import csv
import math
import pathlib
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile

ADIT, ADITD = sys.argv[1:3]
SCENES = pathlib.Path(sys.argv[3])
SEED = 5
PLACE_M, GRID_SCALE = (2612345.678, 1198765.432, 431.250), 0.9996
ORIGIN_M = [2612000, 1198000, 400]
FAULT_GEOREFERENCE = 1 << 5
FAULTS = []


def expect(condition, what):
    if not condition:
        FAULTS.append(what)
        print("FAILED:", what, flush=True)


def run(*arguments):
    return subprocess.run([*map(str, arguments)], capture_output=True, text=True, check=False)


def must(*arguments):
    done = run(*arguments)
    if done.returncode != 0 or done.stderr != "":
        sys.exit(f"FAILED: {' '.join(map(str, arguments))}: exit {done.returncode}: {done.stderr}")
    return done.stdout


def axes(azimuth_deg, pitch_deg, roll_deg):
    """Right, down and forward of the rig in easting, northing, height: plain trigonometry."""
    (sa, ca), (sp, cp), (sr, cr) = [(math.sin(a), math.cos(a)) for a in
                                    map(math.radians, (azimuth_deg, pitch_deg, roll_deg))]
    right, up, forward = (ca, -sa, 0), (-sa * sp, -ca * sp, cp), (sa * cp, ca * cp, sp)
    return ([cr * r - sr * u for r, u in zip(right, up)], [-sr * r - cr * u for r, u in zip(right, up)], forward)


def place(point):
    """Of a point of the rig frame in the site grid."""
    turned = [sum(axis[i] * x for axis, x in zip(axes(36, 3, -1), point)) for i in range(3)]
    return [PLACE_M[i] + (GRID_SCALE if i < 2 else 1) * turned[i] for i in range(3)]


def vector(row, prefix):
    return [float(row[f"{prefix}{axis}_m"]) for axis in "xyz"]


def survey(work):
    """Control points: the LEDs of both bars with 1 mm of noise in each coordinate."""
    noise, first = random.Random(SEED), {}
    print("seed", SEED)
    for row in csv.DictReader(open(work / "still/truth.csv", encoding="ascii")):
        first.setdefault(row["target"], row)
    return {f"{target}.{led}": [x + noise.gauss(0, 0.001) for x in place(vector(row, f"led{led}_"))]
            for target, row in first.items() for led in range(1, 5)}


def write_csv(path, points):
    lines = ["name,easting_m,northing_m,height_m"]
    path.write_text("\n".join(lines + [f"{n},{e:.4f},{north:.4f},{h:.4f}" for n, (e, north, h) in points.items()]) + "\n")


def write_gsi(path, points):
    """GSI-16 in 0.1 mm."""
    with open(path, "w", encoding="ascii", newline="") as file:
        for number, (name, enh) in enumerate(points.items(), 1):
            words = [f"{81 + i}..16{'-' if x < 0 else '+'}{round(abs(x) * 1e4):016d}" for i, x in enumerate(enh)]
            file.write(f"*11{number:04d}+{name.rjust(16, '0')} {' '.join(words)} \r\n")


def prepare(work):
    scene = re.sub(r"(?m)^frames: .*$", "frames: 30", (SCENES / "still.yaml").read_text())
    scene = re.sub(r"(?m)^rate_hz: .*$", "rate_hz: 10", scene)  # so slow that a busy machine keeps up
    (work / "scenes/short.yaml").write_text(scene)
    must(ADIT, "simulate", work / "scenes/short.yaml", "--out", work / "still")
    for bar in "ab":
        must(ADIT, "train", "--target", work / f"scenes/bar_{bar}.yaml", "--out", work / f"{bar}.yaml")
    must(ADIT, "track", "--recording", work / "still", "--rig", work / "still/rig_true.yaml", "--model",
         work / "a.yaml", "--model", work / "b.yaml", "--out", work / "track.csv")


def georef(work, points, *more):
    return [ADIT, "georef", "--rig", work / "still/rig_true.yaml", "--track", work / "track.csv", "--points", points,
            "--scale-factor", GRID_SCALE, "--out", work / "georef.yaml", *more]


def accept(work, points):
    write_gsi(work / "points.gsi", points)
    write_csv(work / "points.csv", points)
    report = must(*georef(work, work / "points.gsi", "--report", work / "georef.html"))
    expect((work / "georef.html").read_text().count("<svg ") == 3, "the page shows plan, hold-out and distances")
    expect("verdict      accepted" in report, "a good survey is accepted")
    from_gsi = re.sub("points.gsi.*|crc32.*", "", (work / "georef.yaml").read_text())
    must(*georef(work, work / "points.csv"))
    from_csv = re.sub("points.csv.*|crc32.*", "", (work / "georef.yaml").read_text())
    expect(from_gsi == from_csv, "CSV and GSI of the same points give the same georeference")
    must(ADIT, "track", "--recording", work / "still", "--rig", work / "still/rig_true.yaml", "--model",
         work / "a.yaml", "--model", work / "b.yaml", "--georef", work / "georef.yaml", "--out", work / "site.csv")
    truth = {(r["trigger"], r["target"]): r for r in csv.DictReader(open(work / "still/truth.csv", encoding="ascii"))}
    for row in csv.DictReader(open(work / "site.csv", encoding="ascii")):
        error = [a - b for a, b in zip(vector(row, ""), place(vector(truth[row["trigger"], row["target"]], "")))]
        sigma = [float(row[f"s{axis}_m"]) for axis in "xyz"]
        expect(all(abs(e) < 5 * s for e, s in zip(error, sigma)), f"{row['target']}: {error} m off, sigma {sigma}")


def refused(work, code, parts, arguments):
    before = (work / "georef.yaml").read_bytes()
    done = run(*arguments)
    expect(done.returncode == code, f"exit {done.returncode}, not {code}: {arguments}: {done.stderr}")
    expect(done.stderr.count("\n") == 1, f"not one line: {done.stderr!r}")
    for part in parts:
        expect(part in done.stderr, f"'{part}' is not in: {done.stderr}")
    expect((work / "georef.yaml").read_bytes() == before, f"the file before is kept: {arguments}")


def refuse(work, points):
    wrong = {name: list(enh) for name, enh in points.items()}
    wrong["bar_b.2"][0] += 0.020
    write_csv(work / "wrong.csv", wrong)
    refused(work, 1, ["wrong.csv", "bar_b.2 is suspected"], georef(work, work / "wrong.csv"))
    report = must(*georef(work, work / "wrong.csv", "--exclude", "bar_b.2"))
    expect("not used" in report, "an excluded point is compared")
    write_csv(work / "one.csv", {n: p for n, p in points.items() if n.startswith("bar_a")})
    refused(work, 1, ["one.csv", "one line", "mrad"], georef(work, work / "one.csv"))
    write_csv(work / "two.csv", {n: points[n] for n in ["bar_a.1", "bar_b.4"]})
    refused(work, 1, ["two.csv", "2 common points", "at least 3"], georef(work, work / "two.csv"))
    text = (work / "points.gsi").read_text()
    height = re.search(r"83\.\.16\+(\d{16})", text)
    (work / "bad.gsi").write_text(text.replace(height.group(1), "00000000000-----"))
    refused(work, 2, ["bad.gsi:1", "83..16+00000000000-----", "no value"], georef(work, work / "bad.gsi"))
    (work / "cut.gsi").write_text("110001+0bar_a.1 81..00+12367143 82..00+98799243 83..00+00432660\n")
    refused(work, 2, ["cut.gsi:1", "81..00+12367143", "--gsi8-offset-m"], georef(work, work / "cut.gsi"))
    # Nothing half written: neither the page without its georeference nor the other way round.
    refused(work, 1, ["absent/page.json"], georef(work, work / "wrong.csv", "--exclude", "bar_b.2", "--report",
                                                  work / "left.html", "--json", work / "absent/page.json"))
    expect(not (work / "left.html").exists(), "no page is left behind")
    refused(work, 2, ["two outputs"], georef(work, work / "points.csv", "--report", work / "georef.yaml"))
    refused(work, 1, ["none.csv"], georef(work, work / "none.csv"))
    refused(work, 2, ["--exclude P9", "points.csv"], georef(work, work / "points.csv", "--exclude", "P9"))
    refused(work, 2, ["--track, --recording"], georef(work, work / "points.csv", "--recording", work / "still"))
    refused(work, 2, ["--rms-limit-mm", "finite"], georef(work, work / "wrong.csv", "--rms-limit-mm", "nan"))
    refused(work, 2, ["--out", "--points"], [*georef(work, work / "points.csv")[:-1], work / "points.csv"])
    mistyped = {name.replace("bar_a.1", "bar_a.5"): enh for name, enh in points.items()}
    write_csv(work / "mistyped.csv", mistyped)
    report = must(*georef(work, work / "mistyped.csv"))
    expect("1 more in the control file, not in the track: bar_a.5" in report, "a mistyped point is told")
    must(*georef(work, work / "points.csv"))
    refused(work, 2, ["--parameters"], georef(work, work / "points.csv", "--parameters", "5"))


def box(work, more):
    """Runs the daemon on the recording; the states on the bus, of node 0x20, as (value, validity) and fault bits."""
    (work / "box.yaml").write_text(f"""rig: still/rig_true.yaml
models: [a.yaml, b.yaml]
{more}
cameras: {{driver: recording, recording: still, rate_hz: 10}}
publish:
  site_origin_m: {ORIGIN_M if more else [0, 0, 0]}
  can: {{driver: candump, log: can.log, cycle_ms: 20}}
""")
    (work / "can.log").unlink(missing_ok=True)
    must(ADITD, "--config", work / "box.yaml")
    eastings, faults = [], set()
    for line in (work / "can.log").read_text().splitlines():
        frame_id, data = line.split()[-1].split("#")
        payload = bytes.fromhex(data)
        if int(frame_id, 16) == 0x180 + 0x20 and payload[4] & 3 == 1:
            eastings.append(struct.unpack_from("<i", payload)[0] * 1e-4)
        if int(frame_id, 16) == 0x480 + 0x20 and payload[0] & 15 == 2:
            faults.add(struct.unpack_from("<H", payload, 1)[0] & FAULT_GEOREFERENCE)
    expect(eastings, "valid eastings are on the bus")
    return eastings, faults


def publish(work):
    truth = next(csv.DictReader(open(work / "still/truth.csv", encoding="ascii")))
    eastings, faults = box(work, "")
    expect(faults == {FAULT_GEOREFERENCE}, "without a georeference the fault bit is set")
    expect(all(abs(e - float(truth["x_m"])) < 0.01 for e in eastings), f"in the rig frame: {eastings[:3]}")
    eastings, faults = box(work, "georeference: georef.yaml")
    expect(faults == {0}, "with a georeference the fault bit is clear")
    due = place(vector(truth, ""))[0] - ORIGIN_M[0]
    expect(all(abs(e - due) < 0.01 for e in eastings), f"eastings {eastings[:3]} are {due} m from the origin")


def refuse_box(work):
    text = (work / "box.yaml").read_text()
    (work / "far.yaml").write_text(re.sub(r"site_origin_m: .*", "site_origin_m: [0, 0, 0]", text))
    done = run(ADITD, "--config", work / "far.yaml")
    expect(done.returncode == 2 and "publish.site_origin_m" in done.stderr, f"a far origin: {done.stderr}")
    other = (work / "georef.yaml").read_text().replace('calibration_id: "', 'calibration_id: "other ')
    (work / "other.yaml").write_text(other)
    (work / "stale.yaml").write_text(text.replace("georef.yaml", "other.yaml"))
    done = run(ADITD, "--config", work / "stale.yaml")
    expect(done.returncode == 2 and "other.yaml: calibration_id" in done.stderr, f"another rig: {done.stderr}")
    must(*georef(work, work / "points.csv", "--parameters", "7"))
    done = run(ADITD, "--config", work / "box.yaml")
    expect(done.returncode == 2 and "georef.yaml: parameters: is 7" in done.stderr, f"diagnosis: {done.stderr}")


def main():
    with tempfile.TemporaryDirectory(prefix="adit_georef_") as folder:
        work = pathlib.Path(folder)
        shutil.copytree(SCENES, work / "scenes")
        prepare(work)
        points = survey(work)
        for step in [accept, refuse]:
            step(work, points)
        for step in [publish, refuse_box]:
            step(work)
    print(f"{len(FAULTS)} faults")
    return 1 if FAULTS else 0


if __name__ == "__main__":
    sys.exit(main())
