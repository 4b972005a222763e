// SpectatorHub: turns samples of the world into messages for viewers: everything once, then what
// changed.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace zoned::admin {

enum SpectatorFlag : std::uint8_t {
    kSpectatorAtRest = 1u << 0,
    kSpectatorAvatar = 1u << 1,  ///< a client's
};

/// An entity as a viewer draws it.
struct SpectatorRow {
    std::uint32_t id = 0;
    std::array<float, 3> position{};            ///< world coordinates, m
    std::array<std::int16_t, 4> orientation{};  ///< x, y, z, w times 32767
    std::uint16_t type = 0;
    std::uint8_t flags = 0;  ///< SpectatorFlag bits
    std::uint8_t zone = 0;   ///< number of the zone, modulo 256

    bool operator==(const SpectatorRow&) const = default;
};

struct SpectatorSample {
    std::int64_t tick = 0;
    std::vector<SpectatorRow> rows;  ///< each entity once, in any order
};

using SpectatorMessage = std::shared_ptr<const std::string>;

/// Messages, little-endian: u32 kind (1: everything, 2: changes), u32 tick, u32 removed, u32 rows;
/// then the numbers of removed entities, u32 each; then the rows, 28 bytes each: u32 id, f32 x, y,
/// z, i16 orientation x, y, z, w, u16 type, u8 flags, u8 zone. Each message is encoded once for all
/// viewers.
class SpectatorHub {
  public:
    static constexpr std::size_t kHeadBytes = 16;
    static constexpr std::size_t kRowBytes = 28;

    /// Takes a sample; the message leads a viewer from the sample before to this one. Null where
    /// nothing changed.
    SpectatorMessage update(const SpectatorSample& sample);

    /// Everything as of the newest sample.
    [[nodiscard]] SpectatorMessage everything();

    /// Forgets the samples: nobody looks.
    void clear();

  private:
    struct Known {
        SpectatorRow row;
        std::uint64_t seen = 0;  ///< number of the sample that had it last
    };

    std::unordered_map<std::uint32_t, Known> known_;
    SpectatorMessage everything_;  ///< of the newest sample, once somebody asked
    std::int64_t tick_ = 0;
    std::uint64_t samples_ = 0;
};

}  // namespace zoned::admin
