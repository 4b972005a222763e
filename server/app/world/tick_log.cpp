#include "server/app/world/tick_log.h"

#include "server/app/log/log.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace zoned::app {

namespace {

constexpr double kTickLogEvery_s = 1.0;
constexpr std::size_t kPassesTold = 3;

}  // namespace

std::string slowest_passes(const World& world, std::size_t most) {
    std::array<std::pair<std::uint64_t, std::size_t>, zone::kPasses> sums{};
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        sums[p].second = p;
        for (const auto& zone : world.zones()) {
            sums[p].first += zone->report().passes[p].ns;
        }
    }
    std::partial_sort(sums.begin(),
                      sums.begin() + static_cast<std::ptrdiff_t>(most),
                      sums.end(),
                      [](const auto& a, const auto& b) { return a.first > b.first; });
    std::string out;
    for (std::size_t i = 0; i < most && sums[i].first > 0; ++i) {
        out += fmt::format("{}{} {:.2f} ms",
                           i == 0 ? "" : ", ",
                           zone::pass_name(static_cast<zone::Pass>(sums[i].second)),
                           1e-6 * static_cast<double>(sums[i].first));
    }
    return out;
}

void TickLog::overrun(const World& world, const Overrun& overrun, double now_s) {
    ++overruns_;
    if (now_s - overrun_logged_s_ < kTickLogEvery_s) {
        return;
    }
    log_of(LogArea::kTick)
        .warn("tick {} took {:.1f} ms of {:.1f}: {}; passes over all zones: {}{}",
              world.now(),
              overrun.wall_ms,
              overrun.period_ms,
              overrun.cause,
              slowest_passes(world, kPassesTold),
              overruns_ > 1 ? fmt::format("; {} more since the last line", overruns_ - 1) : "");
    overruns_ = 0;
    overrun_logged_s_ = now_s;
}

void TickLog::overload(const OverloadSteps::Load& load) {
    if (!overload_.tick(load)) {
        return;
    }
    const auto tell = [&](OverloadStep step, const char* begins, const char* ends) {
        if (overload_.changed(step)) {
            log_of(LogArea::kTick)
                .warn("{} ({:.0f} % of {} clients)",
                      overload_.on(step) ? begins : ends,
                      100.0 * overload_.share(step),
                      load.clients);
        }
    };
    tell(OverloadStep::kCopies,
         "overload: acknowledgements are late, so no copies are sent ahead of losses",
         "overload over: acknowledgements come in time");
    tell(OverloadStep::kBounds,
         "overload: bounds are wider than promised, the farthest first",
         "overload over: bounds are as promised");
}

void TickLog::limits(const World& world, double now_s) {
    const zone::Zone* where = nullptr;
    for (const auto& zone : world.zones()) {
        if (zone->report().replication.limit_exceeded > 0) {
            limits_ += zone->report().replication.limit_exceeded;
            where = zone.get();
        }
    }
    if (where == nullptr || now_s - limit_logged_s_ < kTickLogEvery_s) {
        return;
    }
    const zone::ZoneState& state = where->state();
    const EntityId entity = where->report().replication.limit_entity;
    const world::Row row = state.entities.find(entity);
    log_of(LogArea::kWorld)
        .warn(
            "entity {}{} in zone {} moved at tick {} beyond max_acceleration_mps2 and "
            "max_velocity_jump_mps of its type; {} such ticks since the last line: clients' "
            "bounds do not hold there",
            entity.value,
            row == world::kNoRow
                ? ""
                : ", a " + (*state.settings.types)[state.entities.type[row]].name + ",",
            state.settings.id.value,
            world.now(),
            limits_);
    limits_ = 0;
    limit_logged_s_ = now_s;
}

void TickLog::stopped_zones(const World& world) {
    const auto stopped = world.stopped();
    for (; stopped_logged_ < stopped.size(); ++stopped_logged_) {
        const StoppedZone& zone = stopped[stopped_logged_];
        log_of(LogArea::kWorld)
            .error(
                "zone {} stopped at tick {} in {}: {}; its {} clients leave, all other zones go "
                "on",
                zone.zone.value,
                zone.tick,
                zone.place,
                zone.text,
                zone.clients);
    }
}

}  // namespace zoned::app
