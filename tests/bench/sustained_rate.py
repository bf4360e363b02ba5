"""The highest rate at which two simulated cameras and aditd lose nothing on this machine, and what gives in first above it.
Cameras serve frames rendered ahead, so their cost is that of sending; they and the box have real-time rights where the
system grants them. Usage: sustained_rate.py BIN_FOLDER SCENES SCRATCH [--seconds N]"""
import argparse
import os
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import box_stage

RESOLUTIONS = ((1400, 1024), (2448, 2048))
FIRST_HZ, STEP = 60, 1.25
SETTLE_S = 3  # connections are made, caches and tables filled
LOSSES = ("missed", "incomplete", "starved", "shed_frames", "shed_blob_sets", "unpaired")


def processor_s(process_id):
    """Seconds of processor time so far, by thread name."""
    tick_s = 1 / os.sysconf("SC_CLK_TCK")
    used = {}
    for tid in os.listdir(f"/proc/{process_id}/task"):
        name, rest = open(f"/proc/{process_id}/task/{tid}/stat").read().split("(", 1)[1].rsplit(")", 1)
        user, system = rest.split()[11:13]
        used[name] = used.get(name, 0) + (int(user) + int(system)) * tick_s
    return used


def since(before, after):
    return {name: after[name] - before.get(name, 0) for name in after}


def run(options, resolution, rate_hz):
    """One rate: (lost by kind, pairs a second, cores by thread)."""
    scratch, programs = pathlib.Path(options.scratch), pathlib.Path(options.bin_folder)
    box_stage.make_box(programs / "adit", pathlib.Path(options.scenes), scratch, rate_hz, box_stage.BOX_PRIORITY, resolution)
    cameras = box_stage.start_cameras(programs / "adit", scratch / "scene.yaml")
    box = box_stage.start(programs / "aditd", "--config", scratch / "box.yaml", "--status")
    time.sleep(SETTLE_S)
    first, start_s = box_stage.Report(scratch / "health.yaml"), time.monotonic()
    used = processor_s(box.pid), processor_s(cameras.pid)
    time.sleep(options.seconds)
    cores = {**since(used[0], processor_s(box.pid)), "cameras": sum(since(used[1], processor_s(cameras.pid)).values())}
    last, elapsed_s = box_stage.Report(scratch / "health.yaml"), time.monotonic() - start_s
    box_stage.stop(box)
    skipped = box_stage.skipped_triggers(box_stage.stop(cameras))
    counted = since(first.counters, last.counters)
    lost = {"skipped by the cameras": skipped, **{name: counted[f"left.{name}"] + counted[f"right.{name}"] for name in LOSSES}}
    # From when to when the reports count, they say themselves; both are written once a second.
    pairs_hz = counted["pairs"] / (last.uptime_s - first.uptime_s)
    return {k: n for k, n in lost.items() if n}, pairs_hz, {k: s / elapsed_s for k, s in cores.items()}


def find_highest(options, resolution):
    rate_hz, held_hz = FIRST_HZ, 0
    while True:
        lost, pairs_hz, cores = run(options, resolution, round(rate_hz))
        busiest = sorted(cores.items(), key=lambda item: -item[1])[:4]
        print(f"{resolution[0]} x {resolution[1]} at {rate_hz:4.0f} Hz: {pairs_hz:6.1f} pairs/s, lost {lost or 'nothing'}; cores: "
              f"{sum(cores.values()):.2f} of {os.cpu_count()}; " + ", ".join(f"{n} {c:.2f}" for n, c in busiest), flush=True)
        if lost or pairs_hz < 0.99 * round(rate_hz):
            return held_hz
        held_hz, rate_hz = round(rate_hz), rate_hz * STEP
        if rate_hz > 1000:  # what box.yaml allows
            return held_hz


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bin_folder")
    parser.add_argument("scenes")
    parser.add_argument("scratch")
    parser.add_argument("--seconds", type=float, default=10, help="at each rate")
    options = parser.parse_args()
    box_stage.enter_namespace()
    for resolution in RESOLUTIONS:
        held_hz = find_highest(options, resolution)
        megabytes = 2 * held_hz * resolution[0] * resolution[1] / 1e6
        print(f"{resolution[0]} x {resolution[1]}: {held_hz} Hz sustained, {megabytes:.0f} MB/s of images", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
