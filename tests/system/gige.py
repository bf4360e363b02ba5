"""Runs a program where only the loopback exists. Usage: gige.py PROGRAM [ARGUMENTS]"""
import os
import sys

enter = ["unshare", "-n"] if os.geteuid() == 0 else ["unshare", "-Urn"]
os.execvp(enter[0], enter + ["bash", "-c", 'ip link set lo up && exec "$@"', "namespace", *sys.argv[1:]])
