// Shared clocks, variables, doors and platforms: the same in all zones, read and changed by rules.
#include "server/zone/context/zone_context.h"

#include <algorithm>
#include <cmath>

namespace zoned::zone {

namespace {

/// Announced so far ahead, a change reaches clients in time.
constexpr double kLeastAhead_s = 0.5;
constexpr double kMostAhead_s = 1e6;

/// The tick from which on a change holds; none where the time is out of range.
std::optional<Tick> announced_tick(const ZoneState& state, double ahead_s) {
    if (!(ahead_s >= 0.0 && ahead_s < kMostAhead_s)) {
        return std::nullopt;
    }
    const double ticks =
        std::ceil(std::max(kLeastAhead_s, ahead_s) / static_cast<double>(state.settings.dt));
    return state.now + static_cast<Tick>(ticks);
}

/// The number of a door that rules move, of several the zone's own; none where there is none of
/// that name.
std::optional<std::uint32_t> find_door(const ZoneSettings& settings, std::string_view name) {
    std::optional<std::uint32_t> found;
    for (std::uint32_t door = 0; settings.door_courses && door < settings.doors.size(); ++door) {
        const DoorName& named = settings.doors[door];
        if (named.by_rules && named.name == name && (!found || named.here)) {
            found = door;
        }
    }
    return found;
}

/// The platform that rules move, of several the zone's own; null where there is none of that name.
const PlatformName* find_platform(const ZoneSettings& settings, std::string_view name) {
    const PlatformName* found = nullptr;
    for (const PlatformName& platform : settings.platforms) {
        if (platform.name == name && (found == nullptr || platform.here)) {
            found = &platform;
        }
    }
    return found;
}

}  // namespace

std::optional<double> ZoneContext::shared_value(std::string_view name) const {
    const auto& environment = state_->settings.environment;
    return environment ? environment->at(name, state_->now) : std::nullopt;
}

bool ZoneContext::set_clock_rate(std::string_view name, double rate_per_s, double ahead_s) {
    const auto& environment = state_->settings.environment;
    const auto clock = environment ? environment->find_clock(name) : std::nullopt;
    const std::optional<Tick> from = announced_tick(*state_, ahead_s);
    if (!clock || !std::isfinite(rate_per_s) || !from) {
        return false;
    }
    state_->out.clocks.push_back({*clock, *from, rate_per_s});
    return true;
}

bool ZoneContext::set_door(std::string_view name, bool open, double ahead_s) {
    const std::optional<std::uint32_t> door = find_door(state_->settings, name);
    const std::optional<Tick> from = announced_tick(*state_, ahead_s);
    if (!door || !from || !state_->settings.door_courses->has_room(*door, *from, state_->now)) {
        return false;
    }
    state_->out.doors.push_back({*door, {*from, open}});
    return true;
}

std::optional<bool> ZoneContext::door_open(std::string_view name) const {
    const std::optional<std::uint32_t> door = find_door(state_->settings, name);
    if (!door) {
        return std::nullopt;
    }
    return state_->settings.door_courses->open_at(*door, state_->now)
        .value_or(state_->settings.doors[*door].starts_open);
}

bool ZoneContext::move_platform(std::string_view name, std::uint32_t stop, double ahead_s) {
    const PlatformName* platform = find_platform(state_->settings, name);
    const std::optional<Tick> from = announced_tick(*state_, ahead_s);
    if (platform == nullptr || !from || stop >= platform->stops.size() ||
        !state_->settings.platform_courses->has_room(platform->platform, *from, state_->now)) {
        return false;
    }
    state_->out.platforms.push_back({platform->platform, *from, platform->stops[stop]});
    return true;
}

std::optional<std::uint32_t> ZoneContext::platform_stop(std::string_view name) const {
    const PlatformName* platform = find_platform(state_->settings, name);
    if (platform == nullptr) {
        return std::nullopt;
    }
    const motion::PlatformCourse* course =
        state_->settings.platform_courses->at(platform->platform, state_->now);
    const Tick along = course == nullptr ? platform->start : course->along_at(state_->now);
    const auto stop = std::find(platform->stops.begin(), platform->stops.end(), along);
    return stop == platform->stops.end()
               ? std::nullopt
               : std::optional(static_cast<std::uint32_t>(stop - platform->stops.begin()));
}

}  // namespace zoned::zone
