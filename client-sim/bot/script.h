// Script: the behaviour of a bot, and mixes of scripts over many bots.
#pragma once

#include "client-sim/view/view.h"
#include "shared/core/result.h"
#include "shared/core/rng.h"
#include "shared/motion/input_command.h"
#include "shared/wire/session/session_messages.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::bot {

enum class Script : std::uint8_t {
    kWander,  ///< walks in random directions, touches props now and then
    kCrowd,   ///< walks to one spot, the same for all
    kBorder,  ///< walks back and forth across the nearest border between zones
    kFight,   ///< chases and shoots the nearest player
    kHunt,    ///< chases and shoots the nearest NPC
    kChat,    ///< strolls and talks
    kIdle,    ///< stands
    kDrive,   ///< gets on the nearest thing with seats and drives about
    kSneak,   ///< follows others at half speed, unheard where the world has a stance for it
    kLook,    ///< strolls, stops and looks round through a spyglass
    kTrade,   ///< collects props and offers them to players that picked something up
};

inline constexpr int kScripts = 11;
[[nodiscard]] const char* name_of(Script script);
/// All of them, separated by commas.
[[nodiscard]] std::string script_names();

/// One entry of "--behaviour NAME[:share],...".
struct Share {
    Script script = Script::kWander;
    double share = 1.0;  ///< > 0, relative to the others
};

/// The default mix.
[[nodiscard]] std::vector<Share> default_mix();
core::Result<std::vector<Share>> parse_mix(std::string_view text);
/// The script of bot `index`. After any number of bots each script has its share as nearly as whole
/// bots allow.
[[nodiscard]] std::vector<Script> deal(const std::vector<Share>& mix, std::size_t bots);

/// The payload of the sandbox's COMMAND_SHOOT, with the entities that the view displays along the
/// ray. Returns the entity hit there.
EntityId shoot_as_seen(const view::View& view, const Vec3& direction, std::string& payload);

/// A script's means beside moving.
class Voice {
  public:
    virtual ~Voice() = default;
    virtual void command(std::uint32_t kind, std::string payload) = 0;
    /// Entity ids in the own inventory.
    [[nodiscard]] virtual std::span<const std::uint32_t> items() const = 0;
};

/// A bot that plays a game of its own, in place of the scripts above. Deterministic: the same
/// calls, the same decisions, or a test with it is not the same twice.
class OwnScript {
  public:
    virtual ~OwnScript() = default;
    /// The command for `tick`, once a tick from the moment that the own avatar is known.
    virtual motion::InputCommand decide(const view::View& view, Tick tick, Voice& voice) = 0;

    /// Each event of the game, once and in its order.
    virtual void on_event(const wire::EventMessage& event) { (void)event; }
};

/// Makes the script of a bot. `index` counts the bots of a swarm; `team` is what it logs in with.
using MakeOwnScript =
    std::function<std::unique_ptr<OwnScript>(std::size_t index, const std::string& team)>;

/// Whether others can see the change: another direction by more than rounding, or another speed.
[[nodiscard]] bool changes_course(const motion::InputCommand& before,
                                  const motion::InputCommand& after);

/// Full speed towards a direction of the world's plane, and looking there; its length does not
/// matter, and none stands still.
[[nodiscard]] motion::InputCommand walk_towards(double x, double z);

/// The decisions of one bot. Seeded: same seed, same view, same decisions.
class ScriptRunner {
  public:
    ScriptRunner(Script script, std::uint64_t seed, std::uint64_t index, std::string team);

    /// The command for `tick`. `changed` is set when direction or speed differ from the tick
    /// before.
    motion::InputCommand decide(const view::View& view, Tick tick, Voice& voice, bool& changed);

    /// A player in sight picked something up. `item`: its entity id.
    void note_pick_up(EntityId player, std::uint32_t item);

    [[nodiscard]] Script script() const { return script_; }

  private:
    enum class Prey : std::uint8_t {
        kPlayer,
        kNpc,
        kProp,
        kSeat
    };

    struct Target {
        EntityId id;
        Vec3d position = Vec3d::Zero();
        double distance = 1e9;
    };

    static constexpr double kTouchRangeM = 2.5;  // picks up and pushes what is as near
    static constexpr Tick kDecideTicks = 15;     // between two decisions of a walk to somebody

    void wander(const view::View& view, Tick tick, Voice& voice);
    void walk_to(const Vec3d& from, double x, double z, bool sprint);
    void crowd(const view::View& view);
    void border(const view::View& view);
    void fight(const view::View& view, Prey prey, Tick tick, Voice& voice);
    void chat(const view::View& view, Tick tick, Voice& voice);
    void drive(const view::View& view, Tick tick, Voice& voice);
    void sneak(const view::View& view, Tick tick);
    void look(Tick tick);
    void trade(const view::View& view, Tick tick, Voice& voice);
    void collect(const view::View& view, Tick tick, Voice& voice);
    void touch_a_prop(const view::View& view, Voice& voice);
    void pick_direction(Tick tick);
    /// Goes from strolling to sneaking or looking and back when it is time; true: not strolling.
    bool in_phase(Tick tick);

    using Wanted = std::function<bool(EntityId, const view::TypeInfo&)>;
    /// The nearest of those that the view shows; the own avatar is none of them.
    [[nodiscard]] static Target nearest(const view::View& view, const Wanted& wanted);
    [[nodiscard]] static Target nearest(const view::View& view, Prey prey);

    Script script_;
    core::Rng rng_;
    std::uint64_t seed_;
    std::string team_;
    Tick next_turn_ = 0;
    Tick next_act_ = 0;
    bool border_found_ = false;
    int border_side_ = 1;
    bool border_along_x_ = true;  // the border is a line of constant x
    double border_at_ = 0.0;
    std::uint32_t spoken_ = 0;
    bool phase_ = false;                         // sneaks, or looks, rather than strolls
    std::map<EntityId, std::uint32_t> holders_;  // players in sight and what they picked up last
    std::set<EntityId> tried_;                   // props that it could not pick up, or has
    motion::InputCommand wish_;
};

}  // namespace zoned::bot
