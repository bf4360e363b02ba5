#include "drivers/linux/terminal.h"

#include <unistd.h>

namespace adit::linux {

bool IsTerminal(std::FILE* stream) { return isatty(fileno(stream)) == 1; }

}  // namespace adit::linux
