// Recordings on disk in EuRoC/ASL layout: cam0/data.csv, cam0/data/<ns>.png, cam0/sensor.yaml, the same for
// cam1.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware/base/image.h"
#include "firmware/base/result.h"

namespace adit::recording {

/// One image file of a recording.
struct ImageEntry {
  base::TimeNs mid_exposure_ns = 0;
  std::string path;
};

/// The index of a recording; images are read when asked for.
struct Recording {
  std::string folder;
  std::vector<ImageEntry> left, right;  ///< ascending in time, none empty
};

/// Reads the two data.csv (`#timestamp [ns],filename`; lines that start with # and CRLF ends are accepted).
/// Refuses, with file and line: a missing folder or file, malformed lines, times that do not ascend, file
/// names that leave the folder, images that are not there, a camera without images.
base::Result<Recording> OpenRecording(const std::string& folder);

/// An image in memory, 8 or 16 bit.
struct StoredImage {
  std::vector<std::uint8_t> pixels;
  int width_px = 0, height_px = 0, bits = 8;
  base::ImageView View() const {
    return {pixels.data(), width_px, height_px, static_cast<std::ptrdiff_t>(width_px) * (bits > 8 ? 2 : 1),
            bits};
  }
};

/// Reads one grey PNG of 8 or 16 bit; declines with the file's name.
base::Result<StoredImage> ReadImage(const std::string& path);

/// The same as the camera delivered it: of 16 bit PNGs the upper 12, which is all that a camera of 10 or 12
/// bit said, and what the detection works with.
base::Result<StoredImage> ReadCameraImage(const std::string& path);

/// Writes a recording frame by frame. Images of 9 to 15 bit are stored in 16 bit PNGs with their most
/// significant bits repeated below (v << (16 - b) | v >> (2 b - 16)): black stays 0, saturated becomes 65535,
/// and the original is the upper b bits. data.csv appears only in Finish, so that a recording that was cut
/// short cannot be taken for a whole one.
class RecordingWriter {
 public:
  /// The folder must not exist or be empty.
  static base::Result<RecordingWriter> Create(const std::string& folder, const std::string& left_sensor_yaml,
                                              const std::string& right_sensor_yaml);
  ~RecordingWriter();
  RecordingWriter(RecordingWriter&&) noexcept;
  RecordingWriter& operator=(RecordingWriter&&) noexcept;

  /// Times must ascend on each side. The two sides may be written by two threads at once.
  base::Result<void> Write(base::Side side, base::TimeNs mid_exposure_ns, const base::ImageView& image);
  /// Once, after the last Write.
  base::Result<void> Finish();

 private:
  struct State;
  explicit RecordingWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace adit::recording
