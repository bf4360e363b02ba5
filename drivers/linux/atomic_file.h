// Files that are either the old one or the new one, whatever happens meanwhile.
#pragma once

#include <string>
#include <string_view>

#include "firmware/base/result.h"

namespace adit::linux {

/// Writes `bytes` to `path`: a temporary file in the same folder, fsync, rename, fsync of the folder. After
/// any failure the old file stands unchanged and the temporary one is gone. A symbolic link stays one: the
/// file it names is replaced; permissions of an existing file are kept. Declines, naming `path`, when the
/// folder is missing or not writable, the disk is full, or `path` is something other than a regular file.
base::Result<void> WriteFileAtomically(const std::string& path, std::string_view bytes);

}  // namespace adit::linux
