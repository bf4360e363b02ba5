"""aditd at 60 Hz while every core is kept busy by others: is each image accounted for, and how late are the positions, with and
without real-time rights? Exit 1 if adit lost a pair. Usage: under_load.py BIN_FOLDER SCENES SCRATCH [--seconds N]
[--priority P ...]"""
import argparse
import contextlib
import os
import pathlib
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import box_stage

SETTLE_S = 3  # cameras and box are connected and both deliver
# In turn: a loop that computes, and one that copies more than any cache holds.
LOADS = ("while True: pass", "a = bytearray(64 << 20)\nwhile True: b = bytes(a)")


@contextlib.contextmanager
def load():
    """One busy process per core, and one more."""
    busy = [subprocess.Popen([sys.executable, "-c", LOADS[i % len(LOADS)]]) for i in range(os.cpu_count() + 1)]
    try:
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()


def run(options, priority):
    scratch, programs = pathlib.Path(options.scratch), pathlib.Path(options.bin_folder)
    box_stage.make_box(programs / "adit", pathlib.Path(options.scenes), scratch, priority=priority)
    cameras = box_stage.start_cameras(programs / "adit", scratch / "scene.yaml")
    box = box_stage.start(programs / "aditd", "--config", scratch / "box.yaml", "--status")
    time.sleep(SETTLE_S)
    settled = box_stage.Report(scratch / "health.yaml")
    with load():
        time.sleep(options.seconds)
        box_stage.stop(box)
    skipped = box_stage.skipped_triggers(box_stage.stop(cameras))
    print(f"\npriority {priority}, {options.seconds:.0f} s; triggers that a camera skipped: {skipped}")
    print(subprocess.run([programs / "adit", "latency", scratch / "box.yaml"], capture_output=True, text=True).stdout)
    return settled, box_stage.Report(scratch / "health.yaml"), skipped


def lost_in_adit(settled, report, skipped):
    """What the box lost itself under load, by name; an image whose partner never came from its camera is not among it."""
    count = {name: number - settled.counters[name] for name, number in report.counters.items()}
    lost = {"log_dropped": count["log_dropped"]}
    for side, other in (("left", "right"), ("right", "left")):
        for kind in ("shed_frames", "shed_blob_sets", "starved"):
            lost[f"{side}.{kind}"] = count[f"{side}.{kind}"]
        partnerless = skipped + count[f"{other}.missed"] + count[f"{other}.shed_frames"] + count[f"{other}.shed_blob_sets"]
        lost[f"{side}.unpaired"] = max(0, count[f"{side}.unpaired"] - partnerless)
        lost[f"{side}.unaccounted"] = report.unaccounted(side)
    return {name: number for name, number in lost.items() if number}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bin_folder")
    parser.add_argument("scenes")
    parser.add_argument("scratch")
    parser.add_argument("--seconds", type=float, default=30)
    parser.add_argument("--priority", type=int, nargs="*", default=[0, box_stage.BOX_PRIORITY])
    options = parser.parse_args()
    box_stage.enter_namespace()
    failed = False
    for priority in options.priority:
        settled, report, skipped = run(options, priority)
        lost, pairs = lost_in_adit(settled, report, skipped), report.counters["pairs"]
        missed = report.counters["left.missed"] + report.counters["right.missed"]
        print(f"pairs {pairs}, images lost before adit {missed}, lost in adit {lost or 'none'}", flush=True)
        failed = failed or bool(lost) or pairs < 0.9 * 60 * options.seconds
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
