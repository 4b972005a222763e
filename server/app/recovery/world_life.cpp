#include "server/app/recovery/world_life.h"

#include "shared/core/files/replace_file.h"
#include "shared/core/hex.h"

#include <cstdint>
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
    const std::string text =
        core::to_hex({reinterpret_cast<const std::uint8_t*>(life.data()), life.size()}) + "\n";
    const auto written = core::replace_file(life_file(settings), text, 0640);
    if (!written) {
        throw std::runtime_error(written.error());
    }
}

}  // namespace zoned::app
