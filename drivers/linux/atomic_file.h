// Files that are either the old one or the new one, whatever happens meanwhile.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "firmware/base/result.h"

namespace adit::linux {

/// Whether a file is on the disk when its writing returns. One that is replaced every second need not be: the
/// flush would hold up everybody who writes to the same disk.
enum class Flush : bool { kNo, kYes };

/// Writes `bytes` to `path`: a temporary file in the same folder, fsync, rename, fsync of the folder. After
/// any failure the old file stands unchanged and the temporary one is gone. A symbolic link stays one: the
/// file it names is replaced; permissions of an existing file are kept. Declines, naming `path`, when the
/// folder is missing or not writable, the disk is full, or `path` is something other than a regular file.
base::Result<void> WriteFileAtomically(const std::string& path, std::string_view bytes,
                                       Flush flush = Flush::kYes);

/// A text and the file that it is for.
struct FileText {
  std::string path, text;
};

/// The same for files that belong together, such as a result and its report: each is whole on the disk under
/// its temporary name before the first takes its own, so that after a failure none has changed. (Only a
/// rename that fails, which takes a folder that changes meanwhile, can leave the ones before it.) Declines
/// also when two of the paths are one file.
base::Result<void> WriteFilesAtomically(const std::vector<FileText>& files, Flush flush = Flush::kYes);

}  // namespace adit::linux
