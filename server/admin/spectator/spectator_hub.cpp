#include "server/admin/spectator/spectator_hub.h"

#include "server/world/entities.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace zoned::admin {

namespace {

static_assert(std::endian::native == std::endian::little, "messages are written as they lie");

/// A turn by less is not sent, rad; nobody sees it.
constexpr float kLeastTurn = 0.01F;

std::int16_t part_of(float unit) {
    return static_cast<std::int16_t>(std::lround(std::clamp(unit, -1.0F, 1.0F) * 32767.0F));
}

std::array<float, 3> place_of(const Vec3d& at) {
    return {static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z())};
}

std::string message_head(std::uint32_t kind,
                         std::int64_t tick,
                         std::size_t removed,
                         std::size_t rows) {
    std::string out;
    put_bytes(out, kind);
    put_bytes(out, static_cast<std::uint32_t>(tick));
    put_bytes(out, static_cast<std::uint32_t>(removed));
    put_bytes(out, static_cast<std::uint32_t>(rows));
    return out;
}

std::uint8_t flags_of(std::uint8_t flags, ClientId client) {
    std::uint8_t out = 0;
    if ((flags & world::kAtRest) != 0) {
        out |= kSpectatorAtRest;
    }
    if ((flags & world::kDozing) != 0) {
        out |= kSpectatorOffScreen;
    }
    if (client) {
        out |= kSpectatorAvatar;
    }
    return out;
}

}  // namespace

SpectatorMessage SpectatorHub::update(const SpectatorSample& sample,
                                      std::span<const SpectatorWish> wishes) {
    ++updates_;
    tick_ = sample.tick;
    tick_s_ = sample.tick_s;
    wishes_ = wishes;
    changes_.clear();
    changed_ = 0;
    for (std::size_t zone = 0; zone < sample.zones.size(); ++zone) {
        take_zone(sample, zone);
    }
    wishes_ = {};
    const std::string removed = remove_unseen();
    if (changed_ > 0 || !removed.empty()) {
        everything_ = nullptr;
    }
    std::string out = message_head(2, tick_, removed.size() / 4, changed_);
    out.reserve(out.size() + removed.size() + changes_.size());
    out += removed;
    out += changes_;
    return std::make_shared<const std::string>(std::move(out));
}

void SpectatorHub::take_zone(const SpectatorSample& sample, std::size_t zone) {
    const SpectatorZone& from = sample.zones[zone];
    walker_of_.assign(from.id.size(), 0);
    for (std::uint32_t i = 0; i < sample.walkers.size(); ++i) {
        const SpectatorWalker& walker = sample.walkers[i];
        if (walker.zone == zone && walker.row < walker_of_.size()) {
            walker_of_[walker.row] = i + 1;
        }
    }
    for (std::size_t row = 0; row < from.id.size(); ++row) {
        if ((from.flags[row] & (world::kGhost | world::kHidden)) != 0) {
            continue;
        }
        ExactState truth{from.id[row],
                         from.origin + from.position[row].cast<double>(),
                         from.orientation[row],
                         from.velocity[row],
                         from.type[row],
                         flags_of(from.flags[row], from.client[row]),
                         static_cast<std::uint8_t>(from.number)};
        if ((truth.flags & kSpectatorOffScreen) != 0) {
            const std::uint32_t walker = walker_of_[row];
            const auto known = slot_of_.find(truth.id);
            if (walker != 0) {
                const SpectatorWalker& at = sample.walkers[walker - 1];
                truth.position.x() = from.origin.x() + static_cast<double>(at.position.x());
                truth.position.z() = from.origin.z() + static_cast<double>(at.position.y());
                truth.velocity = Vec3(at.velocity.x(), 0.0F, at.velocity.y());
            } else if (known != slot_of_.end() &&
                       (sent_[known->second].row.flags & kSpectatorOffScreen) != 0) {
                sent_[known->second].seen = updates_;
                continue;  // its turn comes
            } else {
                truth.velocity.setZero();
            }
        } else if ((truth.flags & kSpectatorAtRest) != 0) {
            truth.velocity.setZero();
        }
        take_row(truth);
    }
}

void SpectatorHub::take_row(const ExactState& truth) {
    const std::uint32_t slot = slot_for(truth.id);
    SentRow& sent = sent_[slot];
    if (sent.seen == 0 || left(sent, truth)) {
        set_row(sent, truth);
        put_bytes(changes_, slot);
        put_bytes(changes_, sent.row);
        ++changed_;
    }
    sent.seen = updates_;
}

float SpectatorHub::error_at(const ExactState& truth) const {
    float nearest = wishes_.empty() ? 0.0F : std::numeric_limits<float>::infinity();
    const std::array<float, 3> at = place_of(truth.position);
    for (const SpectatorWish& wish : wishes_) {
        float squared = 0.0F;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            squared += (at[axis] - wish.eye[axis]) * (at[axis] - wish.eye[axis]);
        }
        nearest = std::min(nearest, squared);
    }
    return std::clamp(kErrorPerMetre * std::sqrt(nearest), kLeastError_m, kMostError_m);
}

bool SpectatorHub::left(const SentRow& sent, const ExactState& truth) const {
    const SpectatorRow& row = sent.row;
    if (row.flags != truth.flags || row.type != truth.type || row.zone != truth.zone) {
        return true;
    }
    const float elapsed =
        tick_s_ * static_cast<float>(static_cast<std::uint32_t>(tick_) - row.tick);
    const std::array<float, 3> at = place_of(truth.position);
    float squared = 0.0F;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float off = row.position[axis] + sent.velocity[axis] * elapsed - at[axis];
        squared += off * off;
    }
    float dot = 0.0F;
    for (int part = 0; part < 4; ++part) {
        dot += truth.orientation.coeffs()[part] *
               static_cast<float>(row.orientation[static_cast<std::size_t>(part)]) / 32767.0F;
    }
    // cos(a / 2) = |dot|, so 1 - |dot| is about a^2 / 8.
    const float turned = 8.0F * (1.0F - std::abs(dot));
    if (squared <= kLeastError_m * kLeastError_m && turned <= kLeastTurn * kLeastTurn) {
        return false;
    }
    const float error = error_at(truth);
    const float turn = std::max(kLeastTurn, error);  // as seen on something of a metre's size
    return squared > error * error || turned > turn * turn;
}

std::uint32_t SpectatorHub::slot_for(EntityId id) {
    const auto known = slot_of_.find(id);
    if (known != slot_of_.end()) {
        return known->second;
    }
    std::uint32_t slot = 0;
    if (free_.empty()) {
        slot = static_cast<std::uint32_t>(sent_.size());
        sent_.emplace_back();
    } else {
        slot = free_.back();
        free_.pop_back();
    }
    slot_of_[id] = slot;
    return slot;
}

void SpectatorHub::set_row(SentRow& sent, const ExactState& truth) const {
    SpectatorRow& row = sent.row;
    row.position = place_of(truth.position);
    row.tick = static_cast<std::uint32_t>(tick_);
    for (int part = 0; part < 4; ++part) {
        row.orientation[static_cast<std::size_t>(part)] = part_of(truth.orientation.coeffs()[part]);
    }
    for (int axis = 0; axis < 3; ++axis) {
        const Eigen::half rounded(truth.velocity[axis]);
        row.velocity[static_cast<std::size_t>(axis)] =
            Eigen::numext::bit_cast<std::uint16_t>(rounded);
        sent.velocity[static_cast<std::size_t>(axis)] = static_cast<float>(rounded);
    }
    row.type = truth.type;
    row.id = truth.id.value;
    row.flags = truth.flags;
    row.zone = truth.zone;
}

std::string SpectatorHub::remove_unseen() {
    std::string removed;
    std::erase_if(slot_of_, [&](const auto& entry) {
        SentRow& sent = sent_[entry.second];
        const bool gone = sent.seen != updates_;
        if (gone) {
            sent.seen = 0;
            free_.push_back(entry.second);
            put_bytes(removed, entry.second);
        }
        return gone;
    });
    return removed;
}

SpectatorMessage SpectatorHub::everything() {
    if (!everything_) {
        std::string out = message_head(1, tick_, 0, slot_of_.size());
        out.reserve(out.size() + kRowBytes * slot_of_.size());
        for (std::uint32_t slot = 0; slot < sent_.size(); ++slot) {
            if (sent_[slot].seen != 0) {
                put_bytes(out, slot);
                put_bytes(out, sent_[slot].row);
            }
        }
        everything_ = std::make_shared<const std::string>(std::move(out));
    }
    return everything_;
}

void SpectatorHub::clear() {
    *this = SpectatorHub();
}

}  // namespace zoned::admin
