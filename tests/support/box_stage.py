"""Two simulated cameras and aditd in a network namespace of their own, for scripts that watch them."""
import os
import re
import shutil
import subprocess
import sys

BOX = """serial: 7
simulation: true
rig: rig.yaml
models: [model.yaml]
cameras: {{left: {{device: 127.0.0.1}}, right: {{device: 127.0.0.2}}, rate_hz: {rate_hz}, exposure_us: 1000}}
publish: {{can: {{driver: candump, log: can.log, node: 32}}, modbus: {{enabled: false}}}}
realtime: {{priority: {priority}}}
health_report: health.yaml
"""


def enter_namespace():
    """Runs this script again where only the loopback exists; returns there."""
    if os.environ.get("ADIT_NAMESPACE"):
        return
    enter = ["unshare", "-n"] if os.geteuid() == 0 else ["unshare", "-Urn"]
    inside = 'ip link set lo up && ip addr add 127.0.0.2/8 dev lo && exec "$@"'
    os.environ["ADIT_NAMESPACE"] = "inside"
    os.execvp(enter[0], enter + ["bash", "-c", inside, "namespace", sys.executable, *sys.argv])


def make_box(adit, scenes, scratch, rate_hz=60, priority=0, resolution=None):
    """Files of a box that looks at still.yaml, in `scratch`, made anew: scene.yaml, rig.yaml, model.yaml, box.yaml."""
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    for bar in scenes.glob("bar_*.yaml"):
        shutil.copy(bar, scratch)
    scene = (scenes / "still.yaml").read_text()
    if resolution:
        width, height = resolution
        scene = re.sub(r"centre_px: \[[^]]*\]", f"centre_px: [{width / 2}, {height / 2}]", scene)
        scene = scene.replace("  base_m: 9\n", f"  base_m: 9\n  width_px: {width}\n  height_px: {height}\n")
    scene = re.sub(r"(?m)^rate_hz: .*$", f"rate_hz: {rate_hz}", scene)
    (scratch / "scene.yaml").write_text(scene)
    (scratch / "short.yaml").write_text(re.sub(r"(?m)^frames: .*$", "frames: 2", scene))
    for step in (["simulate", scratch / "short.yaml", "--out", scratch / "recording"],
                 ["train", "--target", scratch / "bar_a.yaml", "--camera", scratch / "recording/cam0/sensor.yaml",
                  "--out", scratch / "model.yaml"]):
        subprocess.run([adit, *step], check=True, stdout=subprocess.DEVNULL)
    shutil.copy(scratch / "recording/rig_true.yaml", scratch / "rig.yaml")
    (scratch / "box.yaml").write_text(BOX.format(rate_hz=rate_hz, priority=priority))


def start(*command):
    """A program that says when it runs."""
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    for line in process.stdout:
        if line.startswith(("serving", "running")):
            return process
    sys.exit(f"FAILED: {command[0]} did not start")


CAMERA_PRIORITY, BOX_PRIORITY = 40, 50  # SCHED_FIFO; whoever receives goes before who sends


def start_cameras(adit, scene):
    """Cameras that serve frames rendered ahead. They are devices of their own, so they go before all that is ordinary here."""
    cameras = start(adit, "serve", scene, "--ahead", "16")
    try:
        for tid in os.listdir(f"/proc/{cameras.pid}/task"):
            os.sched_setscheduler(int(tid), os.SCHED_FIFO, os.sched_param(CAMERA_PRIORITY))
    except PermissionError:
        print("the simulated cameras run like any program here: what they are late with is not adit's")
    return cameras


def skipped_triggers(said):
    """How many images the simulated cameras were too late to send, from what they said at their end."""
    return sum(int(number) for number in re.findall(r"(?m)^late (\d+)$", said))


def stop(process):
    """Ends it in its own way; what it still said."""
    process.terminate()
    return process.communicate(timeout=20)[0]


class Report:
    """A health report: `counters` by name, `latency` by span (count, negative, p50_us, p99_us, p999_us, max_us)."""

    def __init__(self, path):
        text = path.read_text()
        self.counters = {name: int(count) for name, count in re.findall(r"(?m)^  ([\w.]+): (\d+)$", text)}
        self.latency = {}
        for span, rest in re.findall(r"(?m)^  - {span: (\w+), (.*)}$", text):
            self.latency[span] = {key: float(value) for key, value in re.findall(r"(\w+): ([\d.]+)", rest)}
        self.uptime_s = float(re.search(r"(?m)^uptime_s: (.*)$", text).group(1))
        self.refused = "".join(re.findall(r'(?m)^realtime: "(.*)"$', text))

    def unaccounted(self, side):
        """Frames of a side that are neither shed nor in a pair nor without a partner; 0 in the last report of a box."""
        count = lambda name: self.counters[f"{side}.{name}"]
        gone = sum(count(name) for name in ("shed_frames", "shed_blob_sets", "unpaired", "at_ends"))
        return count("frames") - gone - self.counters["pairs"]


def threads(process_id):
    """Thread id by name; the hot ones carry the names that PrepareThread gave them."""
    folder = f"/proc/{process_id}/task"
    return {open(f"{folder}/{tid}/comm").read().strip(): int(tid) for tid in os.listdir(folder)}


HOT_THREADS = ("grab-left", "grab-right", "detect-left", "detect-right", "pair", "publish")
