// The description of adit-CAN in the format of the trade: a DBC file.
#pragma once

#include <cstdint>
#include <string>

namespace adit::publish {

/// Blocks A and B of the box at `node`, INFO multiplexed, with the attributes of E2E profile 5. Off the hot
/// path.
std::string FormatDbc(std::uint8_t node);

}  // namespace adit::publish
