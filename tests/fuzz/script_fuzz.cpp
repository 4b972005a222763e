// Fuzzing of scripts: whatever clients send, the shipped script makes no error, and one that hands
// the bytes to every function that reads bytes does the same on every run.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/config/settings.h"
#include "server/scripting/script_rules.h"
#include "tests/fuzz/fuzz.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <string>

namespace zoned::fuzz {

namespace {

constexpr std::size_t kMostCommands = 32;

const std::string kProbe = R"(
local SCHEMA = "1 int a, 2 bytes b, 3 ints c, 4 double d, 5 sint e, 6 bool f, 7 float g"
local function probe(name, f, ...)
  local ok, result = pcall(f, ...)
  if ok and type(result) ~= "table" then state[name] = result end
end
function on_command(client, avatar, kind, payload)
  probe("decode", decode, payload, SCHEMA)
  probe("schema", decode, payload, payload)
  probe("encode", encode, { [payload] = kind, a = payload }, payload)
  probe("unpack", string.unpack, payload, payload)
  probe("pack", string.pack, payload, kind, payload, kind)
  probe("format", string.format, payload, kind, payload, kind)
  probe("number", tonumber, payload)
  probe("find", string.find, payload, payload:sub(-2))
  probe("split", string.split, payload, payload:sub(1, 1))
  probe("rep", string.rep, payload, kind * kind)
  probe("send", send, client, 16 + kind, payload, { confirm = kind % 2 == 0 })
  probe("publish", publish, payload, 16, payload)
  probe("put", store_put, avatar, payload, payload)
  probe("near", near, payload:byte(1, 4))
  probe("spawn", spawn, payload, payload:byte(1, 3))
  probe("state", function() state[payload] = { payload, [payload] = payload } end)
  probe("fields", function() for k, v in pairs(decode(payload, SCHEMA)) do state[k] = v end end)
end
)";

config::Settings arena_with(const std::string& source) {
    config::Settings read;
    std::vector<config::ConfigError> errors;
    const bool ok = config::load_settings(ZONED_SOURCE_DIR "/config/arena.txtpb", {}, read, errors);
    ZONED_ASSERT(ok && read.script, "the arena is a valid world");
    if (!source.empty()) {
        read.script->source = source;
    }
    return read;
}

std::uint64_t errors_of(const app::World& world) {
    std::uint64_t all = 0;
    for (const auto& zone : world.zones()) {
        const auto* rules = dynamic_cast<const scripting::ScriptRules*>(zone->state().rules.get());
        ZONED_ASSERT(rules != nullptr, "the arena's rules are a script");
        all += rules->errors();
    }
    return all;
}

/// Two players who send a tick's commands one after the other.
std::uint64_t play(app::World& world, std::span<const std::uint8_t> input) {
    std::vector<mailbox::OutboxItem> out;
    std::vector<mailbox::InboxItem> items = {
        mailbox::Join{ClientId(1), "ann", "red", 3, {-5.0, 0.0, 0.0}, "", false},
        mailbox::Join{ClientId(2), "bob", "blue", 3, {5.0, 0.0, 0.0}, "", false}};
    world.tick(items, out);
    Actions actions(input);
    std::uint8_t what = 0;
    std::span<const std::uint8_t> bytes;
    for (std::size_t i = 0; i < kMostCommands && actions.next(what, bytes); ++i) {
        mailbox::Command command;
        command.client = ClientId(1U + what % 2U);
        command.kind = static_cast<std::uint16_t>(what / 2);
        command.payload.assign(bytes.begin(), bytes.end());
        items.assign(1, command);
        out.clear();
        world.tick(items, out);
    }
    return world.state_hash();
}

}  // namespace

std::vector<Bytes> seeds() {
    std::vector<Bytes> all;
    for (const std::string& payload : {std::string("\x0a\x05world\x12\x02hi"),
                                       std::string("\x08\x05\x15\0\0\x80\x3f", 7),
                                       std::string("\x08\x0d"),
                                       std::string("1 int x, 2 bytes y"),
                                       std::string("<I4z"),
                                       std::string("%5.2f %s %q"),
                                       std::string("1e308"),
                                       std::string("ball")}) {
        Bytes seed;
        for (std::uint8_t kind = 1; kind < 8; ++kind) {
            Actions::add(static_cast<std::uint8_t>(2 * kind), payload, seed);
        }
        all.push_back(seed);
    }
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned;
    static const config::Settings kArena = fuzz::arena_with("");
    static const config::Settings kProbed = fuzz::arena_with(fuzz::kProbe);
    app::World arena(kArena, 1);
    fuzz::play(arena, {data, size});
    ZONED_ASSERT(fuzz::errors_of(arena) == 0, "the shipped script checks what clients send");
    app::World probed(kProbed, 1);
    app::World again(kProbed, 1);
    ZONED_ASSERT(fuzz::play(probed, {data, size}) == fuzz::play(again, {data, size}),
                 "a script does the same on every run");
    return 0;
}
