// Suite `scripting`: what rules in Lua cost beside the same rules in C++.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/scripting/script_rules.h"
#include "server/zone/context/zone_context.h"
#include "tests/bench/comparison.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace zoned::bench {

namespace {

constexpr int kInputAvatars = 1000;
constexpr int kInputFrames = 200;

/// Does as the linked rules (Sandbox::on_input): the stance follows stick and buttons.
const std::string kScript = R"(
local SPRINT = 2
function on_input(avatar, x, z, buttons)
  if is_hidden(avatar) then return end
  local own = entity_state(avatar)
  local moving = x ~= 0 or z ~= 0
  if moving then own.moved_at = now() end
  local stance = "normal"
  if is_carried(avatar) then
    stance = "riding"
  elseif moving and buttons & SPRINT ~= 0 then
    stance = "running"
  elseif now() - own.moved_at >= ticks(1) then
    stance = "idle"
  end
  set_stance(avatar, stance)
end
function on_join(client, avatar) entity_state(avatar).moved_at = now() end
)";

/// The cost of entering and leaving a script.
const std::string kEmptyScript = "function on_input(avatar, x, z, buttons) end\n";

config::Settings settings_with(const std::string& script) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    const bool good = config::parse_settings(
        "world { name: \"inputs\" min_x_m: -500 min_z_m: -500 max_x_m: 500 max_z_m: 500 }\n"
        "zones { zone_grid { columns: 1 rows: 1 } }\n"
        "type { name: \"player\" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } "
        "character { } }\n"
        "spawn { x_m: 0 z_m: 0 }\n"
        "lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }\n"
        "session { dev_mode_loopback: true }\n",
        {},
        settings,
        errors);
    if (!good) {
        throw std::runtime_error(config::format_errors("scripting", errors));
    }
    if (!script.empty()) {
        settings.script.emplace();
        settings.script->name = "bench.lua";
        settings.script->source = script;
    }
    return settings;
}

/// The rules of a real zone, whose players are there and give input.
class InputZone {
  public:
    explicit InputZone(const std::string& script) : world_(settings_with(script), 1) {
        zone::ZoneContext context(state());
        for (int i = 0; i < kInputAvatars; ++i) {
            zone::JoinRequest request;
            request.client = ClientId(static_cast<std::uint32_t>(i + 1));
            request.name = "player";
            request.spawn_position =
                Vec3(static_cast<float>(i % 32), 1.0F, static_cast<float>(i / 32));
            avatars_.push_back(state().rules->on_join(context, request));
        }
    }

    /// A thousand calls: players stand, walk and run in turns, each for itself.
    void give_inputs() {
        ++state().now;
        zone::ZoneContext context(state());
        for (int i = 0; i < kInputAvatars; ++i) {
            motion::InputCommand input;
            input.tick = state().now;
            const Tick phase = (state().now / 45 + i) % 3;
            input.move_x = phase != 0 ? 127 : 0;
            input.buttons = phase == 2 ? motion::kButtonSprint : 0;
            state().rules->on_input(context, avatars_[static_cast<std::size_t>(i)], input, 0);
        }
    }

    [[nodiscard]] const std::vector<std::uint8_t>& stances() { return state().entities.stance; }

    [[nodiscard]] std::uint64_t errors() {
        const auto* rules = dynamic_cast<const scripting::ScriptRules*>(state().rules.get());
        return rules != nullptr ? rules->errors() : 0;
    }

  private:
    zone::ZoneState& state() { return world_.zones()[0]->state(); }

    app::World world_;
    std::vector<EntityId> avatars_;
};

class InputTrial : public JudgedTrial {
  public:
    InputTrial(const std::string& script, bool same_as_linked)
        : zone_(script),
          same_as_linked_(same_as_linked) {}

    void frame() override {
        zone_.give_inputs();
        ++frames_;
    }

    /// Avatars in another stance than the linked rules give them after as many frames.
    void judge(Row& row) override {
        row.error_unit = "avatars";
        row.metric("script_errors", static_cast<double>(zone_.errors()));
        row.metric("calls", kInputAvatars);
        if (!same_as_linked_) {
            return;
        }
        InputZone linked("");
        for (int i = 0; i < frames_; ++i) {
            linked.give_inputs();
        }
        for (std::size_t row_of = 0; row_of < zone_.stances().size(); ++row_of) {
            row.error += zone_.stances()[row_of] != linked.stances()[row_of] ? 1.0 : 0.0;
        }
    }

  private:
    InputZone zone_;
    bool same_as_linked_;
    int frames_ = 0;
};

void run_scripting(Session& session) {
    const std::string scene = "inputs_1000";
    if (!session.wants_scene(scene)) {
        return;
    }
    session.note(
        "scripting: a frame is 1,000 calls of on_input in a zone with as many players; `default` "
        "are the linked rules, `lua` the same in a script, `lua_empty` a script that does nothing");
    session.progress("scripting " + scene);
    const auto as = [](const char* name, const std::string& script, bool same) {
        return Method{name, "", [&script, same] {
                          return std::make_unique<InputTrial>(script, same);
                      }};
    };
    static const std::string kNone;
    session.add(
        compare("scripting",
                scene,
                "",
                wanted(session,
                       {as("default", kNone, true),
                        as("lua", kScript, true),
                        as("lua_empty", kEmptyScript, false)}),
                {5, session.quick ? 20 : kInputFrames, session.quick ? 1 : session.repeats}));
}

const Registration kScripting({"scripting",
                               "rules in Lua: time of a thousand calls against linked rules",
                               {"inputs_1000"},
                               {"default", "lua", "lua_empty"},
                               run_scripting});

}  // namespace

}  // namespace zoned::bench
