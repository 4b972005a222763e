// read_text: reads a whole file.
#pragma once

#include <string>

namespace zoned::config {

/// The file's bytes go to `text`. Returns nothing, or the mistake with the file's name.
std::string read_text(const std::string& file, std::string& text);

}  // namespace zoned::config
