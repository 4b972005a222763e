// View: one client's picture of the world: applies state packets, and notices a divergence.
#pragma once

#include "client-sim/link/datagram_channel.h"
#include "client-sim/view/bursts.h"
#include "client-sim/view/entity_store.h"
#include "client-sim/view/own_avatar.h"
#include "client-sim/view/playout.h"
#include "client-sim/view/world_info.h"
#include "shared/wire/publication.h"
#include "shared/wire/record/record_codec.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace zoned::view {

/// Receives each publication that becomes visible.
class ViewListener {
  public:
    virtual ~ViewListener() = default;
    /// A publication of `entity` is displayed from `from_tick` on.
    virtual void on_shown(EntityId entity, Tick publication_tick, Tick from_tick) = 0;
};

enum class ViewKind : std::uint8_t {
    kExtrapolate,  ///< displays the server's present tick: dead reckoning to now, then convergence
    kInterpolate,  ///< displays a tick so far back that its updates have come (Playout): no
                   ///< prediction is ever wrong by more than the bound, at the price of that delay
};

struct ViewSettings {
    motion::ConvergenceMethod convergence = motion::ConvergenceMethod::kProjectiveVelocity;
    bool keep_history = false;  ///< needed for audits
    ViewKind kind = ViewKind::kExtrapolate;
    DisplayedState displayed_state = DisplayedState::kPredicted;  ///< of an extrapolating view
    bool meter = false;  ///< counts the bytes of packets by purpose
};

/// The result of applying a packet.
struct PacketResult {
    bool read = false;      ///< false: the packet must not be acknowledged
    Correction correction;  ///< of the own prediction, if the packet carried the own state
};

struct ViewStats {
    std::uint64_t records = 0;
    std::uint64_t shown = 0;      ///< publications displayed
    std::uint64_t absolutes = 0;  ///< of records
    std::uint64_t removes = 0;
    std::array<std::uint64_t, motion::kPredictorOrders> by_order{};  ///< of shown
    std::uint64_t unknown_keyframes = 0;
    std::uint64_t malformed_records = 0;
    std::array<std::uint64_t, wire::kDeclaredFaults> refused_fields{};  ///< of these, by reason
    std::uint64_t undecoded_packets = 0;  ///< of records coded for this client alone ...
    std::uint64_t overtaken_packets = 0;  ///< ... that came after their base was dropped
    std::uint64_t silent_entities = 0;    ///< moving, but without an update for too long
    std::uint64_t resets = 0;
    std::uint64_t dropped_by_reset = 0;
    std::uint64_t zone_changes = 0;
    std::uint64_t environment_updates =
        0;  ///< events with the state of clocks and shared variables
    std::uint64_t environment_malformed = 0;
    std::uint64_t environment_corrected = 0;  ///< clocks and variables that these events corrected
    std::uint64_t bursts = 0;                 ///< events that emit cosmetic particles
    std::uint64_t bursts_malformed = 0;
    std::uint64_t bursts_refused = 0;  ///< too many at a time
    std::uint64_t input_missing = 0;   ///< own states that report a late command
};

class View {
  public:
    /// A moving entity is published every 240 ticks at least: three times that is too long.
    static constexpr Tick kSilentTicks = 720;
    /// After a reset, an entity that is not received again within this time is removed.
    static constexpr double kResetS = 2.0;
    /// This many undecodable packets in a row are no accident.
    static constexpr int kUndecodedForReset = 3;

    View(std::shared_ptr<const WorldInfo> world,
         const ViewSettings& settings,
         ViewListener* listener);

    /// Ticks up to `tick` have been displayed: later updates show from the next one on.
    void evaluate(Tick tick);

    [[nodiscard]] Tick tick() const { return tick_; }

    /// Applies a packet; hostile bytes end in a request for a reset, never in a crash.
    PacketResult apply(const link::OpenedPacket& packet, double now_s);

    /// An event of the server's own: cosmetic bursts are applied, other kinds ignored here.
    void apply(const wire::EventMessage& event);

    /// Called about once a second: drops old data, and looks for entities that fell silent.
    void maintain(double now_s);

    /// A reason to ask the server for a reset, at most once in kResetS; empty: none.
    std::string take_reset_wish(double now_s);

    /// Takes over from a view before this one, of the same session: the shared clocks, variables
    /// and doors, which the server does not tell again, and what was counted.
    void go_on_with(const View& before) {
        environment_ = before.environment_;
        *courses_ = *before.courses_;
        stats_ = before.stats_;
        traffic_ = before.traffic_;
    }

    /// The server's clock was set back, by a stall of the server: the view goes on from `tick`.
    void set_back(Tick tick);

    [[nodiscard]] const EntityStore& store() const { return store_; }

    [[nodiscard]] ViewKind kind() const { return settings_.kind; }

    /// Ticks that the view aims to be behind the server: 0 for an extrapolating one.
    [[nodiscard]] Tick delay() const {
        return settings_.kind == ViewKind::kInterpolate ? playout_.delay() : 0;
    }

    /// The newest tick that has been displayed.
    [[nodiscard]] Tick displayed_tick() const;

    /// Progress of an interpolating view towards the tick after that, [0, 1).
    [[nodiscard]] double displayed_fraction() const;

    /// View tick at which `tick` was displayed, and so the updates used: itself for an
    /// extrapolating view. None when it was not displayed, or is forgotten.
    [[nodiscard]] std::optional<Tick> shown_at(Tick tick) const;

    /// The view's version of an entity for `tick` by its knowledge at view tick `known_by`;
    /// nullptr: none.
    [[nodiscard]] const Version* held(const Entity& entity, Tick tick, Tick known_by) const;

    /// The state that it displayed for the entity at `tick`, by the same knowledge; `version` is
    /// the view's version.
    [[nodiscard]] WorldState displayed(const Entity& entity,
                                       const Version& version,
                                       Tick tick,
                                       Tick known_by) const;

    /// The state on the screen of a displayed entity, `fraction` of a tick after tick().
    [[nodiscard]] std::optional<WorldState> on_screen(const Entity& entity,
                                                      double fraction = 0.0) const;

    /// The newest known value of a declared field of a present entity, or of the own avatar; a text
    /// is good until the next packet. None where its type has no such field, or it is not known.
    [[nodiscard]] std::optional<wire::FieldValue> field(EntityId entity,
                                                        std::string_view name) const;

    [[nodiscard]] const WorldInfo& world() const { return *world_; }

    [[nodiscard]] const Bursts& bursts() const { return bursts_; }

    /// Clocks and variables that run here, for any tick that is not long ago.
    [[nodiscard]] const clock::SharedEnvironment& environment() const { return environment_; }

    /// Of the doors that rules move.
    [[nodiscard]] const motion::DoorCourses& door_courses() const { return *courses_; }

    /// Of the platforms that rules move.
    [[nodiscard]] const motion::PlatformCourses& platform_courses() const {
        return *platform_courses_;
    }

    [[nodiscard]] OwnAvatar& own() { return own_; }

    [[nodiscard]] const OwnAvatar& own() const { return own_; }

    [[nodiscard]] const ViewStats& stats() const { return stats_; }

    /// Traffic received by all views of this client together; empty without ViewSettings::meter.
    /// The sender's heartbeats and resends count as updates here.
    [[nodiscard]] const wire::TrafficTable& traffic() const { return traffic_; }

    /// Zone of the newest packet.
    [[nodiscard]] ZoneId zone() const { return zone_; }

  private:
    bool apply_record(wire::RecordReader& reader, const link::OpenedPacket& packet, double now_s);
    bool apply_coded(const link::OpenedPacket& packet, double now_s);
    void show_coded(const wire::record::RecordFrame& frame,
                    const link::OpenedPacket& packet,
                    double now_s);
    void not_decoded(const link::OpenedPacket& packet);
    [[nodiscard]] EntityStore::Record record_of(const link::OpenedPacket& packet,
                                                double now_s) const;
    ApplyOutcome show(const EntityStore::Record& record,
                      const wire::QuantizedState& state,
                      const wire::DeclaredUpdate* declared);
    void refuse_fields(wire::DeclaredFault fault);
    void apply_records(const link::OpenedPacket& packet, double now_s);
    void count_packet(const link::OpenedPacket& packet);
    void count_record(wire::RecordReader& gauge);
    void count_coded(const wire::record::RecordFrame& frame, std::size_t bytes);
    void apply_environment(const wire::EventMessage& event);
    void diverged(const char* reason);
    [[nodiscard]] DisplaySettings display_settings() const;

    std::shared_ptr<motion::DoorCourses> courses_;
    std::shared_ptr<motion::PlatformCourses> platform_courses_;
    std::shared_ptr<const WorldInfo> world_;  // its doors and platforms as the courses say
    ViewSettings settings_;
    ViewListener* listener_;
    EntityStore store_;
    std::optional<wire::record::RecordDecoder> coded_;  // from the first such packet on
    std::uint64_t newest_decoded_ = 0;                  // of the coded ones
    int undecoded_ = 0;                                 // in a row, newer than that
    OwnAvatar own_;
    Playout playout_;
    Bursts bursts_;
    clock::SharedEnvironment environment_;
    ViewStats stats_;
    wire::TrafficTable traffic_;
    /// Traffic of the record applied last; unread until then.
    wire::TrafficReason reason_ = wire::TrafficReason::kUnread;
    Tick tick_ = 0;
    Tick oldest_update_ =
        0;  // of the packet being applied: the earliest tick that its updates describe
    ZoneId zone_;
    std::uint64_t newest_sequence_ = 0;
    std::string wish_;
    double reset_until_s_ = -1.0;
    bool resetting_ = false;
};

}  // namespace zoned::view
