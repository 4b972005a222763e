#include "server/scripting/script_rules.h"

#include "server/scripting/api/arguments.h"
#include "server/scripting/loaded_script.h"
#include "server/scripting/state/state_bytes.h"
#include "server/zone/context/stop_context.h"
#include "server/zone/groups/instance.h"
#include "server/zone/groups/match.h"
#include "server/zone/groups/party.h"
#include "shared/core/archive/field_archive.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace zoned::scripting {

namespace {

/// First byte of saved state; a change of its form changes it.
constexpr std::uint8_t kFormat = 0x53;
/// Errors at more places than this are counted alone.
constexpr std::size_t kMostLoggedPlaces = 100;
/// A zone asks may_hear for many pairs in a tick.
constexpr std::int64_t kHearInstructions = 1000;
constexpr float kFullStick = 127.0F;

TypeIndex avatar_type(const ScriptSettings& settings, const world::TypeTable& types) {
    const auto at = std::find_if(types.begin(), types.end(), [&](const world::EntityType& type) {
        return type.name == settings.avatar;
    });
    if (at == types.end() || at->kind != world::EntityKind::kCharacter) {
        throw std::runtime_error("script.avatar: no character type is called '" + settings.avatar +
                                 "'");
    }
    return static_cast<TypeIndex>(at - types.begin());
}

/// "game.lua:12" of "game.lua:12: the error".
std::string place_of(const ScriptError& error) {
    const std::size_t file = error.text.find(':');
    return error.text.substr(0, error.text.find(':', file == std::string::npos ? 0 : file + 1));
}

void push_bytes(lua_State* lua, std::span<const std::uint8_t> bytes) {
    lua_pushlstring(lua, reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

void push_truth(lua_State* lua, bool truth) {
    lua_pushboolean(lua, truth ? 1 : 0);
}

const char* name_of(mailbox::StoreStatus status) {
    switch (status) {
        case mailbox::StoreStatus::kDone:
            return "done";
        case mailbox::StoreStatus::kAbsent:
            return "absent";
        case mailbox::StoreStatus::kRefused:
            break;
    }
    return "refused";
}

/// Lends the context to the functions of the host for one call.
class Lent {
  public:
    Lent(Host& host, zone::RulesContext& context, bool may_change) : host_(host) {
        host.context = &context;
        host.may_change = may_change;
    }

    ~Lent() {
        host_.context = nullptr;
        host_.may_change = false;
    }

    Lent(const Lent&) = delete;
    Lent& operator=(const Lent&) = delete;

  private:
    Host& host_;
};

}  // namespace

ScriptRules::ScriptRules(const ScriptSettings& settings,
                         const zone::RulesSettings& rules,
                         const world::TypeTable& types,
                         ScriptLog log)
    : settings_(settings),
      avatar_(avatar_type(settings, types)),
      state_budget_{0, settings.limits.state_bytes, {}},
      host_(std::make_unique<Host>()) {
    host_->shared = std::make_shared<StateTable>(state_budget_);
    host_->entities = std::make_shared<StateTable>(state_budget_);
    host_->log = std::move(log);
    script_ = std::make_unique<LoadedScript>(settings_, rules, types, *host_);
    script_->budget().tick_instructions = settings_.limits.instructions_per_tick;
}

ScriptRules::~ScriptRules() = default;

bool ScriptRules::is_called(Callback callback) const {
    return script_->has(callback) && !(settings_.on_errors == ErrorPolicy::kMute &&
                                       errors(callback) > settings_.errors_allowed);
}

void ScriptRules::prepare(zone::RulesContext& context) {
    if (tick_ != context.now()) {
        tick_ = context.now();
        script_->budget().tick_instructions = settings_.limits.instructions_per_tick;
    }
}

template <class Push>
bool ScriptRules::call(zone::RulesContext& context, Callback callback, Push&& push) {
    prepare(context);
    if (!is_called(callback)) {
        return false;
    }
    if (script_->budget().tick_instructions <= 0 && callback != Callback::kJoin &&
        callback != Callback::kLeave) {
        note_not_called(callback);
        return false;
    }
    const Lent lent(*host_, context, true);
    const auto error =
        script_->call(callback, settings_.limits.instructions_per_call, push, [](lua_State*) {});
    state_budget_.removed.clear();
    if (error) {
        note_error(callback, *error);
    }
    return !error;
}

void ScriptRules::log_error(Callback callback, const ScriptError& error) const {
    if (logged_.size() >= kMostLoggedPlaces || !logged_.insert(place_of(error)).second) {
        return;
    }
    host_->log(ScriptLine::kError,
               "error in " + std::string(scripting::name_of(callback)) + ": " + error.text +
                   (error.traceback.empty() ? "" : "\n" + error.traceback));
}

void ScriptRules::note_not_called(Callback callback) {
    ScriptError error;
    error.text = scripting::name_of(callback);
    error.text += ": not called: the tick takes more than script.instructions_per_tick";
    note_error(callback, error);
}

void ScriptRules::note_error(Callback callback, const ScriptError& error) {
    ++errors_[static_cast<std::size_t>(callback)];
    log_error(callback, error);
    if (settings_.on_errors == ErrorPolicy::kStopZone && errors() > settings_.errors_allowed) {
        throw std::runtime_error("script: " + error.text);
    }
}

std::uint64_t ScriptRules::errors() const {
    return std::accumulate(errors_.begin(), errors_.end(), std::uint64_t{0});
}

void ScriptRules::on_start(zone::RulesContext& context) {
    call(context, Callback::kStart, [](lua_State*) { return 0; });
}

void ScriptRules::on_stop(zone::StopContext& context) const {
    if (!is_called(Callback::kStop)) {
        return;
    }
    // As may_hear it changes nothing, and counts for no tick.
    const Lent lent(*host_, const_cast<zone::RulesContext&>(context.zone()), false);
    host_->stop = &context;
    script_->budget().tick_instructions = settings_.limits.instructions_per_tick;
    const auto error = script_->call(
        Callback::kStop,
        settings_.limits.instructions_per_call,
        [](lua_State*) { return 0; },
        [](lua_State*) {});
    host_->stop = nullptr;
    if (error) {
        log_error(Callback::kStop, *error);
    }
}

EntityId ScriptRules::on_join(zone::RulesContext& context, const zone::JoinRequest& request) {
    zone::SpawnDef def;
    def.type = avatar_;
    def.position = request.spawn_position;
    def.client = request.client;
    const EntityId avatar = context.spawn(def);
    call(context, Callback::kJoin, [&](lua_State* lua) {
        lua_pushinteger(lua, request.client.value);
        push_entity(lua, avatar);
        push_text(lua, request.name);
        push_text(lua, request.team);
        push_text(lua, request.account);
        return 5;
    });
    return avatar;
}

void ScriptRules::on_leave(zone::RulesContext& context, ClientId client, EntityId avatar) {
    const bool decided = call(context, Callback::kLeave, [&](lua_State* lua) {
        lua_pushinteger(lua, client.value);
        push_entity(lua, avatar);
        return 2;
    });
    const world::Row row = context.entities().find(avatar);
    if (!decided && row != world::kNoRow && !context.entities().has(row, world::kGhost)) {
        context.despawn(avatar);
        host_->entities->set(std::int64_t{avatar.value}, std::monostate());
    }
}

void ScriptRules::on_command(zone::RulesContext& context,
                             ClientId client,
                             EntityId avatar,
                             std::uint16_t kind,
                             std::span<const std::uint8_t> payload) {
    call(context, Callback::kCommand, [&](lua_State* lua) {
        lua_pushinteger(lua, client.value);
        push_entity(lua, avatar);
        lua_pushinteger(lua, kind);
        push_bytes(lua, payload);
        return 4;
    });
}

void ScriptRules::on_input(zone::RulesContext& context,
                           EntityId avatar,
                           const motion::InputCommand& command,
                           std::uint16_t pressed) {
    call(context, Callback::kInput, [&](lua_State* lua) {
        push_entity(lua, avatar);
        lua_pushnumber(lua, static_cast<lua_Number>(command.move_x / kFullStick));
        lua_pushnumber(lua, static_cast<lua_Number>(command.move_z / kFullStick));
        lua_pushinteger(lua, command.buttons);
        lua_pushinteger(lua, pressed);
        lua_pushinteger(lua, command.yaw);
        lua_pushinteger(lua, command.pitch);
        return 7;
    });
}

void ScriptRules::on_contact(zone::RulesContext& context, const zone::EntityContact& contact) {
    call(context, Callback::kContact, [&](lua_State* lua) {
        push_entity(lua, contact.a);
        push_entity(lua, contact.b);
        lua_pushnumber(lua, static_cast<lua_Number>(contact.approach_speed));
        lua_pushnumber(lua, static_cast<lua_Number>(contact.impulse));
        push_vector(lua, contact.point);
        push_truth(lua, contact.began);
        push_truth(lua, contact.ended);
        return 9;
    });
}

void ScriptRules::on_joint_broken(zone::RulesContext& context, const zone::BrokenJoint& joint) {
    call(context, Callback::kJointBroken, [&](lua_State* lua) {
        lua_pushinteger(lua, joint.joint.value);
        push_entity(lua, joint.a);
        push_entity(lua, joint.b);
        push_entity(lua, joint.root);
        push_text(lua, joint.name);
        lua_pushnumber(lua, static_cast<lua_Number>(joint.force_n));
        return 6;
    });
}

void ScriptRules::on_trigger(zone::RulesContext& context, const zone::TriggerEvent& event) {
    call(context, Callback::kTrigger, [&](lua_State* lua) {
        push_text(lua, event.trigger);
        push_entity(lua, event.entity);
        push_truth(lua, event.entered);
        return 3;
    });
}

void ScriptRules::on_use(zone::RulesContext& context, const zone::LeverUse& use) {
    call(context, Callback::kUse, [&](lua_State* lua) {
        push_entity(lua, use.lever);
        push_entity(lua, use.user);
        push_truth(lua, use.on);
        return 3;
    });
}

zone::ContactWish ScriptRules::contact_wish(TypeIndex type) const {
    return script_->contact_wish(type);
}

bool ScriptRules::may_hear(const zone::RulesContext& context,
                           EntityId viewer,
                           EntityId entity) const {
    if (!is_called(Callback::kMayHear)) {
        return true;
    }
    // Nothing that changes may be called: may_change stays false.
    const Lent lent(*host_, const_cast<zone::RulesContext&>(context), false);
    bool may = false;
    // It runs where no order of calls is recorded: outside of the tick's budget and of counts.
    const std::int64_t of_tick = script_->budget().tick_instructions;
    const auto error = script_->call(
        Callback::kMayHear,
        kHearInstructions,
        [&](lua_State* lua) {
            push_entity(lua, viewer);
            push_entity(lua, entity);
            return 2;
        },
        [&](lua_State* lua) { may = lua_toboolean(lua, -1) != 0; });
    script_->budget().tick_instructions = of_tick;
    if (error) {
        log_error(Callback::kMayHear, *error);
    }
    return may;
}

std::vector<zone::TypeField> ScriptRules::declared_fields() const {
    return script_->fields();
}

void ScriptRules::on_timer(zone::RulesContext& context, const zone::DueTimer& timer) {
    call(context, Callback::kTimer, [&](lua_State* lua) {
        lua_pushinteger(lua, static_cast<lua_Integer>(timer.id.value));
        push_entity(lua, timer.entity);
        lua_pushinteger(lua, timer.kind);
        push_bytes(lua, timer.payload);
        return 4;
    });
}

void ScriptRules::on_party(zone::RulesContext& context, const zone::PartyChange& change) {
    call(context, Callback::kParty, [&](lua_State* lua) {
        push_text(lua, zone::kPartyEventNames[static_cast<std::size_t>(change.event)]);
        lua_pushinteger(lua, change.party.value);
        push_entity(lua, change.player);
        push_entity(lua, change.other);
        push_text(lua, change.name);
        if (change.client) {
            lua_pushinteger(lua, change.client.value);
        } else {
            lua_pushnil(lua);
        }
        push_text(lua, zone::kPartyRefusalNames[static_cast<std::size_t>(change.refusal)]);
        return 7;
    });
}

void ScriptRules::on_match(zone::RulesContext& context, const zone::MatchChange& change) {
    call(context, Callback::kMatch, [&](lua_State* lua) {
        push_text(lua, zone::kMatchEventNames[static_cast<std::size_t>(change.event)]);
        lua_pushinteger(lua, change.match.value);
        push_text(lua, change.kind);
        push_entity(lua, change.player);
        lua_pushinteger(lua, change.team + 1);
        push_text(lua, zone::kMatchRefusalNames[static_cast<std::size_t>(change.refusal)]);
        return 6;
    });
}

void ScriptRules::on_instance(zone::RulesContext& context, const zone::InstanceChange& change) {
    call(context, Callback::kInstance, [&](lua_State* lua) {
        push_text(lua, zone::kInstanceEventNames[static_cast<std::size_t>(change.event)]);
        lua_pushinteger(lua, change.instance.value);
        push_text(lua, change.kind);
        push_entity(lua, change.player);
        return 4;
    });
}

void ScriptRules::on_tick(zone::RulesContext& context) {
    call(context, Callback::kTick, [](lua_State*) { return 0; });
}

void ScriptRules::on_confirm(zone::RulesContext& context, ClientId client, EventId event) {
    call(context, Callback::kConfirm, [&](lua_State* lua) {
        lua_pushinteger(lua, client.value);
        lua_pushinteger(lua, static_cast<lua_Integer>(event.value));
        return 2;
    });
}

void ScriptRules::on_message(zone::RulesContext& context,
                             EntityId target,
                             std::span<const std::uint8_t> payload) {
    call(context, Callback::kMessage, [&](lua_State* lua) {
        push_entity(lua, target);
        push_bytes(lua, payload);
        return 2;
    });
}

void ScriptRules::on_store(zone::RulesContext& context, const mailbox::StoreAnswer& answer) {
    call(context, Callback::kStore, [&](lua_State* lua) {
        lua_pushinteger(lua, static_cast<lua_Integer>(answer.number));
        lua_pushstring(lua, name_of(answer.status));
        push_bytes(lua, answer.value);
        push_text(lua, answer.key.key);
        push_text(lua, answer.key.account);
        push_text(lua, answer.key.character);
        return 6;
    });
}

zone::Bytes ScriptRules::take_entity(EntityId entity) {
    zone::Bytes bytes;
    const StateKeyView key = std::int64_t{entity.value};
    if (const StateValue* const found = host_->entities->find(key)) {
        core::FieldWriter writer(bytes);
        write_table(writer, *std::get<std::shared_ptr<StateTable>>(*found));
        host_->entities->set(key, std::monostate());
    }
    return bytes;
}

void ScriptRules::load_entity(EntityId entity, std::span<const std::uint8_t> state) {
    if (state.empty()) {
        return;  // there was nothing to remember
    }
    core::FieldReader reader(state);
    const StateKeyView key = std::int64_t{entity.value};
    try {
        read_table(reader, *host_->entities->add_table(key));
    } catch (const StateIsFull&) {
        reader.fail("a script's state is larger than script.state_mb");
    }
    if (!reader.good() || reader.left() != 0) {
        host_->entities->set(key, std::monostate());
        host_->log(ScriptLine::kError,
                   "the state of an entity that came here is of no use: " + reader.wrong());
    }
}

template <class Archive>
void ScriptRules::serialize(Archive& archive) {
    archive(tick_, host_->awake_until, errors_);
    if constexpr (Archive::kReads) {
        read_table(archive, *host_->shared);
        read_table(archive, *host_->entities);
    } else {
        write_table(archive, *host_->shared);
        write_table(archive, *host_->entities);
    }
}

bool ScriptRules::save(zone::Bytes& out) const {
    out.push_back(kFormat);
    core::FieldWriter writer(out);
    const_cast<ScriptRules*>(this)->serialize(writer);  // which only reads
    return true;
}

std::string ScriptRules::load(std::span<const std::uint8_t> bytes) {
    if (bytes.empty() || bytes.front() != kFormat) {
        return "the script's state has another form";
    }
    core::FieldReader reader(bytes.subspan(1));
    serialize(reader);
    if (reader.good() && reader.left() != 0) {
        reader.fail("bytes are left over");
    }
    return reader.wrong();
}

std::string ScriptRules::go_on_from(const ScriptRules& before) {
    zone::Bytes bytes;
    (void)before.save(bytes);
    std::string wrong = load(bytes);
    errors_.fill(0);
    return wrong;
}

bool ScriptRules::busy() const {
    return host_->awake_until > tick_;
}

void ScriptRules::hash(core::StateHash& hash) const {
    host_->shared->hash_changes(hash);
    host_->entities->hash_changes(hash);
    hash.add(host_->awake_until);
    hash.add(errors());
}

}  // namespace zoned::scripting
