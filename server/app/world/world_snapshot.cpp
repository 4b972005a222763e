// How a world is saved and loaded: a head that names its build and config, then what crosses zones,
// then the zones.
#include "server/app/world/world.h"
#include "server/recording/recording_format.h"
#include "server/zone/border/zone_portal_exchange.h"
#include "server/zone/snapshot/zone_snapshot.h"
#include "shared/core/archive/field_archive.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

namespace zoned::app {

namespace {

constexpr std::array<char, 8> kMagic{'z', 'o', 'n', 'e', 'd', 's', 'n', 'p'};
/// Version of the layout. Raise it with every change after which older bytes would be read wrongly.
constexpr std::uint32_t kSnapshotFormat = 9;

struct SnapshotHead {
    std::array<char, 8> magic = kMagic;
    std::uint32_t format = kSnapshotFormat;
    std::uint32_t generation = recording::kSimulationGeneration;
    std::uint64_t config = 0;
};

std::string_view text_of(std::span<const std::uint8_t> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Empty: a world of this build and config may be loaded.
std::string unfit(const SnapshotHead& head, const SnapshotHead& own) {
    if (head.magic != own.magic) {
        return "these bytes are no snapshot";
    }
    if (head.format != own.format) {
        return "format " + std::to_string(head.format) + ", not " + std::to_string(own.format);
    }
    if (head.generation != own.generation) {
        return "the snapshot is of generation " + std::to_string(head.generation) +
               " of the simulation, this build of " + std::to_string(own.generation);
    }
    if (head.config != own.config) {
        return "the snapshot is of another config";
    }
    return {};
}

}  // namespace

template <class Archive>
void World::serialize(Archive& archive) {
    std::uint64_t zones = zones_.size();
    archive.section("world", [&] {
        archive(zones, now_, zone_of_, next_event_, bursts_sent_, handoffs_, client_handoffs_);
        archive(undeliverable_);
        if constexpr (Archive::kReads) {
            if (zones != zones_.size()) {
                archive.fail(std::to_string(zones) + " zones, not " +
                             std::to_string(zones_.size()));
            }
            for (const auto& [client, zone] : zone_of_) {
                if (zone >= zones_.size()) {
                    archive.fail("a client is in a zone that there is not");
                }
            }
        }
    });
    archive.section("topics", [&] { archive(topics_); });
    if (parties_) {
        archive.section("parties", [&] { archive(*parties_); });
    }
    if (instances_) {
        archive.section("instances", [&] { archive(*instances_); });
    }
    if (matches_) {
        archive.section("matches", [&] { archive(*matches_); });
    }
    archive.section("environment", [&] {
        if (environment_) {
            archive(*environment_);
        }
        if (door_courses_) {
            archive(*door_courses_);
        }
        if (platform_courses_) {
            archive(*platform_courses_);
        }
    });
    if constexpr (Archive::kReads) {
        if (!archive.good()) {
            return;
        }
        bool doors = false;
        for (zone::ZoneState* state : states_) {
            state->now = now_;
            doors = doors || !state->doors.body.empty();
        }
        if (doors) {
            // In all zones: the paths between them are made of the ground of each.
            bake_maps();
            zone::join_paths(states_);
        }
    }
    for (zone::ZoneState* state : states_) {
        archive.section("zone " + std::to_string(state->settings.id.value), [&] {
            if constexpr (Archive::kReads) {
                zone::load_zone(*state, archive);
            } else {
                zone::save_zone(*state, archive);
            }
        });
    }
}

std::string World::save(std::vector<std::uint8_t>& out,
                        std::vector<core::ArchiveSection>* sections) const {
    out.clear();
    if (!stopped_.empty()) {
        return "zone " + std::to_string(stopped_.front().zone.value) +
               ": it stopped after a fault, and its state is of no use";
    }
    core::FieldWriter archive(out);
    SnapshotHead head;
    head.config = config_hash_;
    archive(head.magic, head.format, head.generation, head.config);
    std::uint64_t checksum = 0;
    archive(checksum);
    const std::size_t body = out.size();
    const_cast<World&>(*this).serialize(archive);  // writing leaves it as it is
    checksum = recording::checksum_of(text_of(std::span(out).subspan(body)));
    std::vector<std::uint8_t> sum;
    core::FieldWriter write_sum(sum);
    write_sum(checksum);
    std::copy(sum.begin(), sum.end(), out.begin() + static_cast<std::ptrdiff_t>(body - sum.size()));
    if (sections != nullptr) {
        *sections = archive.sections();
    }
    return archive.wrong();
}

std::string World::load(std::span<const std::uint8_t> bytes) {
    if (now_ != 0) {
        return "a world takes a snapshot before its first tick only";
    }
    core::FieldReader archive(bytes);
    SnapshotHead own;
    own.config = config_hash_;
    SnapshotHead head;
    std::uint64_t checksum = 0;
    archive(head.magic, head.format, head.generation, head.config, checksum);
    if (!archive.good()) {
        return "the head: " + archive.wrong();
    }
    std::string wrong = unfit(head, own);
    if (!wrong.empty()) {
        return wrong;
    }
    if (checksum != recording::checksum_of(text_of(bytes.last(archive.left())))) {
        return "the snapshot is damaged: its checksum differs";
    }
    serialize(archive);
    if (archive.good() && archive.left() > 0) {
        archive.fail(std::to_string(archive.left()) + " bytes are left over");
    }
    return archive.wrong();
}

}  // namespace zoned::app
