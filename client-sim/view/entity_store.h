// EntityStore: a client's knowledge of the entities around it, now and at recent ticks.
#pragma once

#include "client-sim/view/playout.h"
#include "client-sim/view/world_info.h"
#include "shared/core/ids.h"
#include "shared/motion/convergence.h"
#include "shared/wire/publication.h"

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace zoned::view {

/// One publication from the tick on at which it was first displayed, until the next version.
/// Evaluating versions gives the predicted and the displayed state of any recent tick exactly as
/// they were, without storing them tick by tick.
struct Version {
    Tick from_tick = 0;    ///< first view tick that uses it
    bool present = false;  ///< false: the entity was not in the view
    ZoneId zone;           ///< zone of the local coordinates in `state`
    std::uint8_t lod = 0;
    Tick publication_tick = 0;
    /// Server tick from which it holds. It is the publication's, or the packet's where the entity
    /// appears, leaves or passes to another stream.
    Tick event_tick = 0;
    std::uint64_t sequence = 0;  ///< of the newest packet that carried it (or removed the entity)
    wire::QuantizedState quantized;
    motion::KinematicState state;     ///< dequantised
    motion::Convergence convergence;  ///< from the state displayed at `from_tick` - 1
    bool converging = false;
};

/// The declared fields of an entity from a publication on.
struct FieldRow {
    Tick publication_tick = 0;
    std::vector<std::uint32_t> words;  ///< as wire::FieldSchema lays them out
};

struct ReceivedKeyframe {
    ZoneId zone;
    std::uint8_t lod = 0;
    std::uint8_t number = 0;
    std::uint64_t sequence = 0;  ///< of the packet that brought it
    wire::QuantizedState state;
};

struct Entity {
    TypeIndex type = 0;
    bool typed = false;             ///< an absolute record has given the type
    Tick present_since = 0;         ///< first view tick of the present stay
    double heard_s = 0.0;           ///< local time of the newest record
    bool confirmed = true;          ///< received again since the last view reset
    std::vector<Version> versions;  ///< ascending by from_tick; the last one holds now
    std::vector<Version> late;      ///< came after newer ones; for views that show the past
    std::vector<ReceivedKeyframe> keyframes;
    std::vector<FieldRow> fields;  ///< ascending; the last one holds now. Empty: its type has none

    [[nodiscard]] bool present() const { return !versions.empty() && versions.back().present; }
};

/// A state in world coordinates.
struct WorldState {
    Vec3d position = Vec3d::Zero();
    Quat orientation = Quat::Identity();
    Vec3 velocity = Vec3::Zero();
};

enum class ApplyOutcome : std::uint8_t {
    kShown,  ///< a new publication is in the view
    kLate,   ///< older than the shown one, useful to a view that shows the past
    kOld,    ///< known already, or older than the shown one
    kNoKeyframe,
};

/// The state displayed for a publication.
enum class DisplayedState : std::uint8_t {
    kPredicted,  ///< dead reckoning by the kind of prediction that it names
    kPublished,  ///< the published state, unmoved until the next: shows the value of the prediction
};

struct DisplaySettings {
    motion::ConvergenceMethod convergence = motion::ConvergenceMethod::kProjectiveVelocity;
    DisplayedState displayed_state = DisplayedState::kPredicted;
    bool keep_history = false;  ///< needed for audits
    bool past = false;          ///< the view shows the past: every publication counts
};

/// Publications are ordered as follows. Within a stream (zone, LOD) by publication tick; between
/// streams by the sequence of the packet, because the server changes streams for a reason. A remove
/// wins only over records of older packets. Keyframes are kept in any case: the server may refer to
/// any that this client has acknowledged.
class EntityStore {
  public:
    static constexpr Tick kHistoryTicks = 160;
    static constexpr std::size_t kKeyframes = 24;
    /// Most entities in one view; more mean an attack.
    static constexpr std::size_t kMaxEntities = 65536;

    EntityStore(const WorldInfo& world, const DisplaySettings& settings);

    struct Record {
        wire::RecordHead head;
        std::uint64_t sequence = 0;  ///< of the packet; ascends per client, across zones
        Tick publication_tick = 0;
        Tick packet_tick = 0;
        ZoneId zone;
        Tick view_tick =
            0;  ///< newest tick evaluated: the record is displayed from the next one on
        bool coded = false;  ///< coded for this client alone: it becomes no keyframe
        double now_s = 0.0;
    };

    [[nodiscard]] const ReceivedKeyframe* keyframe(EntityId entity,
                                                   ZoneId zone,
                                                   std::uint8_t lod,
                                                   std::uint8_t number) const;
    [[nodiscard]] const Entity* find(EntityId entity) const;

    /// An absolute record becomes a keyframe; both kinds become the shown publication if newest.
    /// `declared`: the declared fields that it carries; null: none.
    ApplyOutcome apply(const Record& record,
                       const wire::QuantizedState& state,
                       const wire::DeclaredUpdate* declared = nullptr);
    /// The declared fields of an entity by what was published up to a tick; empty: none are known.
    [[nodiscard]] static std::span<const std::uint32_t> fields_at(const Entity& entity, Tick tick);
    bool remove(EntityId entity, std::uint64_t sequence, Tick packet_tick, Tick view_tick);
    /// A removed entity keeps its keyframes for a while; forgets the stale ones.
    void prune(Tick view_tick);
    /// All shown entities must be received again ...
    void begin_reset();
    /// ... or they are removed. Returns the number of removed entities.
    std::size_t end_reset(Tick view_tick);

    /// The server's clock was set back to `view_tick`: the newest publications hold from there on,
    /// and what was displayed for later ticks is forgotten.
    void set_back(Tick view_tick);

    [[nodiscard]] const std::map<EntityId, Entity>& entities() const { return entities_; }

    [[nodiscard]] std::size_t present_count() const { return present_count_; }

    /// The version that held at a tick (nullptr: none, or forgotten).
    [[nodiscard]] static const Version* version_at(const Entity& entity, Tick tick);
    /// Dead reckoning only.
    [[nodiscard]] WorldState predicted(const Version& version, Tick tick) const;
    /// The state on the screen: the prediction and the rest of the offset that convergence removes.
    [[nodiscard]] WorldState displayed(const Version& version, double tick) const;

    /// The version that held at server tick `tick` by the knowledge at view tick `known_by`; for
    /// views that show the past. Its prediction for `tick` is within the promised bound then, as no
    /// newer publication holds yet (nullptr: none, or forgotten).
    [[nodiscard]] static const Version* implied(const Entity& entity, Tick tick, Tick known_by);
    /// The first version after `tick` that was known at view tick `known_by`, or nullptr.
    [[nodiscard]] static const Version* following(const Entity& entity, Tick tick, Tick known_by);
    /// The state that an interpolating view displays for `tick` (with its fraction) at view tick
    /// `known_by`: the prediction of the implied version, led to the following one within the last
    /// Playout::lead_ticks before that holds: a cubic Hermite spline in their difference,
    /// continuous in position and velocity at both ends. nullopt: not in the view.
    /// `remaining_error_m` receives the largest distance from the prediction
    /// (Convergence::remaining_error).
    [[nodiscard]] std::optional<WorldState> interpolated(const Entity& entity,
                                                         double tick,
                                                         Tick known_by,
                                                         double* remaining_error_m = nullptr) const;

    [[nodiscard]] bool upright(TypeIndex type) const {
        return type < world_->types.size() && world_->types[type].upright;
    }

    /// Duration of blending, s.
    static constexpr float kBlendS = 0.15F;
    /// Larger jumps are teleports: shown at once.
    static constexpr float kSnapM = 4.0F;

  private:
    void store_keyframe(Entity& entity, const Record& record, const wire::QuantizedState& state);
    [[nodiscard]] static bool newer(const Version& shown, const Record& record);
    void show(Entity& entity, const Record& record, const wire::QuantizedState& state);
    void follow_fields(Entity& entity, const Record& record, const wire::DeclaredUpdate* declared);
    void push_version(Entity& entity, Version version, Tick view_tick);
    ApplyOutcome keep_late(Entity& entity, const Record& record, const wire::QuantizedState& state);
    [[nodiscard]] Version version_of(const Entity& entity,
                                     const Record& record,
                                     const wire::QuantizedState& state) const;
    [[nodiscard]] motion::KinematicState local_prediction(const Version& version,
                                                          double tick,
                                                          bool before = false) const;
    /// The target of convergence: the prediction, or the publication itself (DisplaySettings).
    [[nodiscard]] motion::KinematicState local_base(const Version& version,
                                                    double tick,
                                                    bool before = false) const;
    [[nodiscard]] motion::KinematicState local_display(const Version& version, double tick) const;
    [[nodiscard]] Vec3d origin(ZoneId zone) const;

    const WorldInfo* world_;
    DisplaySettings settings_;
    std::map<EntityId, Entity> entities_;
    std::size_t present_count_ = 0;
};

}  // namespace zoned::view
