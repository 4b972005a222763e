// Read text: a whole file, or why it can't be read.
#pragma once

#include <string>

namespace zoned::config {

/// The file's bytes go to `text`. What is returned is empty, or says what is wrong with the file,
/// by name.
std::string read_text(const std::string& file, std::string& text);

}  // namespace zoned::config
