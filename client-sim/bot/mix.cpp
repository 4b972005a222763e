#include "client-sim/bot/script.h"
#include "shared/core/files/line_reader.h"

#include <array>
#include <cmath>

namespace zoned::bot {

namespace {

constexpr std::array<const char*, kScripts> kNames = {"wander",
                                                      "crowd",
                                                      "border",
                                                      "fight",
                                                      "hunt",
                                                      "chat",
                                                      "idle",
                                                      "drive",
                                                      "sneak",
                                                      "look",
                                                      "trade"};

using Mix = core::Result<std::vector<Share>>;

}  // namespace

const char* name_of(Script script) {
    return kNames[static_cast<std::size_t>(script)];
}

std::string script_names() {
    std::string names;
    for (const char* name : kNames) {
        names += (names.empty() ? "" : ", ") + std::string(name);
    }
    return names;
}

std::vector<Share> default_mix() {
    return {{Script::kWander, 45.0},
            {Script::kBorder, 20.0},
            {Script::kFight, 10.0},
            {Script::kChat, 5.0},
            {Script::kCrowd, 5.0},
            {Script::kDrive, 5.0},
            {Script::kSneak, 4.0},
            {Script::kLook, 3.0},
            {Script::kTrade, 3.0}};
}

core::Result<std::vector<Share>> parse_mix(std::string_view text) {
    std::vector<Share> mix;
    while (!text.empty()) {
        const std::size_t comma = text.find(',');
        const std::string_view entry = text.substr(0, comma);
        text = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
        const std::size_t colon = entry.find(':');
        const std::string name(entry.substr(0, colon));
        Share share;
        bool found = false;
        for (std::size_t i = 0; i < kNames.size(); ++i) {
            if (name == kNames[i]) {
                share.script = static_cast<Script>(i);
                found = true;
            }
        }
        if (!found) {
            return Mix::failure("unknown script '" + name + "'; choose from " + script_names());
        }
        if (colon != std::string_view::npos) {
            const std::string_view number = entry.substr(colon + 1);
            share.share = core::parse_number<double>(number).value_or(0.0);
            if (!(share.share > 0.0) || !std::isfinite(share.share)) {
                return Mix::failure("share '" + std::string(number) + "' of script '" + name +
                                    "' is not a positive number");
            }
        }
        mix.push_back(share);
    }
    if (mix.empty()) {
        return Mix::failure("no script given");
    }
    return mix;
}

std::vector<Script> deal(const std::vector<Share>& mix, std::size_t bots) {
    double total = 0.0;
    for (const Share& share : mix) {
        total += share.share;
    }
    std::vector<double> given(mix.size(), 0.0);
    std::vector<Script> dealt;
    dealt.reserve(bots);
    for (std::size_t i = 0; i < bots; ++i) {
        // The script farthest behind its share comes next.
        std::size_t best = 0;
        double best_lag = -1e300;
        for (std::size_t k = 0; k < mix.size(); ++k) {
            const double lag = mix[k].share / total * static_cast<double>(i + 1) - given[k];
            if (lag > best_lag + 1e-12) {
                best_lag = lag;
                best = k;
            }
        }
        given[best] += 1.0;
        dealt.push_back(mix[best].script);
    }
    return dealt;
}

}  // namespace zoned::bot
