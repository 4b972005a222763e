// print: text as std::printf writes it, in a string.
#pragma once

#include <string>

namespace zoned::core {

/// At most 299 characters; what is longer is cut off.
std::string print(const char* format, ...) __attribute__((format(printf, 1, 2)));

}  // namespace zoned::core
