// File text: a file as one string.
#pragma once

#include <fstream>
#include <sstream>
#include <string>

namespace zoned::bench {

/// The whole text of a file; empty where it can't be read.
inline std::string text_of_file(const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

}  // namespace zoned::bench
