#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "drivers/recording/recording.h"

namespace adit::recording {
namespace {

namespace fs = std::filesystem;
using base::Error;
using base::ErrorCode;

/// One line of data.csv, without its line end.
base::Result<ImageEntry> ParseLine(const std::string& line, const std::string& where, const fs::path& data) {
  const std::size_t comma = line.find(',');
  ImageEntry entry;
  const char* const end = line.data() + std::min(comma, line.size());
  const auto [stop, fault] = std::from_chars(line.data(), end, entry.mid_exposure_ns);
  if (comma == std::string::npos || fault != std::errc() || stop != end || entry.mid_exposure_ns < 0) {
    return Error{ErrorCode::kMalformed, where,
                 "is '" + line.substr(0, 80) + "'; it must be a time in whole ns, a comma, a file name"};
  }
  std::string name = line.substr(comma + 1);
  name.erase(0, name.find_first_not_of(' '));
  const bool printable =
      std::none_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; });
  if (name.empty() || !printable || name.find_first_of("/\\,") != std::string::npos || name == "." ||
      name == "..") {
    return Error{ErrorCode::kMalformed, where, "names '" + name + "'; it must be a file in data/"};
  }
  entry.path = (data / name).string();
  std::error_code ignored;
  if (!fs::is_regular_file(entry.path, ignored)) {
    return Error{ErrorCode::kNotFound, where, "names " + entry.path + ", which is not there"};
  }
  return entry;
}

base::Result<std::vector<ImageEntry>> ReadIndex(const fs::path& camera) {
  const std::string path = (camera / "data.csv").string();
  std::ifstream file(path);
  if (!file) return Error{ErrorCode::kNotFound, path, "cannot be read; a recording has cam0 and cam1"};
  std::vector<ImageEntry> entries;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    const std::string where = path + ":" + std::to_string(number);
    auto entry = ParseLine(line, where, camera / "data");
    if (!entry) return entry.error();
    if (!entries.empty() && entry->mid_exposure_ns <= entries.back().mid_exposure_ns) {
      return Error{ErrorCode::kMalformed, where,
                   "has the time " + std::to_string(entry->mid_exposure_ns) + "; it must be later than " +
                       std::to_string(entries.back().mid_exposure_ns) + " of the line before"};
    }
    entries.push_back(std::move(*entry));
  }
  if (file.bad()) return Error{ErrorCode::kNotFound, path, "cannot be read to its end"};
  if (entries.empty()) return Error{ErrorCode::kMalformed, path, "holds no images"};
  return entries;
}

base::Result<std::vector<std::uint8_t>> ReadBytes(const std::string& path) {
  std::error_code ignored;
  std::ifstream file;
  if (fs::is_regular_file(path, ignored)) file.open(path, std::ios::binary | std::ios::ate);
  const auto size = file.is_open() ? static_cast<std::streamoff>(file.tellg()) : -1;
  if (size < 0) return Error{ErrorCode::kNotFound, path, "cannot be read"};
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  file.seekg(0);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), size))
    return Error{ErrorCode::kNotFound, path, "cannot be read"};
  return bytes;
}

/// Whether the file starts as a PNG and ends as one. libpng would say so too, but on stderr.
bool LooksWhole(const std::vector<std::uint8_t>& bytes) {
  constexpr std::array<std::uint8_t, 8> kStart{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  constexpr std::array<std::uint8_t, 4> kLastChunk{'I', 'E', 'N', 'D'};
  constexpr std::size_t kTail = 8;  // the last chunk's name and its CRC
  return bytes.size() > kStart.size() + kTail && std::equal(kStart.begin(), kStart.end(), bytes.begin()) &&
         std::equal(kLastChunk.begin(), kLastChunk.end(), bytes.end() - kTail);
}

}  // namespace

base::Result<Recording> OpenRecording(const std::string& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) {
    return Error{ErrorCode::kNotFound, folder, "is not a folder; a recording is one with cam0 and cam1"};
  }
  auto left = ReadIndex(fs::path(folder) / "cam0");
  if (!left) return left.error();
  auto right = ReadIndex(fs::path(folder) / "cam1");
  if (!right) return right.error();
  return Recording{folder, std::move(*left), std::move(*right)};
}

base::Result<StoredImage> ReadImage(const std::string& path) {
  const auto bytes = ReadBytes(path);
  if (!bytes) return bytes.error();
  cv::Mat pixels;
  try {
    if (LooksWhole(*bytes)) pixels = cv::imdecode(*bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    pixels.release();  // said below: what OpenCV throws names its own source line, not the file
  }
  if (pixels.empty()) return Error{ErrorCode::kMalformed, path, "is not a whole PNG"};
  if (pixels.type() != CV_8UC1 && pixels.type() != CV_16UC1) {
    return Error{ErrorCode::kMalformed, path,
                 "has " + std::to_string(pixels.channels()) + " channels of " +
                     std::to_string(8 * pixels.elemSize1()) + " bit; it must be grey of 8 or 16 bit"};
  }
  StoredImage image;
  image.width_px = pixels.cols;
  image.height_px = pixels.rows;
  image.bits = pixels.type() == CV_8UC1 ? 8 : 16;
  image.pixels.assign(pixels.datastart, pixels.dataend);  // imdecode allocates without gaps between rows
  return image;
}

base::Result<StoredImage> ReadCameraImage(const std::string& path) {
  constexpr int kBits = 12;
  auto image = ReadImage(path);
  if (!image || image->bits <= kBits) return image;
  const int down = image->bits - kBits;
  for (std::size_t i = 0; i + 1 < image->pixels.size(); i += sizeof(std::uint16_t)) {
    std::uint16_t value = 0;
    std::memcpy(&value, image->pixels.data() + i, sizeof value);
    value = static_cast<std::uint16_t>(value >> down);
    std::memcpy(image->pixels.data() + i, &value, sizeof value);
  }
  image->bits = kBits;
  return image;
}

}  // namespace adit::recording
