// print: formats text as std::printf does, into a string.
#pragma once

#include <string>

namespace zoned::core {

/// At most 299 characters; longer text is cut off.
std::string print(const char* format, ...) __attribute__((format(printf, 1, 2)));

}  // namespace zoned::core
