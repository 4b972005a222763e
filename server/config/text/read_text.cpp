#include "server/config/text/read_text.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace zoned::config {

std::string read_text(const std::string& file, std::string& text) {
    errno = 0;
    std::ifstream in(file, std::ios::binary);
    std::ostringstream read;
    if (in.good() && !std::filesystem::is_directory(file)) {
        read << in.rdbuf();
    }
    if (!in.good() || std::filesystem::is_directory(file)) {
        const std::string reason = errno != 0 ? std::strerror(errno) : "it is not a regular file";
        return "cannot read '" + file + "': " + reason;
    }
    text = read.str();
    return {};
}

}  // namespace zoned::config
