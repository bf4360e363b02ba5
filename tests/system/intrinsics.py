"""`adit intrinsics` on images of a chessboard. Usage: intrinsics.py ADIT IMAGES"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ADIT = sys.argv[1]
IMAGES = pathlib.Path(sys.argv[2])
LEFT = sorted(IMAGES.glob("left*.jpg"))
FAULTS = []


def expect(condition, what):
    if not condition:
        FAULTS.append(what)
        print("FAILED:", what, flush=True)


def intrinsics(*arguments):
    return subprocess.run([ADIT, "intrinsics", *map(str, arguments)], capture_output=True, text=True, check=False)


def refused(work, code, parts, *arguments):
    """Ends with `code` and one line that holds `parts`, and leaves no camera file."""
    out = work / "refused.yaml"
    done = intrinsics(*arguments, "--out", out)
    name = " ".join(str(a) for a in arguments)
    expect(done.returncode == code, f"exit {done.returncode}, not {code}: {name}: {done.stderr}")
    expect(done.stderr.count("\n") == 1 and done.stderr.endswith("\n"), f"not one line: {name}: {done.stderr!r}")
    for part in parts:
        expect(part in done.stderr, f"'{part}' is not in: {done.stderr}")
    expect(done.stdout == "", f"stdout is not empty: {name}: {done.stdout}")
    expect(not out.exists(), f"left a camera file: {name}")


def calibrate(work):
    board = ["--board", "9x6", "--square-m", "0.025"]
    stray = work / "nothing.png"
    subprocess.run([sys.executable, "-c", PLAIN_PNG, str(stray)], check=True)
    done = intrinsics(*LEFT, stray, *board, "--out", work / "cam0.yaml", "--coverage", work / "cam0.png")
    print(done.stdout, end="")
    expect(done.returncode == 0 and done.stderr == "", f"exit {done.returncode}: {done.stderr}")
    expect(re.search(r"nothing\.png +left out: no board found", done.stdout), "the image without a board is named")
    expect("13 of 14 used" in done.stdout, "13 of 14 images count")
    text = (work / "cam0.yaml").read_text()
    focal_px = float(re.search(r"intrinsics: \[([\d.]+)", text).group(1))
    # cv::calibrateCamera on corners refined in 11 x 11 px gives 533.09 px.
    expect(abs(focal_px - 533.09) < 1, f"focal length {focal_px} px")
    expect((work / "cam0.png").read_bytes()[:4] == b"\x89PNG", "the coverage is a PNG")
    intrinsics(*LEFT, stray, *board, "--out", work / "again.yaml")
    expect(text == (work / "again.yaml").read_text(), "the same images give the same file")


# A grey PNG of 640 x 480 px by the standard library.
PLAIN_PNG = """
import struct, sys, zlib
def chunk(name, data):
    return struct.pack('>I', len(data)) + name + data + struct.pack('>I', zlib.crc32(name + data))
rows = (b'\\0' + bytes([90]) * 640) * 480
open(sys.argv[1], 'wb').write(b'\\x89PNG\\r\\n\\x1a\\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', 640, 480, 8, 0, 0, 0, 0))
                              + chunk(b'IDAT', zlib.compress(rows)) + chunk(b'IEND', b''))
"""


def refuse(work):
    board = ["--board", "9x6", "--square-m", "0.025"]
    refused(work, 2, ["none.png", "neither an image file nor a folder"], work / "none.png", *board)
    (work / "empty").mkdir()
    refused(work, 2, ["empty", "holds no images"], work / "empty", *board)
    half = work / "half.jpg"
    half.write_bytes(LEFT[0].read_bytes()[:9000])
    refused(work, 2, ["half.jpg", "is not a whole image"], half, *board)
    small = work / "small.pgm"
    small.write_bytes(b"P5 320 240 255\n" + bytes(320 * 240))
    refused(work, 2, ["small.pgm", "320 x 240 px", "640 x 480 px", "left01.jpg"], LEFT[0], small, *board)
    refused(work, 2, ["named twice", "left01.jpg"], LEFT[0], LEFT[0], *board)
    refused(work, 2, ["--board", "found in none of the 2 images"], *LEFT[:2], "--board", "11x8", "--square-m", "0.025")
    refused(work, 2, ["--board", "'9by6'"], *LEFT, "--board", "9by6", "--square-m", "0.025")
    refused(work, 2, ["--square-m"], *LEFT, "--board", "9x6", "--square-m", "0")
    refused(work, 2, ["--charuco", "'DICT_9X9'"], *LEFT, *board, "--charuco", "DICT_9X9", "--marker-m", "0.02")
    refused(work, 2, ["--marker-m", "0.03"], *LEFT, *board, "--charuco", "DICT_4X4_50", "--marker-m", "0.03")
    refused(work, 1, ["3 of 3 images can be used; at least 5 are needed"], *LEFT[:3], *board)
    done = intrinsics(*LEFT, *board, "--out", work / "folder/cam0.yaml")
    expect(done.returncode == 1 and "folder" in done.stderr, f"a missing folder is named: {done.stderr}")


def main():
    work = pathlib.Path(tempfile.mkdtemp(prefix="adit-intrinsics-"))
    try:
        calibrate(work)
        refuse(work)
    finally:
        shutil.rmtree(work)
    return 1 if FAULTS else 0


if __name__ == "__main__":
    sys.exit(main())
