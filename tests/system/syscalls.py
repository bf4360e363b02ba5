"""What aditd's hot threads ask of the kernel while it follows a target: wake-ups and sends, nothing else. Watches them with
strace. Usage: syscalls.py ADIT ADITD SCENES SCRATCH"""
import collections
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import box_stage

SKIPPED = 77
WATCHED_S = 2
CALLS_MIN = 20  # of a thread that works at 60 Hz, in 2 s; fewer: it was not watched
# restart_syscall: a wait that the watching itself interrupted. write: the CAN log, which stands for the bus here.
ALLOWED = {name: {"futex", "restart_syscall"} for name in box_stage.HOT_THREADS}
ALLOWED["publish"] = ALLOWED["publish"] | {"write"}
# A machine without a clock that user space can read pays a system call for each look at it.
CLOCK = {"clock_gettime"}


def watch(process_id, log):
    """System calls by thread name; None if nobody may watch here."""
    ids = box_stage.threads(process_id)
    command = ["strace", "-q", "-o", log]
    for name in box_stage.HOT_THREADS:
        command += ["-p", str(ids[name])]
    strace = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    time.sleep(WATCHED_S)
    strace.send_signal(signal.SIGINT)
    said = strace.communicate(timeout=20)[1]
    if "not permitted" in said:
        print("skipped:", said.splitlines()[0])
        return None
    calls = {name: collections.Counter() for name in box_stage.HOT_THREADS}
    names = {str(tid): name for name, tid in ids.items()}
    for tid, call in re.findall(r"(?m)^(\d+)\s+(?:<\.\.\. )?(\w+)[( ]", log.read_text()):
        if tid in names:
            calls[names[tid]][call] += 1
    return calls


def main(adit, aditd, scenes, scratch):
    if shutil.which("strace") is None:
        print("skipped: there is no strace")
        return SKIPPED
    box_stage.enter_namespace()
    scratch = pathlib.Path(scratch)
    box_stage.make_box(adit, pathlib.Path(scenes), scratch)
    cameras = box_stage.start(adit, "serve", scratch / "scene.yaml")
    box = box_stage.start(aditd, "--config", scratch / "box.yaml", "--status")
    try:
        time.sleep(2)
        calls = watch(box.pid, scratch / "strace.log")
    finally:
        box_stage.stop(box)
        box_stage.stop(cameras)
    if calls is None:
        return SKIPPED
    wrong = []
    for name, counts in calls.items():
        print(f"{name:14}", dict(counts))
        if sum(counts.values()) < CALLS_MIN:
            wrong.append(f"{name} was seen in {sum(counts.values())} calls only")
        wrong += [f"{name} calls {call}" for call in counts if call not in ALLOWED[name] | CLOCK]
    located = box_stage.Report(scratch / "health.yaml").counters["located"]
    if located < 60 * WATCHED_S:
        wrong.append(f"only {located} positions: that was no steady state")
    for what in wrong:
        print("FAILED:", what)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:5]))
