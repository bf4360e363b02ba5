// Image files of a calibration board, of whatever camera and program.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "firmware/base/result.h"

namespace adit::host {

/// The image files that `paths` mean, in their order: a folder stands for the images in it, sorted by name.
/// Refuses a path that is not there, a folder without images, and a file that is named twice.
base::Result<std::vector<std::string>> ListImages(const std::vector<std::string>& paths);

/// Reads one image as grey of 8 or 16 bit, as stored (no rotation by EXIF, which would mix up the camera's
/// axes). Refuses, with the file's name, what is no whole image.
base::Result<cv::Mat> ReadBoardImage(const std::string& path);

}  // namespace adit::host
