"""A camera vanishes for 10 s and comes back, while aditd runs: what a machine on the bus is told, and when. The frames are
decoded here from the layout of docs/adit-can.md, with no code of the box. Usage: vanish.py ADIT ADITD SCENES SCRATCH"""
import pathlib
import re
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import box_stage

AWAY_S = 10
NODE = 0x20
POS_E, STATUS = 0x180 + NODE, 0x480 + NODE
INVALID, VALID, SIMULATED = 0, 1, 3
FAULT_CAMERA_A = 1 << 0
INVALID_LIMIT_S = 0.100
BACK_LIMIT_S = 7.0


def tell(cameras, order):
    """Gives the cameras an order; when it took effect, in s."""
    cameras.stdin.write(order + "\n")
    cameras.stdin.flush()
    for line in cameras.stdout:
        if line.startswith("did_ns "):
            return int(line.split()[1]) * 1e-9
    sys.exit("FAILED: the cameras ended")


def frames(log, identifier):
    """(time in s, the eight bytes) of all frames with this id."""
    found = re.findall(r"^\((\d+\.\d+)\) \S+ ([0-9A-F]+)#([0-9A-F]{16})$", log.read_text(), re.M)
    return [(float(t), bytes.fromhex(data)) for t, i, data in found if int(i, 16) == identifier]


def validity(data):
    return data[4] & 3


def faults(data):
    return data[1] | data[2] << 8


def judge(log, gone_s, back_s):
    positions, states = frames(log, POS_E), frames(log, STATUS)
    wrong = []
    before = [d for t, d in positions if gone_s - 1 < t < gone_s]
    if not before or any(validity(d) != SIMULATED for d in before):
        wrong.append("positions before the camera vanished")
    invalid = next((t for t, d in positions if t > gone_s and validity(d) == INVALID), None)
    if invalid is None or invalid - gone_s > INVALID_LIMIT_S:
        wrong.append(f"INVALID within {INVALID_LIMIT_S * 1e3:.0f} ms")
    if any(validity(d) in (VALID, SIMULATED) for t, d in positions if gone_s + INVALID_LIMIT_S < t < back_s):
        wrong.append("nothing valid while the camera is away")
    told = [faults(d) for t, d in states if gone_s + INVALID_LIMIT_S < t < back_s]
    if not told or any(not f & FAULT_CAMERA_A for f in told):
        wrong.append("the fault bit of camera A in every STATUS while it is away")
    longest = max(b[0] - a[0] for a, b in zip(states, states[1:]))
    if longest > 0.5:
        wrong.append(f"the bus heard of us all the time; {longest:.2f} s it did not")
    back = next((t for t, d in positions if t > back_s and validity(d) == SIMULATED), None)
    if back is None or back - back_s > BACK_LIMIT_S:
        wrong.append(f"positions again within {BACK_LIMIT_S} s")
    elif faults(states[-1][1]) & FAULT_CAMERA_A or validity(positions[-1][1]) != SIMULATED:
        wrong.append("the fault is over at the end")
    if invalid is not None and back is not None:
        print(f"INVALID after {(invalid - gone_s) * 1e3:.1f} ms, positions {back - back_s:.2f} s after the return, "
              f"longest silence on the bus {longest * 1e3:.0f} ms")
    return wrong


def main(adit, aditd, scenes, scratch):
    box_stage.enter_namespace()
    scratch = pathlib.Path(scratch)
    box_stage.make_box(adit, pathlib.Path(scenes), scratch)
    cameras = box_stage.start(adit, "serve", scratch / "scene.yaml")
    box = box_stage.start(aditd, "--config", scratch / "box.yaml", "--status")
    try:
        time.sleep(3)
        gone_s = tell(cameras, "left vanish")
        time.sleep(AWAY_S)
        back_s = tell(cameras, "left return")
        time.sleep(BACK_LIMIT_S + 1)
        ran_through = box.poll() is None
    finally:
        status = box_stage.stop(box).splitlines()
        box_stage.stop(cameras)
    wrong = judge(scratch / "can.log", gone_s, back_s)
    if not ran_through or box.returncode != 0:
        wrong.append(f"aditd runs through and ends with 0, not {box.returncode}")
    print(status[-2] if len(status) > 1 else status)
    for what in wrong:
        print("FAILED:", what)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:5]))
