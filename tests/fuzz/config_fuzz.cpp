// Fuzzing of the config parser: any text is either good or has mistakes that are reported.
#include "server/config/expand/load_settings.h"
#include "tests/fuzz/fuzz.h"
#include "shared/core/assert.h"

#include <fstream>
#include <iterator>

namespace zoned::fuzz {

namespace {

constexpr std::size_t kMaxText = 32768;

}  // namespace

std::vector<Bytes> seeds() {
    std::vector<Bytes> all;
    for (const char* name : {"minimal", "valley", "hamlet"}) {
        std::ifstream in(std::string(ZONED_SOURCE_DIR "/config/") + name + ".txtpb",
                         std::ios::binary);
        all.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
    // The config finds its surfaces from any folder.
    std::ifstream in(ZONED_SOURCE_DIR "/config/hills.txtpb", std::ios::binary);
    std::string hills{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    const std::string name = "geometry/";
    for (std::size_t at = 0; (at = hills.find(name, at)) != std::string::npos;) {
        const std::string whole = std::string(ZONED_SOURCE_DIR "/config/") + name;
        hills.replace(at, name.size(), whole);
        at += whole.size();
    }
    all.emplace_back(hills.begin(), hills.end());
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned;
    const std::string text(reinterpret_cast<const char*>(data), std::min(size, fuzz::kMaxText));
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    const bool good = config::parse_settings(text, {}, settings, errors);
    ZONED_ASSERT(good == errors.empty(), "a config is good, or its mistakes are named");
    for (const config::ConfigError& error : errors) {
        ZONED_ASSERT(!error.text.empty() && error.line >= 0, "a mistake has words and a place");
    }
    return 0;
}
