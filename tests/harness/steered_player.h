// SteeredPlayer: a player that a test steers: where it walks and looks, what it presses and
// commands; and what it sees and hears. It is a bot of the swarm, which judges it like the others.
#pragma once

#include "client-sim/bot/bot.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::harness {

/// An entity as a player's view displays it.
struct SeenEntity {
    EntityId id;
    Vec3d position = Vec3d::Zero();
    Quat orientation = Quat::Identity();
};

/// Orders hold until the next of their kind, and are carried out while virtual time goes on. Before
/// the player has joined it sees nothing, and its place is the origin.
class SteeredPlayer {
  public:
    /// It has come to where it was sent when it is as near, m.
    static constexpr double kThereM = 0.25;

    SteeredPlayer();
    ~SteeredPlayer();
    SteeredPlayer(const SteeredPlayer&) = delete;
    SteeredPlayer& operator=(const SteeredPlayer&) = delete;

    /// Straight on to a place of the world's plane, at full speed; there it stands.
    void walk_to(double x, double z) { goal_ = Place{x, z}; }

    void stand() { goal_.reset(); }

    /// From its eyes to a place of the world. Without this order it looks where it walks.
    void look_at(const Vec3d& place) { gaze_ = place; }

    /// Buttons (motion::InputButton, and the game's) that stay down; 0: none.
    void hold(std::uint16_t buttons) { held_ = buttons; }

    /// Buttons that are down for one tick.
    void press(std::uint16_t buttons) { pressed_ |= buttons; }

    /// A reliable command of the game.
    void command(std::uint32_t kind, std::string payload = {});

    [[nodiscard]] bool joined() const;
    [[nodiscard]] EntityId id() const;
    /// As it predicts it.
    [[nodiscard]] Vec3d position() const;
    /// To a place of the world's plane, m.
    [[nodiscard]] double distance_to(double x, double z) const;
    /// It has come to where it was sent; true where it was sent nowhere.
    [[nodiscard]] bool arrived() const;

    /// The others that it sees of a type, nearest first.
    [[nodiscard]] std::vector<SeenEntity> seen(std::string_view type) const;
    /// The nearest of these.
    [[nodiscard]] std::optional<SeenEntity> nearest(std::string_view type) const;
    /// A field that the game declares, of an entity that it sees or of its own avatar; a text is
    /// good until time goes on.
    [[nodiscard]] std::optional<wire::FieldValue> field(EntityId entity,
                                                        std::string_view name) const;

    /// The game's events so far, in their order.
    [[nodiscard]] std::span<const wire::EventMessage> events() const { return events_; }

    /// How many of a kind.
    [[nodiscard]] std::size_t heard(std::uint32_t kind) const;

    /// For the swarm: the script by which a bot does as this player is told, and the bot.
    [[nodiscard]] std::unique_ptr<bot::OwnScript> script();

    void play_as(bot::Bot* bot) { bot_ = bot; }

  private:
    class Hand;

    struct Place {
        double x = 0.0;
        double z = 0.0;
    };

    [[nodiscard]] motion::InputCommand decide(const view::View& view);
    /// nullptr before it has joined.
    [[nodiscard]] const view::View* view() const;

    bot::Bot* bot_ = nullptr;
    std::optional<Place> goal_;
    std::optional<Vec3d> gaze_;
    std::uint16_t held_ = 0;
    std::uint16_t pressed_ = 0;
    std::vector<wire::EventMessage> events_;
};

}  // namespace zoned::harness
