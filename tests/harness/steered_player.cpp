#include "tests/harness/steered_player.h"

#include "client-sim/view/aim.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace zoned::harness {

namespace {

/// Nearer to its goal than this a player stands: a step of the least speed goes further.
constexpr double kStandM = 0.02;

/// Commands count angles in parts of a turn.
std::int32_t parts_of_a_turn(double angle_rad) {
    return static_cast<std::int32_t>(std::lround(angle_rad / (2.0 * std::numbers::pi) * 65536.0));
}

void look_along(const Vec3d& direction, motion::InputCommand& command) {
    const double level = std::hypot(direction.x(), direction.z());
    command.yaw =
        static_cast<std::uint16_t>(parts_of_a_turn(std::atan2(direction.x(), direction.z())));
    command.pitch = static_cast<std::int16_t>(parts_of_a_turn(std::atan2(direction.y(), level)));
}

/// Of full speed: as much as brakes within `away_m`, and does not step beyond it.
double speed_share(const view::View& view, double away_m, std::uint16_t buttons) {
    const motion::CharacterLimits limits = view.own().limits();
    const bool sprints = (buttons & motion::kButtonSprint) != 0;
    const double full = static_cast<double>(limits.speed * (sprints ? limits.sprint_factor : 1.0F));
    const double brakes = std::sqrt(2.0 * static_cast<double>(limits.acceleration) * away_m);
    return std::min({1.0, brakes / full, away_m / (full * view.world().tick_s)});
}

}  // namespace

/// The bot asks it each tick.
class SteeredPlayer::Hand final : public bot::OwnScript {
  public:
    explicit Hand(SteeredPlayer& player) : player_(player) {}

    motion::InputCommand decide(const view::View& view,
                                Tick /*tick*/,
                                bot::Voice& /*voice*/) override {
        return player_.decide(view);
    }

    void on_event(const wire::EventMessage& event) override { player_.events_.push_back(event); }

  private:
    SteeredPlayer& player_;
};

SteeredPlayer::SteeredPlayer() = default;
SteeredPlayer::~SteeredPlayer() = default;

std::unique_ptr<bot::OwnScript> SteeredPlayer::script() {
    return std::make_unique<Hand>(*this);
}

motion::InputCommand SteeredPlayer::decide(const view::View& view) {
    motion::InputCommand command;
    command.buttons = static_cast<std::uint16_t>(held_ | std::exchange(pressed_, std::uint16_t{0}));
    if (goal_) {
        const Vec3d me = view.own().position();
        const double x = goal_->x - me.x();
        const double z = goal_->z - me.z();
        const double away_m = std::hypot(x, z);
        if (away_m > kStandM) {
            const motion::InputCommand towards = bot::walk_towards(x, z);
            const double share = speed_share(view, away_m, command.buttons);
            command.move_x = static_cast<std::int8_t>(std::lround(share * towards.move_x));
            command.move_z = static_cast<std::int8_t>(std::lround(share * towards.move_z));
            command.yaw = towards.yaw;
        }
    }
    if (gaze_) {
        look_along(*gaze_ - view::own_eye(view), command);
    }
    return command;
}

void SteeredPlayer::command(std::uint32_t kind, std::string payload) {
    if (bot_ != nullptr) {
        bot_->command(kind, std::move(payload));
    }
}

const view::View* SteeredPlayer::view() const {
    return joined() ? bot_->view() : nullptr;
}

bool SteeredPlayer::joined() const {
    return bot_ != nullptr && bot_->joined() && bot_->view() != nullptr &&
           bot_->view()->own().known();
}

EntityId SteeredPlayer::id() const {
    return joined() ? view()->own().id() : EntityId{};
}

Vec3d SteeredPlayer::position() const {
    return joined() ? view()->own().position() : Vec3d(Vec3d::Zero());
}

double SteeredPlayer::distance_to(double x, double z) const {
    const Vec3d me = position();
    return std::hypot(x - me.x(), z - me.z());
}

bool SteeredPlayer::arrived() const {
    return !goal_ || distance_to(goal_->x, goal_->z) <= kThereM;
}

std::vector<SeenEntity> SteeredPlayer::seen(std::string_view type) const {
    std::vector<SeenEntity> out;
    const view::View* const view = this->view();
    if (view == nullptr) {
        return out;
    }
    for (const auto& [id, entity] : view->store().entities()) {
        if (id == view->own().id() || !entity.present() || !entity.typed ||
            view->world().types[entity.type].name != type) {
            continue;
        }
        if (const auto shown = view->on_screen(entity)) {
            out.push_back({id, shown->position, shown->orientation});
        }
    }
    const Vec3d me = position();
    std::sort(out.begin(), out.end(), [&](const SeenEntity& a, const SeenEntity& b) {
        const double a_m = (a.position - me).squaredNorm();
        const double b_m = (b.position - me).squaredNorm();
        return a_m != b_m ? a_m < b_m : a.id < b.id;
    });
    return out;
}

std::optional<SeenEntity> SteeredPlayer::nearest(std::string_view type) const {
    const std::vector<SeenEntity> all = seen(type);
    return all.empty() ? std::nullopt : std::optional(all.front());
}

std::optional<wire::FieldValue> SteeredPlayer::field(EntityId entity, std::string_view name) const {
    const view::View* const view = this->view();
    return view == nullptr ? std::nullopt : view->field(entity, name);
}

std::size_t SteeredPlayer::heard(std::uint32_t kind) const {
    return static_cast<std::size_t>(std::count_if(
        events_.begin(), events_.end(), [kind](const auto& event) { return event.kind == kind; }));
}

}  // namespace zoned::harness
