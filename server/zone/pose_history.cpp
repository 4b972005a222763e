#include "server/zone/pose_history.h"

#include <algorithm>

namespace zoned::zone {

void PoseHistory::begin(Tick tick) {
    PosesOfTick& slot = slots_[static_cast<std::size_t>(tick) % slots_.size()];
    slot.tick = tick;
    slot.entity.clear();
    slot.position.clear();
    slot.orientation.clear();
    newest_ = tick;
}

void PoseHistory::add(EntityId entity, const Pose& pose) {
    PosesOfTick& slot = slots_[static_cast<std::size_t>(newest_) % slots_.size()];
    slot.entity.push_back(entity);
    slot.position.push_back(pose.position);
    slot.orientation.push_back(pose.orientation);
}

const PoseHistory::PosesOfTick* PoseHistory::find(Tick tick) const {
    if (slots_.empty() || tick < 0) {
        return nullptr;
    }
    const PosesOfTick& slot = slots_[static_cast<std::size_t>(tick) % slots_.size()];
    return slot.tick == tick ? &slot : nullptr;
}

std::optional<Pose> PoseHistory::in(const PosesOfTick& slot, EntityId entity) {
    const auto it = std::lower_bound(slot.entity.begin(), slot.entity.end(), entity);
    if (it == slot.entity.end() || *it != entity) {
        return std::nullopt;
    }
    const auto i = static_cast<std::size_t>(it - slot.entity.begin());
    return Pose{slot.position[i], slot.orientation[i]};
}

std::optional<Pose> PoseHistory::at(EntityId entity, Tick tick, float fraction) const {
    const PosesOfTick* slot = find(tick);
    std::optional<Pose> pose = slot != nullptr ? in(*slot, entity) : std::nullopt;
    const PosesOfTick* next = fraction > 0.0F ? find(tick + 1) : nullptr;
    if (!pose || next == nullptr) {
        return pose;
    }
    if (const std::optional<Pose> after = in(*next, entity)) {
        pose->position += fraction * (after->position - pose->position);
        const float side =
            pose->orientation.coeffs().dot(after->orientation.coeffs()) < 0.0F ? -1.0F : 1.0F;
        pose->orientation.coeffs() +=
            fraction * (side * after->orientation.coeffs() - pose->orientation.coeffs());
        pose->orientation.normalize();
    }
    return pose;
}

std::size_t PoseHistory::recorded(Tick tick) const {
    const PosesOfTick* slot = find(tick);
    return slot != nullptr ? slot->entity.size() : 0;
}

}  // namespace zoned::zone
