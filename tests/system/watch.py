"""The right camera has turned since the calibration: what machines, the operator and the health report are told, and that
`adit rig correct` mends it. CAN and Modbus are read here from the layouts in docs/, with no code of the box.
Usage: watch.py ADIT ADITD SCENES SCRATCH"""
import math
import pathlib
import re
import shutil
import socket
import struct
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import box_stage

TURN_URAD = 500  # yaw; the calibration says it may be off by 30
NODE, PORT = 0x20, 15020
VALID, DEGRADED = 1, 2
TRACK_STATE, DEGRADED_STATE = 2, 3
FAULT_RESIDUAL = 1 << 6

SCENE = """seed: 5
rate_hz: 20
frames: 240
exposure_s: 0.0005
frame: middle
rig: {base_m: 9, focal_px: 1689, converge_m: 35, width_px: 700, height_px: 512,
      left: {centre_px: [349.5, 255.5]}, right: {centre_px: [349.5, 255.5]}}
sensor: {psf_sigma_px: 1.3}
machines:
  - drive: {from_m: [0, 0, 20], to_m: [0, 0, 40], duration_s: 12, weave_m: 0.3, weave_period_s: 5}
    targets:
      - {file: bar_a.yaml, reference_m: 30, at_m: [-1.7, 0.4, 0], direction: [0.94, -0.33, 0.08]}
      - {file: bar_b.yaml, reference_m: 30, at_m: [0.2, -0.3, 0], direction: [0.92, 0.37, -0.1]}
"""
BOX = """serial: 7
rig: {rig}
models: [bar_a_model.yaml, bar_b_model.yaml]
cameras: {{driver: recording, recording: recording, rate_hz: 20, exposure_us: 500}}
publish: {{can: {{driver: candump, log: can.log, node: 32}}, modbus: {{enabled: true, bind: 127.0.0.1, port: 15020}}}}
realtime: {{priority: 0}}
health_report: health.yaml
"""
FAULTS = []


def expect(condition, what):
    if not condition:
        FAULTS.append(what)
        print("FAILED:", what, flush=True)


def run(*command, code=0):
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)
    expect(done.returncode == code, f"exit {done.returncode}, not {code}: {command}: {done.stderr}")
    return done


def stale_rig(true_rig):
    """The rig file of a calibration since which the right camera has turned in yaw: R_true = Exp(turn) R_file. It states
    what a good calibration does: 2, 30 and 4 urad of pitch, yaw and roll, 0.3 mm."""
    rows = [[float(x) for x in row.split(",")] for row in re.findall(r"(?m)^\s+- \[([^\]]*)\]$", true_rig)]
    back = -TURN_URAD * 1e-6
    c, s = math.cos(back), math.sin(back)
    turn = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    new = [[sum(turn[i][k] * rows[k][j] for k in range(3)) for j in range(4)] for i in range(3)] + [rows[3]]
    lines = iter(new)
    text = re.sub(r"(?m)^(\s+- )\[[^\]]*\]$", lambda m: m.group(1) + str([float(repr(x)) for x in next(lines)]), true_rig)
    variances = [4e-12, 9e-10, 16e-12, 9e-8, 9e-8, 9e-8] + 16 * [0]
    matrix = [[v if i == j else 0 for j in range(22)] for i, v in enumerate(variances)]
    text = re.sub(r"(?m)^calibration_id: .*$", 'calibration_id: "before"', text)
    return text + "covariance:\n" + "".join(f"  - {row}\n" for row in matrix)


def make_files(adit, scenes, scratch):
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    (scratch / "scene.yaml").write_text(SCENE)
    for bar in ("bar_a", "bar_b"):
        shutil.copy(scenes / f"{bar}.yaml", scratch)
    run(adit, "simulate", scratch / "scene.yaml", "--out", scratch / "recording")
    for bar in ("bar_a", "bar_b"):
        run(adit, "train", "--target", scratch / f"{bar}.yaml", "--camera", scratch / "recording/cam0/sensor.yaml",
            "--out", scratch / f"{bar}_model.yaml")
    (scratch / "rig.yaml").write_text(stale_rig((scratch / "recording/rig_true.yaml").read_text()))


def read_live():
    """State, validity and fault bits of Modbus registers 101, 102 and 120; nothing while nobody serves."""
    try:
        with socket.create_connection(("127.0.0.1", PORT), timeout=1) as plc:
            plc.sendall(struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, 100, 42))
            answer = b""
            while len(answer) < 9 + 84:
                more = plc.recv(256)
                if not more:
                    return None
                answer += more
    except OSError:
        return None
    words = struct.unpack(">42H", answer[9:93])
    return words[1], words[2], words[20] << 16 | words[21]


def can_epochs(log):
    """State, validity and fault bits of every epoch on the bus."""
    epochs, validity = [], None
    for identifier, data in re.findall(r"(?m)^\(\d+\.\d+\) \S+ ([0-9A-F]+)#([0-9A-F]{16})$", log.read_text()):
        data = bytes.fromhex(data)
        if int(identifier, 16) == 0x180 + NODE:
            validity = data[4] & 3
        elif int(identifier, 16) == 0x480 + NODE:
            epochs.append((data[0] & 15, validity, data[1] | data[2] << 8))
    return epochs


def drive(aditd, scratch, rig):
    """The whole recording with this rig: what Modbus and CAN told, stdout, stderr and the last health report."""
    (scratch / "box.yaml").write_text(BOX.format(rig=rig))
    (scratch / "can.log").unlink(missing_ok=True)
    box = subprocess.Popen([aditd, "--config", str(scratch / "box.yaml"), "--status"], stdout=subprocess.PIPE,
                           stderr=subprocess.PIPE, text=True)
    modbus = []
    while box.poll() is None:
        live = read_live()
        if live:
            modbus.append(live)
        time.sleep(0.1)
    out, err = box.communicate(timeout=20)
    expect(box.returncode == 0, f"aditd ends with {box.returncode}")
    return modbus, can_epochs(scratch / "can.log"), out, err, (scratch / "health.yaml").read_text()


def calibration_id(rig):
    return re.search(r'(?m)^calibration_id: "?([^"\n]*)"?$', rig.read_text()).group(1)


def numbers(text):
    return [float(x) for x in text.split(",")]


def judge_turned(adit, scratch, told):
    modbus, can, out, err, health = told
    for bus, epochs in (("Modbus", modbus), ("CAN", can)):
        with_position = [e for e in epochs if e[1] in (VALID, DEGRADED)]
        expect(with_position and with_position[0][:2] == (TRACK_STATE, VALID) and not with_position[0][2] & FAULT_RESIDUAL,
               f"{bus}: VALID before the turn is known: {with_position[:1]}")
        faulty = [e for e in with_position if e[2] & FAULT_RESIDUAL]
        expect(len(faulty) > len(with_position) / 3, f"{bus}: fault bit 6 in {len(faulty)} of {len(with_position)}")
        expect(all(e[:2] == (DEGRADED_STATE, DEGRADED) for e in faulty), f"{bus}: DEGRADED with the fault: {set(faulty)}")
    expect(re.search(r"status .* faults=0x0060 ", out), "the status line has fault bits 5 and 6")
    found = re.findall(r"watch verdict=changed .*turn_urad=(\S+) sigma_urad=(\S+)", out)
    expect(found, "a status line with the turn")
    for turn, sigma in found[-1:]:
        yaw, yaw_sigma = numbers(turn)[1], numbers(sigma)[1]
        print(f"yaw {yaw} +- {yaw_sigma} urad of {TURN_URAD}")
        expect(abs(yaw - TURN_URAD) < 4 * yaw_sigma, "the turn is right within what it says")
    expect(err.count("\n") == 1 and "rig.yaml: the calibration no longer holds" in err, f"one line to the operator: {err}")
    expect("verdict: changed" in health and f'id: "{calibration_id(scratch / "rig.yaml")}"' in health, health)
    advised = re.search(r"or: adit (rig correct .*)$", err)
    expect(advised is not None, "the command that applies the turn")
    if advised:
        run(adit, *advised.group(1).replace("NEW.yaml", str(scratch / "advised.yaml")).split())


def correct(adit, scratch):
    command = [adit, "rig", "correct", "--health", scratch / "health.yaml", "--out", scratch / "corrected.yaml", "--rig"]
    true_rig = scratch / "recording/rig_true.yaml"
    expect("calibration.id" in run(*command, true_rig, code=1).stderr, "a rig file of another calibration is refused")
    expect(not (scratch / "corrected.yaml").exists(), "nothing is left behind")
    run(*command, scratch / "rig.yaml")
    before, after = calibration_id(scratch / "rig.yaml"), calibration_id(scratch / "corrected.yaml")
    expect(before != after, "the correction is a new calibration")


def judge_corrected(scratch, told):
    modbus, can, out, err, health = told
    for bus, epochs in (("Modbus", modbus), ("CAN", can)):
        expect(not any(e[2] & FAULT_RESIDUAL for e in epochs), f"{bus}: no fault bit 6 with the new calibration")
        expect(any(e[:2] == (TRACK_STATE, VALID) for e in epochs), f"{bus}: VALID with the new calibration")
    expect("watch verdict=learning" in out and "verdict=changed" not in out, "the watch finds no turn any more")
    expect(err == "", f"nothing to tell the operator: {err}")
    expect(f'id: "{calibration_id(scratch / "corrected.yaml")}"' in health, "the report names the new calibration")


def main(adit, aditd, scenes, scratch):
    box_stage.enter_namespace()
    scratch = pathlib.Path(scratch)
    make_files(adit, pathlib.Path(scenes), scratch)
    judge_turned(adit, scratch, drive(aditd, scratch, "rig.yaml"))
    correct(adit, scratch)
    judge_corrected(scratch, drive(aditd, scratch, "corrected.yaml"))
    print(f"{len(FAULTS)} faults")
    return 1 if FAULTS else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:5]))
