// The rules of @GAME@: capture the flag. Two teams carry each other's flag home.
#include "server/zone/rules.h"
#include "shared/core/archive/field_archive.h"

#include "capture.h"

#include <algorithm>
#include <functional>
#include <ranges>
#include <stdexcept>

using namespace zoned;
using namespace capture;

namespace {

using Context = zone::RulesContext;
using Board = std::map<std::string, std::uint32_t>;  // captures by name
constexpr std::size_t kBoardLines = 10;
constexpr std::size_t kMostNames = 100;
const mailbox::StoreKey kBoard{mailbox::StoreScope::kWorld, "", "", "leaderboard"};

// Fields that world.txtpb declares: clients that hear of the entity know their values.
constexpr wire::FieldId kTeam = wire::field_id("team");
constexpr wire::FieldId kCarries = wire::field_id("carries");

struct Player {
    std::string name;
    std::uint8_t team = 0;
    Tick dash_at = 0;  // ready again
    Tick shove_at = 0;
    Tick dazed_until = 0;  // shoved: touches no flag
};

struct Flag {
    EntityId entity;  // hidden while somebody carries it
    EntityId carrier;
    bool home = true;
    Tick lies_until = 0;
};

class CaptureTheFlag final : public zone::Rules {
  public:
    // Flags at home, and the scores of former days.
    void on_start(Context& context) override {
        for (std::uint8_t team = 0; team < kTeams; ++team) {
            zone::SpawnDef def;
            def.type = context.type_named("flag");
            def.position = home(team);
            def.asleep = true;
            flags_[team].entity = context.spawn(def);
            context.set_field(flags_[team].entity, kTeam, std::string_view(kTeamNames[team]));
        }
        context.store_get({}, kBoard);
    }

    EntityId on_join(Context& context, const zone::JoinRequest& request) override {
        Player player{request.name, team_for(request.team)};
        zone::SpawnDef def;
        def.type = context.type_named("player");
        def.position = context.local(context.freest_spawn(kTeamNames[player.team])->position);
        def.client = request.client;
        const EntityId avatar = context.spawn(def);
        context.set_field(avatar, kTeam, std::string_view(kTeamNames[player.team]));
        players_[avatar] = std::move(player);
        context.subscribe(request.client, "game");
        context.send(request.client, leaderboard());
        return avatar;
    }

    void on_leave(Context& context, ClientId, EntityId avatar) override {
        drop(context, avatar);
        players_.erase(avatar);
        context.despawn(avatar);
    }

    void on_tick(Context& context) override {
        for (std::uint8_t team = 0; team < kTeams; ++team) {
            if (flags_[team].carrier) {
                score_if_home(context, team);
            } else {
                touch(context, team);
            }
        }
    }

    // The ability of a button: a leap to where the player looks.
    void on_input(Context& context,
                  EntityId avatar,
                  const motion::InputCommand& command,
                  std::uint16_t pressed) override {
        Player& player = players_.at(avatar);
        const Vec3 ahead(command.move_x, 0.0F, command.move_z);
        if ((pressed & kDash) != 0 && context.now() >= player.dash_at && ahead.norm() > 1.0F) {
            context.add_velocity(avatar, ahead.normalized() * kDashMps);
            player.dash_at = after(context, kDashCooldownS);
        }
    }

    // The ability of a command: the nearest opponent is knocked away and drops what it carries.
    void on_command(Context& context,
                    ClientId,
                    EntityId avatar,
                    std::uint16_t kind,
                    std::span<const std::uint8_t> payload) override {
        Player& player = players_.at(avatar);
        if (kind != kShove || !payload.empty() || context.now() < player.shove_at) {
            return;
        }
        player.shove_at = after(context, kShoveCooldownS);
        const Vec3 from = place(context, avatar);
        if (const EntityId other = nearest(context, from, kShoveM, 1 - player.team)) {
            context.add_velocity(other, (place(context, other) - from).normalized() * kShoveMps);
            drop(context, other);
            players_.at(other).dazed_until = after(context, kDazedS);
        }
    }

    void on_store(Context& context, const mailbox::StoreAnswer& answer) override {
        using enum mailbox::StoreStatus;
        if (answer.act != mailbox::StoreAct::kGet || answer.status == kRefused) {
            return;  // a board that could not be read is not written over
        }
        Board kept;
        core::FieldReader(answer.value)(kept);
        for (const auto& [name, captures] : kept) {
            board_[name] += captures;  // some may have scored before the answer came
        }
        board_read_ = true;
        context.publish("game", leaderboard());
    }

    void on_contact(Context&, const zone::EntityContact&) override {}

    void on_confirm(Context&, ClientId, EventId) override {}

    void on_message(Context&, EntityId, std::span<const std::uint8_t>) override {}

    bool busy() const override {
        return std::any_of(flags_.begin(), flags_.end(), [](const Flag& f) { return !f.home; });
    }

    void hash(core::StateHash& hash) const override {
        zone::Bytes bytes;
        save(bytes);
        hash.add_bytes(bytes);
    }

    bool save(zone::Bytes& out) const override {
        core::FieldWriter write(out);
        write(board_read_, players_, flags_, score_, board_);
        return true;
    }

    std::string load(std::span<const std::uint8_t> bytes) override {
        core::FieldReader read(bytes);
        read(board_read_, players_, flags_, score_, board_);
        return read.left() == 0 ? read.wrong() : "bytes are left over";
    }

    // The match is one zone: world.txtpb has no other that an entity could go to.
    zone::Bytes take_entity(EntityId) override { return {}; }

    void load_entity(EntityId, std::span<const std::uint8_t>) override {}

  private:
    static Tick after(const Context& context, float seconds) {
        return context.now() + static_cast<Tick>(seconds / context.dt());
    }

    static Vec3 place(const Context& context, EntityId entity) {
        return context.entities().position[context.entities().find(entity)];
    }

    static Vec3 home(std::uint8_t team) { return {kHomeX[team], 0.5F, 0.0F}; }

    // The team that was asked for; without a wish they take turns.
    std::uint8_t team_for(const std::string& wish) const {
        return wish == "red" ? 0 : wish == "blue" ? 1 : players_.size() % 2;
    }

    // The nearest player, not dazed, of a team, -1: of both; none: nobody is so near.
    EntityId nearest(Context& context, const Vec3& at, float reach, int team) {
        context.near(at, reach, near_);
        EntityId best;
        float best_m = reach;
        for (const EntityId entity : near_) {
            const auto found = players_.find(entity);
            const float away = (place(context, entity) - at).norm();
            if (found == players_.end() || away > best_m) {
                continue;
            }
            const Player& player = found->second;
            if ((team < 0 || player.team == team) && context.now() >= player.dazed_until) {
                best = entity;
                best_m = away;
            }
        }
        return best;
    }

    void touch(Context& context, std::uint8_t team) {
        Flag& flag = flags_[team];
        const bool due = context.now() >= flag.lies_until;
        const world::Entities& entities = context.entities();
        if (entities.has(entities.find(flag.entity), world::kHidden)) {  // on its way home
            flag.home = due;
            if (due) {
                context.show(flag.entity, home(team), Vec3::Zero());
                tell(context, kReturned, team);
            }
            return;
        }
        const EntityId by =
            nearest(context, place(context, flag.entity), kReachM, flag.home ? 1 - team : -1);
        if (by && players_.at(by).team != team) {
            context.hide(flag.entity);
            flag = {flag.entity, by, false, 0};
            context.set_field(by, kCarries, true);
            tell(context, kTaken, team);
        } else if (!flag.home && (by || due)) {
            context.hide(flag.entity);
            flag.lies_until = after(context, kReturnS);
        }
    }

    void drop(Context& context, EntityId carrier) {
        const std::uint8_t team = 1 - players_.at(carrier).team;
        Flag& flag = flags_[team];
        if (flag.carrier == carrier) {
            flag = {flag.entity, {}, false, after(context, kLiesS)};
            context.show(flag.entity, place(context, carrier), Vec3::Zero());
            context.set_field(carrier, kCarries, false);
            tell(context, kDropped, team);
        }
    }

    // A carrier scores at home, while its own flag stands there.
    void score_if_home(Context& context, std::uint8_t team) {
        Flag& flag = flags_[team];
        const std::uint8_t scorer = 1 - team;
        const EntityId carrier = flag.carrier;
        if (!flags_[scorer].home ||
            (place(context, carrier) - home(scorer)).norm() > kReachM + 1.0F) {
            return;
        }
        flag = {flag.entity, {}, true, 0};
        context.show(flag.entity, home(team), Vec3::Zero());
        context.set_field(carrier, kCarries, false);
        context.set_field(
            flags_[scorer].entity, wire::field_id("score"), static_cast<double>(++score_[scorer]));
        ++board_[players_.at(carrier).name];
        if (board_.size() > kMostNames) {
            board_.erase(std::ranges::min_element(board_, {}, &Board::value_type::second));
        }
        if (board_read_) {
            zone::Bytes kept;
            core::FieldWriter{kept}(board_);
            context.store_put({}, kBoard, std::move(kept));
        }
        tell(context, kScored, scorer);
        context.publish("game", leaderboard());
    }

    static void tell(Context& context, std::uint16_t kind, std::uint8_t team) {
        context.publish("game", {kind, {team}});
    }

    zone::RulesEvent leaderboard() const {
        std::vector<std::pair<std::string, std::uint32_t>> lines(board_.begin(), board_.end());
        std::ranges::stable_sort(
            lines, std::greater(), [](const auto& line) { return line.second; });
        std::string text;
        for (const auto& [name, captures] : lines | std::views::take(kBoardLines)) {
            text += std::to_string(captures) + " " + name + "\n";
        }
        return {kLeaderboard, zone::Bytes(text.begin(), text.end())};
    }

    bool board_read_ = false;
    std::map<EntityId, Player> players_;
    std::array<Flag, kTeams> flags_;
    std::array<std::uint32_t, kTeams> score_{};
    Board board_;                 // of all days
    std::vector<EntityId> near_;  // scratch
};

}  // namespace

std::unique_ptr<zone::Rules> zone::make_rules(const RulesSettings& settings,
                                              const world::TypeTable&) {
    if (!settings.empty()) {
        throw std::runtime_error("@GAME@ has no settings");
    }
    return std::make_unique<CaptureTheFlag>();
}
