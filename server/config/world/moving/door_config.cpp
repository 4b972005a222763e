#include "server/config/world/moving/door_config.h"

#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "server/config/world/statics.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace zoned::config {

namespace {

using Span = motion::Timetable::OpenSpan;

/// The spans that one setting stands for: two where it goes over the end of the period.
struct Opening {
    Span span;
    int setting = 0;
};

Tick ticks_of(const proto::config::Config& config, double seconds) {
    return static_cast<Tick>(std::llround(seconds * config.world().tick_rate_hz()));
}

/// The door's period, s.
double period_of(const proto::config::Config& config, const proto::config::Door& door) {
    return door.has_period_s() ? door.period_s() : config.ai().day_s();
}

/// Empty, or the mistake in one time of opening, and its setting.
std::string defect_of_time(const proto::config::OpenTime& time, double period, std::string& at) {
    at = ".from_s";
    if (time.from_s() >= period) {
        return text_of("is not within the period of %g s", period);
    }
    at = ".to_s";
    if (!time.has_to_s()) {
        return "an opening has an end";
    }
    if (time.to_s() > period) {
        return text_of("is beyond the period of %g s", period);
    }
    return time.to_s() == time.from_s() ? "is where it opens: that is never, or always" : "";
}

std::vector<Opening> openings_of(const proto::config::Config& config,
                                 const proto::config::Door& door,
                                 const std::string& path,
                                 Tick period,
                                 Diagnostics& diagnostics) {
    std::vector<Opening> out;
    for (int i = 0; i < door.open_size(); ++i) {
        const auto& time = door.open(i);
        std::string at;
        const std::string defect = defect_of_time(time, period_of(config, door), at);
        if (!defect.empty()) {
            diagnostics.add(join_path(path, "open", i) + at, defect);
            continue;
        }
        const Tick from = ticks_of(config, time.from_s()) % period;
        const Tick to = std::min(ticks_of(config, time.to_s()), period);
        if (from == to) {
            diagnostics.add(join_path(path, "open", i), "is shorter than a tick");
        } else if (from < to) {
            out.push_back({{from, to}, i});
        } else {
            out.push_back({{from, period}, i});
            if (to > 0) {
                out.push_back({{0, to}, i});
            }
        }
    }
    std::sort(out.begin(), out.end(), [](const Opening& a, const Opening& b) {
        return a.span.from < b.span.from;
    });
    return out;
}

motion::Timetable expand_times(const proto::config::Config& config,
                               const proto::config::Door& door,
                               const std::string& path,
                               Diagnostics& diagnostics) {
    motion::Timetable out;
    out.period = std::max<Tick>(1, ticks_of(config, period_of(config, door)));
    out.shift = door.has_period_s() ? 0 : ticks_of(config, config.ai().dawn_s()) % out.period;
    if (door.open_size() == 0) {
        diagnostics.add(path, "never opens: give it times to open, or make it one of the statics");
        return out;
    }
    const std::size_t before = diagnostics.size();
    Tick whole = 0;
    for (const Opening& opening : openings_of(config, door, path, out.period, diagnostics)) {
        if (!out.open.empty() && opening.span.from < out.open.back().to) {
            diagnostics.add(join_path(path, "open", opening.setting), "overlaps another time");
        }
        out.open.push_back(opening.span);
        whole += opening.span.to - opening.span.from;
    }
    if (diagnostics.size() == before && whole == out.period) {
        diagnostics.add(path, "never shuts: leave it out");
    }
    return out;
}

/// A door that rules move: one state for all times.
motion::Timetable expand_start(const proto::config::Door& door,
                               const std::string& path,
                               Diagnostics& diagnostics) {
    if (door.open_size() > 0 || door.has_period_s()) {
        diagnostics.add(path, "is moved by rules: it has no times of its own");
    }
    motion::Timetable out;
    if (door.starts_open()) {
        out.open.push_back({0, out.period});
    }
    return out;
}

}  // namespace

std::vector<NamedDoor> expand_doors(const proto::config::Config& config, Diagnostics& diagnostics) {
    std::vector<NamedDoor> out;
    std::set<std::string> names;
    for (int i = 0; i < config.door_size(); ++i) {
        const auto& door = config.door(i);
        const std::string path = join_path("", "door", i);
        if (check_name(door.name(), "a door", path, diagnostics) &&
            !names.insert(door.name()).second) {
            diagnostics.add(path + ".name", "'" + door.name() + "' is the name of another door");
        }
        NamedDoor& named = out.emplace_back();
        named.name = door.name();
        named.door.box = static_box(door.box());
        if (!door.has_box()) {
            diagnostics.add(path, "a door has a box");
        } else {
            check_inside(config.world(), named.door.box, path + ".box", diagnostics);
        }
        if (door.moved_by() == proto::config::Door::RULES) {
            named.door.times = expand_start(door, path, diagnostics);
            named.door.by_rules = static_cast<std::uint32_t>(i);
            continue;
        }
        if (door.has_starts_open()) {
            diagnostics.add(path + ".starts_open", "is for doors with moved_by: RULES");
        }
        named.door.times = expand_times(config, door, path, diagnostics);
    }
    return out;
}

}  // namespace zoned::config
