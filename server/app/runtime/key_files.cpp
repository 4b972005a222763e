#include "server/app/runtime/key_files.h"

#include "server/session/login/secrets.h"

#include <cerrno>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace zoned::app {

std::array<std::uint8_t, 32> read_key_file(const std::string& path) {
    std::ifstream file(path);
    std::string text;
    if (!file || !(file >> text)) {
        throw std::system_error(
            ENOENT, std::generic_category(), "cannot read the key file " + path);
    }
    const auto key = session::parse_key_hex(text);
    if (!key.ok()) {
        throw std::runtime_error(path + " holds no key: " + key.error());
    }
    return *key;
}

}  // namespace zoned::app
