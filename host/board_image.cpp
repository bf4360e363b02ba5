#include "host/board_image.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "host/repeated_path.h"

namespace adit::host {
namespace {

namespace fs = std::filesystem;
using base::Error;
using base::ErrorCode;

bool IsImageName(const fs::path& path) {
  constexpr std::array<std::string_view, 8> kEndings{".png",  ".jpg", ".jpeg", ".tif",
                                                     ".tiff", ".bmp", ".pgm",  ".ppm"};
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

base::Result<std::vector<std::string>> ImagesIn(const std::string& folder) {
  std::vector<std::string> images;
  std::error_code fault;
  for (fs::directory_iterator entry(folder, fault), end; !fault && entry != end; entry.increment(fault)) {
    std::error_code ignored;
    if (entry->is_regular_file(ignored) && IsImageName(entry->path()))
      images.push_back(entry->path().string());
  }
  if (fault) return Error{ErrorCode::kNotFound, folder, "cannot be read: " + fault.message()};
  if (images.empty()) return Error{ErrorCode::kUsage, folder, "holds no images (png, jpg, tif, bmp, pgm)"};
  std::sort(images.begin(), images.end());
  return images;
}

/// False for a PNG or JPEG that was cut short: their libraries would say so on stderr, and return half an
/// image.
bool EndsWhole(const std::vector<char>& bytes) {
  const std::string_view text(bytes.data(), bytes.size());
  constexpr std::string_view kPng = "\x89PNG", kPngLast = "IEND", kJpeg = "\xFF\xD8", kJpegLast = "\xFF\xD9";
  constexpr std::size_t kCrcBytes = 4;
  if (text.substr(0, kPng.size()) == kPng) {
    return text.size() > 2 * kPngLast.size() + kCrcBytes &&
           text.substr(text.size() - kCrcBytes - kPngLast.size(), kPngLast.size()) == kPngLast;
  }
  // Cameras append padding or notes of their own to a JPEG.
  if (text.substr(0, kJpeg.size()) == kJpeg) return text.rfind(kJpegLast) != std::string_view::npos;
  return true;
}

}  // namespace

base::Result<std::vector<std::string>> ListImages(const std::vector<std::string>& paths) {
  std::vector<std::string> images;
  for (const std::string& path : paths) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored)) {
      auto inside = ImagesIn(path);
      if (!inside) return inside.error();
      images.insert(images.end(), inside->begin(), inside->end());
    } else if (fs::is_regular_file(path, ignored)) {
      images.push_back(path);
    } else {
      return Error{ErrorCode::kUsage, path, "is neither an image file nor a folder of images"};
    }
  }
  if (const auto repeated = RepeatedPath(images))
    return Error{ErrorCode::kUsage, *repeated, "is named twice"};
  return images;
}

base::Result<cv::Mat> ReadBoardImage(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file.is_open() || file.bad()) return Error{ErrorCode::kUsage, path, "cannot be read"};
  cv::Mat grey;
  try {
    if (!bytes.empty() && EndsWhole(bytes)) {
      grey = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
    }
  } catch (const cv::Exception&) {
    grey.release();  // said below: what OpenCV throws names its own source line, not the file
  }
  if (grey.empty())
    return Error{ErrorCode::kMalformed, path, "is not a whole image (png, jpg, tif, bmp, pgm)"};
  if (grey.type() != CV_8UC1 && grey.type() != CV_16UC1)
    return Error{ErrorCode::kMalformed, path, "must have 8 or 16 bit a pixel"};
  return grey;
}

}  // namespace adit::host
