#include "server/app/recovery/world_life.h"

#include "server/recording/recording_file.h"
#include "shared/core/hex.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace zoned::app {

namespace {

std::string life_file(const config::Settings& settings) {
    return settings.server.session.state_folder + "/journal/life";
}

}  // namespace

std::string kept_life(const config::Settings& settings) {
    std::string text;
    std::ifstream(life_file(settings)) >> text;
    const auto bytes = core::from_hex(text);
    return bytes && bytes->size() == kLifeBytes ? std::string(bytes->begin(), bytes->end())
                                                : std::string();
}

void note_life(const config::Settings& settings, const std::string& life) {
    if (life.empty() || life == kept_life(settings)) {
        return;
    }
    const std::string file = life_file(settings);
    const std::string text =
        core::to_hex({reinterpret_cast<const std::uint8_t*>(life.data()), life.size()}) + "\n";
    const std::string piece = file + ".part";
    const int handle = ::open(piece.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0640);
    const bool written =
        handle >= 0 &&
        ::write(handle, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
        ::fsync(handle) == 0;
    const int why = errno;
    if (handle >= 0) {
        ::close(handle);
    }
    if (!written || std::rename(piece.c_str(), file.c_str()) != 0) {
        throw std::runtime_error("cannot write " + file + ": " +
                                 std::strerror(written ? errno : why));
    }
    recording::sync_folder(std::filesystem::path(file).parent_path().string());
}

}  // namespace zoned::app
