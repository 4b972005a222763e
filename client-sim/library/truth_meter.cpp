#include "client-sim/library/truth_meter.h"

#include <cmath>

namespace zoned::library {

namespace {

constexpr double kPeriodS = 0.5;
/// A tick is compared when it has been displayed for so long.
constexpr double kHoldS = 0.25;
constexpr std::size_t kMostWaiting = 8;

/// World coordinates; nothing where the server sent no three finite numbers.
std::optional<Vec3d> place_of(const std::vector<double>& numbers) {
    if (numbers.size() != 3) {
        return std::nullopt;
    }
    const Vec3d place(numbers[0], numbers[1], numbers[2]);
    return place.allFinite() ? std::optional<Vec3d>(place) : std::nullopt;
}

}  // namespace

void TruthMeter::add(const wire::AuditRecordMessage& record) {
    if (waiting_.size() >= kMostWaiting) {
        waiting_.pop_front();
    }
    waiting_.push_back(record);
}

void TruthMeter::advance(view::Player& player, double now_s) {
    if (!player.ready() || (player.client().rights() & view::Player::kMayAudit) == 0) {
        return;
    }
    if (now_s >= next_s_) {
        next_s_ = now_s + kPeriodS;
        player.client().request_audit();
    }
    const view::View& view = *player.view();
    const auto hold = static_cast<Tick>(std::ceil(kHoldS / view.world().tick_s));
    while (!waiting_.empty() && view.tick() - waiting_.front().tick >= hold) {
        compare(view, waiting_.front());
        waiting_.pop_front();
    }
}

void TruthMeter::compare(const view::View& view, const wire::AuditRecordMessage& record) {
    const std::optional<Tick> shown_at = view.shown_at(record.tick);
    if (!shown_at || record.frozen ||
        view.tick() - record.tick > view::EntityStore::kHistoryTicks) {
        return;
    }
    const auto avatar = place_of(record.avatar_position);
    const auto own = view.own().position_at(record.tick);
    if (avatar && own) {
        own_.add((*own - *avatar).norm());
    }
    for (const wire::AuditEntityMessage& truth : record.entities) {
        const view::Entity* entity = view.store().find(EntityId(truth.entity));
        const auto place = place_of(truth.position);
        if (entity == nullptr || !place || EntityId(truth.entity) == view.own().id()) {
            continue;
        }
        const view::Version* version = view.held(*entity, record.tick, *shown_at);
        if (version != nullptr && version->present) {
            const view::WorldState shown =
                view.displayed(*entity, *version, record.tick, *shown_at);
            displayed_.add((shown.position - *place).norm());
        }
    }
}

}  // namespace zoned::library
