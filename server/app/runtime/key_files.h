// Key files as `zoned keygen` writes them: 64 hexadecimal digits.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace zoned::app {

/// Throws std::system_error or std::runtime_error with a text that names the file.
std::array<std::uint8_t, 32> read_key_file(const std::string& path);

}  // namespace zoned::app
