// SpectatorHub: turns samples of the world into messages for viewers: everything once, then what
// left its prediction.
#pragma once

#include "server/admin/spectator/spectator_sample.h"

#include <memory>
#include <span>
#include <string>
#include <unordered_map>

namespace zoned::admin {

/// An entity as it is sent, and as the page's vertex shader reads it. Until it is sent again it
/// goes on with its velocity from its tick on.
struct SpectatorRow {
    std::array<float, 3> position{};  ///< world coordinates, m
    std::uint32_t tick = 0;
    std::array<std::int16_t, 4> orientation{};  ///< x, y, z, w times 32767
    std::array<std::uint16_t, 3> velocity{};    ///< half floats, m/s
    std::uint16_t type = 0;
    std::uint32_t id = 0;
    std::uint8_t flags = 0;      ///< SpectatorFlag bits
    std::uint8_t zone = 0;       ///< number of the zone, modulo 256
    std::uint16_t reserved = 0;  ///< 0
};

static_assert(sizeof(SpectatorRow) == 40, "rows are sent as they lie");

using SpectatorMessage = std::shared_ptr<const std::string>;

/// Messages, little-endian: u32 kind (1: everything, 2: changes), u32 tick, u32 removed, u32 rows;
/// then the slots removed (u32), then rows: u32 slot, SpectatorRow. A slot is a small number that
/// stands for an entity until it is removed. Kinds from 3 on: spectator_layers.h.
///
/// A row is sent when the truth has left its prediction by more than a viewer could see: half a
/// thousandth of the distance to the nearest eye, at least kLeastError_m and at most kMostError_m.
class SpectatorHub {
  public:
    static constexpr std::size_t kHeadBytes = 16;
    static constexpr std::size_t kRowBytes = 4 + sizeof(SpectatorRow);
    static constexpr float kLeastError_m = 0.005F;
    static constexpr float kMostError_m = 0.5F;
    static constexpr float kErrorPerMetre = 0.0005F;

    /// Takes a sample and returns what changed, never null: its head tells the tick. `wishes` are
    /// those of all viewers; without any the least error counts everywhere.
    SpectatorMessage update(const SpectatorSample& sample, std::span<const SpectatorWish> wishes);

    /// All that viewers have been sent.
    [[nodiscard]] SpectatorMessage everything();

    [[nodiscard]] std::size_t size() const { return slot_of_.size(); }

    /// As before the first sample.
    void clear();

  private:
    /// Viewers believe this of an entity.
    struct SentRow {
        SpectatorRow row;
        std::array<float, 3> velocity{};  ///< as `row` rounds it
        std::uint64_t seen = 0;           ///< the update that met it last; 0: the slot is free
    };

    struct ExactState {
        EntityId id;
        Vec3d position;
        Quat orientation;
        Vec3 velocity;
        std::uint16_t type = 0;
        std::uint8_t flags = 0;
        std::uint8_t zone = 0;
    };

    void take_zone(const SpectatorSample& sample, std::size_t zone);
    void take_row(const ExactState& truth);
    [[nodiscard]] bool left(const SentRow& sent, const ExactState& truth) const;
    [[nodiscard]] float error_at(const ExactState& truth) const;
    [[nodiscard]] std::uint32_t slot_for(EntityId id);
    void set_row(SentRow& sent, const ExactState& truth) const;
    [[nodiscard]] std::string remove_unseen();

    std::vector<SentRow> sent_;  // by slot
    std::vector<std::uint32_t> free_;
    std::unordered_map<EntityId, std::uint32_t> slot_of_;
    std::span<const SpectatorWish> wishes_;  // of the update that runs
    std::vector<std::uint32_t> walker_of_;   // by row of a zone: 1 + its walker, or 0
    std::string changes_;
    std::uint32_t changed_ = 0;
    std::uint64_t updates_ = 0;
    std::int64_t tick_ = 0;
    float tick_s_ = 0.0F;
    SpectatorMessage everything_;
};

/// Little-endian, as it lies in memory.
template <class T>
void put_bytes(std::string& out, const T& value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace zoned::admin
