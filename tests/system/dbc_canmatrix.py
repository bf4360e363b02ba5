"""canmatrix loads docs/adit-can.dbc and decodes the golden set with it. Usage: dbc_canmatrix.py ROOT"""
import json
import pathlib
import sys

SKIPPED = 77
INFO_ID = 0x6A0


def faults_of_frames(matrix, expected):
    faults = []
    for arbitration_id, payload, signals in expected:
        frame = matrix.frame_by_id(canmatrix.ArbitrationId(arbitration_id))
        if frame is None:
            faults.append(f"0x{arbitration_id:X}: not in the DBC")
            continue
        decoded = frame.decode(bytes.fromhex(payload))
        values = {name: signal.raw_value for name, signal in decoded.items()}
        if values != signals:
            faults.append(f"0x{arbitration_id:X}#{payload}: {values}, not {signals}")
    return faults


def faults_of_attributes(matrix):
    """Every protected frame says its profile and data id: 0xA000, node 0x20, slots 0 to 14."""
    ids = sorted(int(frame.attribute("E2EDataID", matrix)) for frame in matrix.frames)
    faults = [] if ids == [0xA200 + slot for slot in range(15)] else [f"data ids {ids}"]
    faults += [f"{f.name}: profile {f.attribute('E2EProfile', matrix)}" for f in matrix.frames
               if int(f.attribute("E2EProfile", matrix)) != 5]
    return faults


def faults_of_info(matrix):
    """INFO is multiplexed: index 4 is E0 = -2 and nothing else."""
    frame = matrix.frame_by_id(canmatrix.ArbitrationId(INFO_ID))
    decoded = frame.decode(bytes([4]) + (-2).to_bytes(4, "little", signed=True) + bytes([0, 0, 9]))
    values = {name: signal.raw_value for name, signal in decoded.items()}
    wanted = {"InfoIndex": 4, "InfoE0": -2, "INFO_CRC": 0, "INFO_Epoch": 9}
    return [] if values == wanted else [f"INFO: {values}, not {wanted}"]


def main(root):
    data = pathlib.Path(root, "tests/data/can_golden_expected.json")
    expected = json.loads(data.read_text())
    matrix = canmatrix.formats.loadp_flat(str(pathlib.Path(root, "docs/adit-can.dbc")))
    faults = faults_of_frames(matrix, expected) + faults_of_attributes(matrix) + faults_of_info(matrix)
    print("\n".join(faults[:10]))
    print(f"{len(expected)} frames, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    try:
        import canmatrix
        import canmatrix.formats
    except ImportError:
        print("python3-canmatrix is not installed")
        sys.exit(SKIPPED)
    sys.exit(main(sys.argv[1]))
