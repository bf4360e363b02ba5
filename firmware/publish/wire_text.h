// The documents of the wire formats, written from the tables that the encoders use.
#pragma once

#include <string>

namespace adit::publish {

/// docs/adit-can.md. Off the hot path.
std::string FormatCanDocument();

/// docs/modbus-map.md. Off the hot path.
std::string FormatModbusDocument();

}  // namespace adit::publish
